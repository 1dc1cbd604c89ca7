//! Text tables of the ALTA library, `.dat`: scattered measurements whose header gives the parameterisation of
//! directions and values. Layout: `crates/readers/src/alta.md`.

use super::scan::{AZIMUTHS, Scan, check_value, checked_row, number, quoted};
use crate::file_kind::{Begins, FileKind, begins_with};
use crate::text;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::words::one_of;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Tables of ALTA: text with a line `#PARAM_IN` or `#DIM`.
pub static KIND: FileKind = FileKind {
    description: "a table of ALTA (.dat)",
    extensions: &["dat", "alta"],
    begins: Begins::Text(|text| text.lines().any(|line| begins_with(line, &["#PARAM_IN", "#DIM "]))),
};

/// Smallest cosine of the outgoing direction to the normal, for values that include that cosine: rows below it
/// determine no `f_r`.
pub const SMALLEST_COSINE: f64 = 0.01;

/// A table with its rows as a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct AltaTable {
    /// Rows above the horizon. Incoming is ALTA's light, outgoing its view.
    pub scan: Scan,
    /// Number of skipped rows: a direction is below the horizon, or nearly at the horizon if values include the cosine.
    pub left_out: usize,
    /// Parameterisation of directions, `PARAM_IN`.
    pub directions: &'static str,
    /// Quantity of the values, `PARAM_OUT`.
    pub values: &'static str,
    /// Number of values of a row: 1 or 3.
    pub channels: usize,
}

/// Parameterisation of the two directions of a row, ALTA's `PARAM_IN`.
struct Directions {
    name: &'static str,
    numbers: usize,
    /// Number of cosines before the other numbers.
    cosines: usize,
    /// Light and view.
    vectors: fn(&[f64]) -> [Vector; 2],
}

impl Directions {
    /// Returns true if the rotation about the normal is open, which requires isotropic materials.
    fn is_isotropic(&self) -> bool {
        self.numbers < 4
    }

    /// Returns true if the numbers are angles, false if they are components of vectors.
    fn has_angles(&self) -> bool {
        self.numbers < 6
    }
}

/// Quantity of a row's values, ALTA's `PARAM_OUT`.
struct Values {
    name: &'static str,
    /// True if values include the cosine of the view to the normal.
    cosine: bool,
    channels: &'static [usize],
}

const DIRECTIONS: [Directions; 12] = [
    Directions {
        name: "ISOTROPIC_TL_TV_PROJ_DPHI",
        numbers: 3,
        cosines: 0,
        vectors: |n| [meridian(n[0]), projected(n[1], n[2])],
    },
    Directions {
        name: "ISOTROPIC_TV_PROJ_DPHI",
        numbers: 2,
        cosines: 0,
        vectors: |n| [meridian(0.0), projected(n[0], n[1])],
    },
    Directions {
        name: "ISOTROPIC_TV_TL_DPHI",
        numbers: 3,
        cosines: 0,
        vectors: |n| [polar(n[1], n[2]), meridian(n[0])],
    },
    Directions {
        name: "SCHLICK_TL_TK_PROJ_DPHI",
        numbers: 3,
        cosines: 0,
        vectors: |n| back_vector(n[0], projected(n[1], n[2])),
    },
    Directions {
        name: "RUSIN_TH_TD_PD",
        numbers: 3,
        cosines: 0,
        vectors: |n| half_and_difference([n[0], 0.0], [n[1], n[2]]),
    },
    Directions {
        name: "RUSIN_TH_PH_TD_PD",
        numbers: 4,
        cosines: 0,
        vectors: |n| half_and_difference([n[0], n[1]], [n[2], n[3]]),
    },
    Directions { name: "RETRO_TL_TVL_PROJ_DPHI", numbers: 3, cosines: 0, vectors: |n| around_light(n[0], n[1], n[2]) },
    Directions {
        name: "RUSIN_TH_TD",
        numbers: 2,
        cosines: 0,
        vectors: |n| half_and_difference([n[0], 0.0], [n[1], FRAC_PI_2]),
    },
    Directions {
        name: "COS_TH_TD",
        numbers: 2,
        cosines: 2,
        vectors: |n| half_and_difference([n[0].acos(), 0.0], [n[1].acos(), 0.0]),
    },
    Directions {
        name: "COS_TH",
        numbers: 1,
        cosines: 1,
        vectors: |n| half_and_difference([n[0].acos(), 0.0], [0.0, 0.0]),
    },
    Directions {
        name: "SPHERICAL_TL_PL_TV_PV",
        numbers: 4,
        cosines: 0,
        vectors: |n| [polar(n[0], n[1]), polar(n[2], n[3])],
    },
    Directions { name: "CARTESIAN", numbers: 6, cosines: 0, vectors: |n| [[n[3], n[4], n[5]], [n[0], n[1], n[2]]] },
];

const VALUES: [Values; 3] = [
    Values { name: "INV_STERADIAN", cosine: false, channels: &[1, 3] },
    Values { name: "INV_STERADIAN_COSINE_FACTOR", cosine: true, channels: &[1, 3] },
    Values { name: "RGB_COLOR", cosine: false, channels: &[3] },
];

impl AltaTable {
    /// Parses a table.
    ///
    /// # Errors
    /// Returns an error for text that is not UTF-8, a header that lacks `DIM`, `PARAM_IN` or `PARAM_OUT` or has unknown
    /// values, rows of another length, numbers that do not parse, values out of range, and no rows above the horizon.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        refuse_binary(bytes)?;
        let text = text::checked_but_comments(bytes)?;
        let header = Header::read(&text)?;
        let width = header.directions.numbers + header.channels + header.bounds;
        let (mut scan, mut left_out) = (Scan::default(), 0);
        for (line, content) in (1u64..).zip(text.lines()).filter(|(_, content)| !content.trim_start().starts_with('#'))
        {
            let tokens: Vec<&str> = content.split_ascii_whitespace().collect();
            if tokens.is_empty() {
                continue;
            }
            let numbers =
                tokens.into_iter().map(|token| number(token, line, "value")).collect::<Result<Vec<_>, _>>()?;
            if numbers.len() != width {
                let allowed = format!("{width}, as in #DIM{}", if header.bounds > 0 { " and #VS" } else { "" });
                return Err(FormatError::at_line(line, "row", format!("{} numbers", numbers.len()), allowed));
            }
            let (directions, values) = numbers.split_at(header.directions.numbers);
            let beyond = |angle: &&f64| angle.abs() > TAU + ROUNDING;
            let (cosines, _) = directions.split_at(header.directions.cosines);
            if let Some(cosine) = cosines.iter().find(|cosine| !(-1.0..=1.0).contains(*cosine)) {
                return Err(FormatError::at_line(line, "cosine", cosine.to_string(), "-1 to 1"));
            }
            if let Some(angle) = directions.iter().find(beyond).filter(|_| header.directions.has_angles()) {
                return Err(FormatError::at_line(line, "angle", angle.to_string(), AZIMUTHS));
            }
            let [incoming, outgoing] = (header.directions.vectors)(directions).map(unit);
            let (Some(incoming), Some(outgoing)) = (incoming, outgoing) else {
                return Err(FormatError::at_line(line, "direction", "a vector of length 0", "two directions"));
            };
            let cosine = if header.values.cosine { outgoing[2] } else { 1.0 };
            if incoming[2] < -ROUNDING || outgoing[2] < -ROUNDING || cosine < SMALLEST_COSINE {
                left_out += 1;
                continue;
            }
            let value = std::array::from_fn(|channel| values[channel.min(header.channels - 1)] / cosine);
            value.iter().try_for_each(|channel| check_value(*channel, line))?;
            let ([theta_i, mut phi_i], [theta_o, mut phi_o]) = (angles(incoming), angles(outgoing));
            if header.directions.is_isotropic() {
                (phi_i, phi_o) = (0.0, phi_o - phi_i);
            }
            scan.push(checked_row([theta_i, phi_i, theta_o, phi_o], value, line)?, line)?;
        }
        if scan.rows.is_empty() {
            let found = match left_out {
                0 => "no measurements".to_owned(),
                _ => "no measurements above the horizon".to_owned(),
            };
            return Err(FormatError::whole("rows", found, "at least one measurement").problem());
        }
        let (directions, values) = (header.directions.name, header.values.name);
        Ok(Self { scan, left_out, directions, values, channels: header.channels })
    }
}

/// Largest distance below the horizon that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Contents of the lines that start with `#`.
struct Header {
    directions: &'static Directions,
    values: &'static Values,
    channels: usize,
    /// Columns of a row after its values that bound the values: their confidence intervals.
    bounds: usize,
}

impl Header {
    fn read(text: &str) -> Result<Self, FormatError> {
        let entry = |key: &str| {
            (1u64..).zip(text.lines()).find_map(|(line, content)| {
                let rest = content.trim_start().strip_prefix('#')?.strip_prefix(key)?;
                let is_whole = rest.is_empty() || rest.starts_with(|c: char| c.is_ascii_whitespace());
                is_whole.then(|| (line, rest.split_ascii_whitespace().collect::<Vec<_>>()))
            })
        };
        let needed = |key: &'static str| {
            let missing = || FormatError::whole(format!("#{key}"), "missing", format!("a line '#{key} ...'")).problem();
            entry(key).ok_or_else(missing)
        };
        let named = |key: &'static str| {
            let (line, words) = needed(key)?;
            Ok((line, words.join(" ")))
        };
        let (line, name) = named("PARAM_IN")?;
        let directions = DIRECTIONS.iter().find(|known| known.name == name).ok_or_else(|| {
            FormatError::at_line(line, "#PARAM_IN", quoted(&name), one_of(&DIRECTIONS.map(|known| known.name)))
        })?;
        let (line, name) = named("PARAM_OUT")?;
        let values = VALUES.iter().find(|known| known.name == name).ok_or_else(|| {
            FormatError::at_line(line, "#PARAM_OUT", quoted(&name), one_of(&VALUES.map(|known| known.name)))
        })?;
        let (line, words) = needed("DIM")?;
        let counts: Vec<Option<usize>> = words.iter().map(|word| word.parse().ok()).collect();
        let channels = match counts[..] {
            [Some(inputs), Some(channels)] if inputs == directions.numbers && values.channels.contains(&channels) => {
                channels
            }
            _ => {
                let dimensions = values.channels.iter().map(|count| format!("{} {count}", directions.numbers));
                let dimensions = one_of(&dimensions.collect::<Vec<_>>());
                let allowed = format!("{dimensions} for {} and {}", directions.name, values.name);
                return Err(FormatError::at_line(line, "#DIM", quoted(&words.join(" ")), allowed));
            }
        };
        // A single number is that of the first value, one per value otherwise.
        let bounds = entry("VS").map_or(Ok(0), |(line, words)| {
            let counts: Option<Vec<usize>> = words.iter().map(|word| word.parse().ok().filter(|n| *n <= 2)).collect();
            counts.filter(|counts| [1, channels].contains(&counts.len())).map(|counts| counts.iter().sum()).ok_or_else(
                || {
                    let allowed =
                        "0, 1 or 2: the number of columns of a confidence interval, for the first value or for each";
                    FormatError::at_line(line, "#VS", quoted(&words.join(" ")), allowed)
                },
            )
        })?;
        if let Some((line, words)) = entry("FORMAT").filter(|(_, words)| !is_text(&words.join(" "))) {
            return Err(wrong_format(line, &words.join(" ")));
        }
        Ok(Self { directions, values, channels, bounds })
    }
}

/// Rejects the binary form of tables by its header, before their numbers are taken as text.
fn refuse_binary(bytes: &[u8]) -> Result<(), FormatError> {
    let header = bytes.split(|byte| *byte == b'\n').take_while(|line| line.first().is_none_or(|byte| *byte == b'#'));
    for (line, content) in (1u64..).zip(header) {
        let content = String::from_utf8_lossy(content);
        if let Some(format) = content.strip_prefix("#FORMAT ").filter(|format| !is_text(format)) {
            return Err(wrong_format(line, format.trim()));
        }
    }
    Ok(())
}

fn is_text(format: &str) -> bool {
    format.trim().eq_ignore_ascii_case("TEXT")
}

fn wrong_format(line: u64, found: &str) -> FormatError {
    let allowed = "TEXT: binary tables are not supported; ALTA's data2data converts them to text";
    FormatError::at_line(line, "#FORMAT", quoted(found), allowed)
}

/// Light at polar angle `theta`, and the view at an angle from it that is the length of `(x, y)`; the azimuth of `(x, y)` about
/// the light is 0 towards the normal.
fn around_light(theta: f64, x: f64, y: f64) -> [Vector; 2] {
    let light = meridian(theta);
    // Towards the normal, along the sphere.
    let up = [-theta.cos(), 0.0, theta.sin()];
    let [sx, sy, cos] = projected(x, y);
    [light, [cos * light[0] + sx * up[0], sy, cos * light[2] + sx * up[2]]]
}

/// Direction with polar angle `theta` and azimuth `phi`.
fn polar(theta: f64, phi: f64) -> Vector {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// Direction with polar angle `theta` in the plane of x and z.
fn meridian(theta: f64) -> Vector {
    polar(theta, 0.0)
}

/// Direction whose polar angle is the length of `(x, y)`, with the azimuth of `(x, y)`.
fn projected(x: f64, y: f64) -> Vector {
    polar(x.hypot(y), y.atan2(x))
}

/// Light and view from half vector and difference vector, each given by polar angle and azimuth (Rusinkiewicz 1998).
/// ALTA's difference vector is the view in the frame of the half vector.
fn half_and_difference([theta_h, phi_h]: [f64; 2], [theta_d, phi_d]: [f64; 2]) -> [Vector; 2] {
    let [x, y, z] = polar(theta_d, phi_d);
    // About y by θ_h, then about z by φ_h.
    let (x, z) = (theta_h.cos() * x + theta_h.sin() * z, theta_h.cos() * z - theta_h.sin() * x);
    let view = [phi_h.cos() * x - phi_h.sin() * y, phi_h.sin() * x + phi_h.cos() * y, z];
    [mirrored(view, polar(theta_h, phi_h)), view]
}

/// Light at polar angle `theta`, and the view whose mirror direction is opposite to the light's about `back`, Schlick's
/// back vector: `v = 2 (r · k) k - r` with `r` the light's mirror direction.
fn back_vector(theta: f64, back: Vector) -> [Vector; 2] {
    let light = meridian(theta);
    [light, mirrored([-light[0], -light[1], light[2]], back)]
}

/// `2 (v · axis) axis - v`.
fn mirrored(v: Vector, axis: Vector) -> Vector {
    let twice = 2.0 * brdfc_formats::direction::dot(v, axis);
    std::array::from_fn(|k| twice * axis[k] - v[k])
}

fn unit(v: Vector) -> Option<Vector> {
    let largest = v.into_iter().map(f64::abs).fold(0.0, f64::max);
    // Squares of very short and very long vectors overflow or underflow.
    let v = v.map(|c| c / largest);
    let length = brdfc_formats::direction::dot(v, v).sqrt();
    length.is_finite().then(|| v.map(|c| c / length))
}

/// Polar angle and azimuth. Directions below the horizon within rounding are set to the horizon.
fn angles(v: Vector) -> [f64; 2] {
    [v[0].hypot(v[1]).atan2(v[2].max(0.0)), v[1].atan2(v[0])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Row;
    use brdfc_formats::direction::{DirectionPair, from_polar, half_vector};

    fn table(input: &str, output: &str, dimensions: &str, rows: &str) -> Result<AltaTable, FormatError> {
        let text = format!("#DIM {dimensions}\n#PARAM_IN {input}\n#PARAM_OUT {output}\n{rows}\n");
        AltaTable::from_bytes(text.as_bytes())
    }

    fn message(input: &str, output: &str, dimensions: &str, rows: &str) -> String {
        table(input, output, dimensions, rows).unwrap_err().to_string()
    }

    fn pair(row: Row) -> DirectionPair {
        DirectionPair::from_angles(row.theta_i, row.phi_i, row.theta_o, row.phi_o)
    }

    fn close(a: Vector, b: Vector) -> bool {
        (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12)
    }

    /// One pair of directions in all parameterisations.
    #[test]
    fn parameterisations_agree() {
        let (light, view) = (from_polar(0.5, 0.0), from_polar(0.8, 1.1));
        let half = half_vector(DirectionPair::new(light, view));
        let [theta_h, phi_h] = angles(half);
        // The view in the frame of the half vector: about z by -φ_h, about y by -θ_h.
        let [x, y] = [phi_h.cos() * view[0] + phi_h.sin() * view[1], phi_h.cos() * view[1] - phi_h.sin() * view[0]];
        let difference = [theta_h.cos() * x - theta_h.sin() * view[2], y, theta_h.sin() * x + theta_h.cos() * view[2]];
        let [theta_d, phi_d] = angles(difference);
        let back = unit([view[0] - light[0], view[1] - light[1], view[2] + light[2]]).unwrap();
        let [theta_k, phi_k] = angles(back);
        // The view about the light: its angle, and its azimuth from the arc to the normal, by the law of cosines.
        let theta_vl = brdfc_formats::direction::dot(light, view).acos();
        let cos_vl = (view[2] - light[2] * theta_vl.cos()) / (0.5f64.sin() * theta_vl.sin());
        let phi_vl = cos_vl.acos();
        let on_plane = |theta: f64, phi: f64| format!("{} {}", theta * phi.cos(), theta * phi.sin());
        for (name, numbers) in [
            ("ISOTROPIC_TL_TV_PROJ_DPHI", format!("0.5 {}", on_plane(0.8, 1.1))),
            ("SCHLICK_TL_TK_PROJ_DPHI", format!("0.5 {}", on_plane(theta_k, phi_k))),
            ("RUSIN_TH_PH_TD_PD", format!("{theta_h} {phi_h} {theta_d} {phi_d}")),
            ("RETRO_TL_TVL_PROJ_DPHI", format!("0.5 {}", on_plane(theta_vl, phi_vl))),
            ("SPHERICAL_TL_PL_TV_PV", "0.5 0 0.8 1.1".to_owned()),
            ("CARTESIAN", format!("{} {} {} {} {} {}", view[0], view[1], view[2], 2.0 * light[0], 0.0, 2.0 * light[2])),
        ] {
            let count = numbers.split(' ').count();
            let row =
                table(name, "INV_STERADIAN", &format!("{count} 1"), &format!("{numbers} 2.5")).unwrap().scan.rows[0];
            let found = pair(row);
            assert!(close(found.incoming, light) && close(found.outgoing, view), "{name}: {found:?}");
            assert_eq!(row.value, [2.5; 3]);
        }
        // Two parameterisations leave the rotation about the normal open: isotropic, so rows are rotated to the light's
        // azimuth.
        for (name, numbers) in [
            ("ISOTROPIC_TV_TL_DPHI", "0.8 0.5 -1.1".to_owned()),
            ("RUSIN_TH_TD_PD", format!("{theta_h} {theta_d} {phi_d}")),
        ] {
            let row = table(name, "INV_STERADIAN", "3 1", &format!("{numbers} 1")).unwrap().scan.rows[0];
            assert!((row.theta_i - 0.5).abs() < 1e-12 && (row.theta_o - 0.8).abs() < 1e-12, "{name}");
            assert_eq!(row.phi_i, 0.0, "{name}");
            let turn = row.phi_o.rem_euclid(TAU);
            assert!((turn - 1.1).abs() < 1e-12, "{name}: {turn}");
        }
        let row = table("ISOTROPIC_TV_PROJ_DPHI", "INV_STERADIAN", "2 1", "0 0.3 1").unwrap().scan.rows[0];
        assert!(row.theta_i == 0.0 && (row.theta_o - 0.3).abs() < 1e-12, "{row:?}");
    }

    #[test]
    fn cosines_and_confidence_intervals_are_read() {
        let (theta_h, theta_d) = (0.4f64, 0.3f64);
        let row = |name: &str, text: String| {
            let count = text.split(' ').count();
            let table = table(name, "INV_STERADIAN", &format!("{count} 1"), &format!("{text} 7")).unwrap();
            (pair(table.scan.rows[0]), table.scan.rows[0].value)
        };
        let angles_of = |pair: DirectionPair| {
            let half = half_vector(pair);
            [angles(half)[0], brdfc_formats::direction::dot(pair.outgoing, half).acos()]
        };
        for (name, text, expected) in [
            ("COS_TH", format!("{}", theta_h.cos()), [theta_h, 0.0]),
            ("COS_TH_TD", format!("{} {}", theta_h.cos(), theta_d.cos()), [theta_h, theta_d]),
            ("RUSIN_TH_TD", format!("{theta_h} {theta_d}"), [theta_h, theta_d]),
        ] {
            let (pair, value) = row(name, text);
            let found = angles_of(pair);
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-7) && value == [7.0; 3], "{name}: {found:?}");
        }
        let values = |vs: &str, dimensions: &str, row: &str| {
            let rows = format!("#VS {vs}\n{row}");
            table("ISOTROPIC_TL_TV_PROJ_DPHI", "INV_STERADIAN", dimensions, &rows).unwrap().scan.rows[0].value
        };
        assert_eq!(values("1", "3 1", "0.1 0.2 0 3 0.5"), [3.0; 3]);
        assert_eq!(values("2", "3 1", "0.1 0.2 0 3 2.5 3.5"), [3.0; 3]);
        assert_eq!(values("2 1 0", "3 3", "0.1 0.2 0 3 4 5 2.5 3.5 0.1"), [3.0, 4.0, 5.0]);
        assert_eq!(values("1", "3 3", "0.1 0.2 0 3 4 5 0.1"), [3.0, 4.0, 5.0]);
    }

    #[test]
    fn binary_tables_are_named() {
        let header = "#DIM 3 1\n#PARAM_IN CARTESIAN\n#PARAM_OUT INV_STERADIAN\n#FORMAT binary\n#BEGIN_STREAM\n";
        let bytes = [header.as_bytes(), &0.5f64.to_le_bytes()].concat();
        let message = AltaTable::from_bytes(&bytes).unwrap_err().to_string();
        assert!(message.starts_with("line 4, #FORMAT: found \"binary\", expected TEXT: binary tables"), "{message}");
        let latin =
            b"#DIM 3 1\n# Caf\xe9\n#PARAM_IN RUSIN_TH_TD_PD\n#PARAM_OUT INV_STERADIAN\n#FORMAT text\n0.1 0.2 0 3\n";
        assert_eq!(AltaTable::from_bytes(latin).unwrap().scan.rows.len(), 1);
    }

    #[test]
    fn values_lose_their_cosine_and_rows_at_the_horizon_are_left_out() {
        let rows = "0.2 0.5 0 3\n0.2 1.5707 0 3\n0.2 1.7 0 3\n0.2 0 -0.5 3";
        let table = table("ISOTROPIC_TL_TV_PROJ_DPHI", "INV_STERADIAN_COSINE_FACTOR", "3 1", rows).unwrap();
        assert_eq!((table.scan.rows.len(), table.left_out), (2, 2));
        for row in &table.scan.rows {
            assert!((row.value[0] - 3.0 / 0.5f64.cos()).abs() < 1e-12, "{row:?}");
        }
    }

    #[test]
    fn colours_are_separate() {
        let table = table("SPHERICAL_TL_PL_TV_PV", "RGB_COLOR", "4 3", "0 0 0.1 0 1 2 3").unwrap();
        assert_eq!(table.scan.rows[0].value, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn errors_name_the_line_and_valid_values() {
        let good = "ISOTROPIC_TL_TV_PROJ_DPHI";
        for (found, expected) in [
            (
                message("BARYCENTRIC_ALPHA_SIGMA", "INV_STERADIAN", "2 1", "0 0 1"),
                "line 2, #PARAM_IN: found \"BARYCENTRIC_ALPHA_SIGMA\", expected ISOTROPIC_TL_TV_PROJ_DPHI, ISOTROPIC_TV_",
            ),
            (
                message(good, "ENERGY", "3 1", "0 0 0 1"),
                "line 3, #PARAM_OUT: found \"ENERGY\", expected INV_STERADIAN, INV_STERADIAN_COSINE_FACTOR or RGB_",
            ),
            (
                message(good, "INV_STERADIAN", "2 1", "0 0 1"),
                "line 1, #DIM: found \"2 1\", expected 3 1 or 3 3 for ISOTROPIC_TL_TV_PROJ_DPHI and INV_STERADIAN",
            ),
            (
                message(good, "INV_STERADIAN", "3 1", "30 0.1 0.2 1"),
                "line 4, angle: found 30, expected -6.2832 to 6.2832 radians; this looks like degrees",
            ),
            (message(good, "INV_STERADIAN", "3 1", "0,0,0,1"), "line 4, value: found \"0,0,0,1\", expected a finite"),
            (
                message("RGB_COLOR extra", "INV_STERADIAN", "3 1", "0 0 0 1"),
                "line 2, #PARAM_IN: found \"RGB_COLOR extra\", expected ISOTROPIC_TL",
            ),
            (message(good, "INV_STERADIAN", "3 1", "0 0 0"), "line 4, row: found 3 numbers, expected 4, as in #DIM"),
            (message(good, "INV_STERADIAN", "3 1", "0 0 x 1"), "line 4, value: found \"x\", expected a finite number"),
            (
                message(good, "INV_STERADIAN", "3 1", "0 0 0 1e13"),
                "line 4, value: found 10000000000000, expected -1e12",
            ),
            (message(good, "INV_STERADIAN", "3 1", ""), "rows: no measurements; expected at least one measurement"),
            (
                message(good, "INV_STERADIAN", "3 1", "0 2 0 1"),
                "rows: no measurements above the horizon; expected at least one measurement",
            ),
            (
                message("CARTESIAN", "INV_STERADIAN", "6 1", "0 0 0 0 0 1 1"),
                "line 4, direction: found a vector of length 0",
            ),
            (message(good, "INV_STERADIAN", "3 1", "#VS 3\n0 0 0 1"), "line 4, #VS: found \"3\", expected 0, 1 or 2"),
            (
                message(good, "INV_STERADIAN", "3 3", "#VS 1 1\n0 0 0 1"),
                "line 4, #VS: found \"1 1\", expected 0, 1 or 2",
            ),
            (
                message(good, "INV_STERADIAN", "3 1", "#VS 2\n0 0 0 1"),
                "line 5, row: found 4 numbers, expected 6, as in #DIM and #VS",
            ),
            (message("COS_TH", "INV_STERADIAN", "1 1", "1.5 1"), "line 4, cosine: found 1.5, expected -1 to 1"),
            (
                message(good, "INV_STERADIAN", "3 1", "#FORMAT BINARY"),
                "line 4, #FORMAT: found \"BINARY\", expected TEXT",
            ),
        ] {
            assert!(found.starts_with(expected), "{found}\n{expected}");
        }
        let bare = AltaTable::from_bytes(b"0 0 0 1\n").unwrap_err().to_string();
        assert_eq!(bare, "#PARAM_IN: missing; expected a line '#PARAM_IN ...'");
        assert!(AltaTable::from_bytes(b"\xff").is_err());
    }

    #[test]
    fn every_truncation_is_an_error_or_whole_rows() {
        let text = "#DIM 3 1\n#VS 0\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n#PARAM_OUT INV_STERADIAN\n0.1 0.2 0.3 0.4\n0.1 0.3 0.3 0.5\n";
        for end in 0..text.len() {
            if let Ok(table) = AltaTable::from_bytes(&text.as_bytes()[..end]) {
                assert!((1..=2).contains(&table.scan.rows.len()), "{end}");
            }
        }
    }
}
