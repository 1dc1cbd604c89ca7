//! Text files of scattered gonioreflectometer scans, `.brdf`. Layout: `crates/readers/src/scan.md`.

use crate::file_kind::{Begins, FileKind};
use crate::{colour, text};
use brdfc_formats::{FormatError, Place, memory};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::io::Write;

/// Scans as text: numbers.
pub static KIND: FileKind =
    FileKind { description: "a scan as text (.brdf)", extensions: &["brdf"], begins: Begins::Text(begins_a_scan) };

/// Maximum number of wavelengths of a scan.
pub const MAX_WAVELENGTHS: usize = 10_000;
/// Maximum number of rows of a scan.
pub const MAX_ROWS: usize = 1 << 22;
/// Largest value of a row, 1/sr.
pub const MAX_VALUE: f64 = 1e12;
/// Largest excess of a polar angle over π/2 that counts as rounding, radians; the angle is then set to π/2.
pub const HORIZON_TOLERANCE: f64 = 1e-4;

/// One measurement: a pair of directions and the value there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Polar angle of the incoming direction, `[0, π/2]`.
    pub theta_i: f64,
    /// Azimuth of the incoming direction.
    pub phi_i: f64,
    /// Polar angle of the outgoing direction, `[0, π/2]`.
    pub theta_o: f64,
    /// Azimuth of the outgoing direction.
    pub phi_o: f64,
    /// `f_r` in 1/sr, linear RGB. May be negative: noise, or a colour outside the gamut.
    pub value: [f64; 3],
}

/// A scattered scan in memory, with at least one row, in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scan {
    /// Wavelengths in nm, strictly increasing; empty if the file has RGB.
    pub wavelengths: Vec<f64>,
    /// Measurements, at most [`MAX_ROWS`].
    pub rows: Vec<Row>,
    /// Line of the file at which each row starts; empty without a file.
    pub lines: Vec<u64>,
    /// Power of ten of which all values of the spectra are multiples, by their decimals; absent for RGB, and without a file.
    pub step: Option<f64>,
}

impl Scan {
    /// Adds a row that starts at `line` of the file.
    pub(super) fn push(&mut self, row: Row, line: u64) -> Result<(), FormatError> {
        memory::push_within(&mut self.rows, row, MAX_ROWS, "rows")?;
        memory::push_within(&mut self.lines, line, MAX_ROWS, "rows")
    }

    /// Parses the text layout.
    ///
    /// # Errors
    /// Returns an error for invalid text, counts and numbers that do not parse, angles out of range, rows of the wrong
    /// length, no rows, and more than [`MAX_ROWS`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let text = text::checked_but_comments(bytes)?;
        let mut lines = (1u64..).zip(text.lines().map(|line| line.split('#').next().unwrap_or("")));
        let (wavelengths, header_end) = read_wavelengths(&mut lines, text.len())?;
        let weights = colour::rgb_weights(&wavelengths)
            .map_err(|error| FormatError { place: Place::Line(header_end), ..error })?;

        let width = 4 + wavelengths.len();
        let mut scan = Self { wavelengths, ..Self::default() };
        let mut last_place = i32::MAX;
        let mut numbers = Vec::with_capacity(width);
        let mut start = 0;
        let mut last = header_end;
        for (line, content) in lines {
            for token in content.split_ascii_whitespace() {
                if numbers.is_empty() {
                    start = line;
                }
                numbers.push(number(token, line, "value")?);
                if (5..=width).contains(&numbers.len()) {
                    last_place = last_place.min(last_place_of(token));
                }
            }
            last = line;
            if numbers.len() > width {
                break;
            }
            if numbers.len() == width {
                let mut value = [0.0; 3];
                for (spectral, weight) in numbers[4..].iter().zip(&weights) {
                    check_value(*spectral, line)?;
                    for channel in 0..3 {
                        value[channel] += weight[channel] * spectral;
                    }
                }
                scan.push(checked_row([numbers[0], numbers[1], numbers[2], numbers[3]], value, start)?, start)?;
                numbers.clear();
            }
        }
        if !numbers.is_empty() {
            return Err(FormatError::at_line(
                start,
                "row",
                format!("{} numbers up to line {last}", numbers.len()),
                format!("{width} numbers: 4 angles and a spectrum of {}", scan.wavelengths.len()),
            ));
        }
        if scan.rows.is_empty() {
            let allowed = "at least one row after the header";
            return Err(FormatError::at_line(last, "rows", "no measurements", allowed).problem());
        }
        scan.step = Some(10f64.powi(last_place));
        Ok(scan)
    }
}

/// Writes rows in the text layout with 31 bands from 400 to 700 nm.
///
/// The layout has spectra, not colours: each row gets the flattest spectrum (least squares) that reads back as its
/// colour. The spectrum of a saturated colour may be partly negative.
pub fn write(output: &mut impl Write, comment: &str, rows: &[Row]) -> std::io::Result<()> {
    let wavelengths: Vec<f64> = (0..31).map(|k| 400.0 + 10.0 * f64::from(k)).collect();
    let weights = colour::rgb_weights(&wavelengths).expect("31 wavelengths across the visible range");
    let shapes = spectral_shapes(&weights);
    for line in comment.lines() {
        writeln!(output, "# {line}")?;
    }
    let listed: Vec<String> = wavelengths.iter().map(f64::to_string).collect();
    writeln!(output, "# number of wavelengths\n{}\n# wavelengths, nm\n{}", listed.len(), listed.join(" "))?;
    writeln!(output, "# theta_i phi_i theta_o phi_o, then one value per wavelength")?;
    for row in rows {
        write!(output, "{:.6} {:.6} {:.6} {:.6}", row.theta_i, row.phi_i, row.theta_o, row.phi_o)?;
        let grey = row.value.iter().sum::<f64>() / 3.0;
        for shape in &shapes {
            let chroma: f64 = (0..3).map(|c| (row.value[c] - grey) * shape[c]).sum();
            write!(output, " {:.6e}", grey + chroma)?;
        }
        writeln!(output)?;
    }
    Ok(())
}

/// `W (WᵀW)⁻¹` for weights `W`: the smallest spectra whose colours are the unit vectors.
fn spectral_shapes(weights: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut gram = [[0.0; 3]; 3];
    for w in weights {
        for a in 0..3 {
            for b in 0..3 {
                gram[a][b] += w[a] * w[b];
            }
        }
    }
    // Inverse by cofactors of the cyclic neighbours.
    let cofactor = |a: usize, b: usize| {
        let (a1, a2, b1, b2) = ((a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3);
        gram[a1][b1] * gram[a2][b2] - gram[a1][b2] * gram[a2][b1]
    };
    let determinant: f64 = (0..3).map(|b| gram[0][b] * cofactor(0, b)).sum();
    weights
        .iter()
        .map(|w| [0, 1, 2].map(|c| (0..3).map(|a| w[a] * cofactor(c, a)).sum::<f64>() / determinant))
        .collect()
}

fn read_wavelengths<'a>(
    lines: &mut impl Iterator<Item = (u64, &'a str)>,
    length: usize,
) -> Result<(Vec<f64>, u64), FormatError> {
    let mut count = None;
    let mut wavelengths = Vec::new();
    let mut last = 1;
    for (line, content) in lines {
        last = line;
        for token in content.split_ascii_whitespace() {
            match count {
                None => {
                    let limit = MAX_WAVELENGTHS.min(length);
                    let parsed = token.parse::<usize>().ok().filter(|n| (1..=limit).contains(n));
                    count = Some(parsed.ok_or_else(|| {
                        FormatError::at_line(line, "wavelength count", quoted(token), format!("1 to {limit}"))
                    })?);
                }
                Some(_) => wavelengths.push(number(token, line, "wavelength")?),
            }
        }
        if let Some(count) = count
            && wavelengths.len() >= count
        {
            if wavelengths.len() > count {
                return Err(FormatError::at_line(
                    line,
                    "wavelengths",
                    format!("{} numbers", wavelengths.len()),
                    format!("{count}, the wavelength count"),
                ));
            }
            return Ok((wavelengths, line));
        }
    }
    Err(FormatError::at_line(
        last,
        if count.is_none() { "wavelength count" } else { "wavelengths" },
        if count.is_none() { "end of data".to_owned() } else { format!("end of data after {}", wavelengths.len()) },
        count.map_or("a number".to_owned(), |n| format!("{n} wavelengths")),
    )
    .problem())
}

/// Formats a token of a file in quotes, with escaped control characters and at most 40 characters.
pub(crate) fn quoted(token: &str) -> String {
    let short: String = token.chars().take(40).collect();
    let more = if short.len() < token.len() { "..." } else { "" };
    format!("\"{}{more}\"", short.escape_debug())
}

pub(crate) fn number(token: &str, line: u64, field: &'static str) -> Result<f64, FormatError> {
    token.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| {
        let hint = if has_decimal_comma(token) { "; use a decimal point" } else { "" };
        FormatError::at_line(line, field, quoted(token), format!("a finite number{hint}"))
    })
}

/// Power of ten of the last digit of a number: -3 for `0.250`, and for `2.50e-1`.
fn last_place_of(token: &str) -> i32 {
    let (digits, exponent) = token.split_once(['e', 'E']).unwrap_or((token, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
    exponent.parse().unwrap_or(0i32).saturating_sub(decimals)
}

/// Returns true if a token would be a number with a point instead of its comma.
pub(crate) fn has_decimal_comma(token: &str) -> bool {
    let digit = |c: char| c.is_ascii_digit();
    let parts = token.split_once(',').filter(|(whole, decimals)| whole.ends_with(digit) && decimals.starts_with(digit));
    parts.is_some_and(|(whole, decimals)| format!("{whole}.{decimals}").parse::<f64>().is_ok())
}

pub(super) fn check_value(value: f64, line: u64) -> Result<(), FormatError> {
    if value.abs() <= MAX_VALUE {
        return Ok(());
    }
    Err(FormatError::at_line(line, "value", value.to_string(), format!("-{MAX_VALUE:e} to {MAX_VALUE:e}")))
}

/// Description of valid azimuths, for errors of larger ones.
pub(super) const AZIMUTHS: &str = "-6.2832 to 6.2832 radians; this looks like degrees";

pub(super) fn checked_row(angles: [f64; 4], value: [f64; 3], line: u64) -> Result<Row, FormatError> {
    let [mut theta_i, phi_i, mut theta_o, phi_o] = angles;
    for (theta, field) in [(&mut theta_i, "theta_i"), (&mut theta_o, "theta_o")] {
        if !(0.0..=FRAC_PI_2 + HORIZON_TOLERANCE).contains(theta) {
            let hint = match *theta {
                t if t < 0.0 => "",
                t if t > 3.2 => "; this looks like degrees",
                _ => "; the direction is below the horizon",
            };
            let allowed = format!("0 to 1.5708 radians{hint}");
            return Err(FormatError::at_line(line, field, theta.to_string(), allowed));
        }
        *theta = theta.min(FRAC_PI_2);
    }
    for (phi, field) in [(phi_i, "phi_i"), (phi_o, "phi_o")] {
        if phi.abs() > TAU + HORIZON_TOLERANCE {
            return Err(FormatError::at_line(line, field, phi.to_string(), AZIMUTHS));
        }
    }
    Ok(Row { theta_i, phi_i, theta_o, phi_o, value })
}

/// Returns true if a text can begin a scan: the number of wavelengths, then numbers.
fn begins_a_scan(text: &str) -> bool {
    let mut lines =
        text.lines().map(|line| line.split('#').next().unwrap_or("").trim()).filter(|line| !line.is_empty());
    let mut words = lines.next().unwrap_or("").split_ascii_whitespace();
    let counts = words.next().is_some_and(|word| word.parse::<u32>().is_ok_and(|count| count > 0));
    // A list of lights begins with their number, too.
    let mut words = words.chain(lines.next().unwrap_or("").split_ascii_whitespace());
    counts && words.all(|word| word.parse::<f64>().is_ok() || has_decimal_comma(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "# a comment\n2\n# wls\n450 \n 600 # trailing\n\n0.1 0 0.2 0.3 1 1\n0.4 0 0.5\n -0.6 2 2\n";

    fn message(text: &str) -> String {
        Scan::from_bytes(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn rows_may_span_lines_and_flat_spectra_are_grey() {
        let scan = Scan::from_bytes(GOOD.as_bytes()).unwrap();
        assert_eq!(scan.wavelengths, [450.0, 600.0]);
        assert_eq!(scan.rows.len(), 2);
        assert_eq!(scan.step, Some(1.0));
        assert_eq!(["0.250", "2.50e-1", "7", "-3.5E2", "1e-400"].map(last_place_of), [-3, -3, 0, 1, -400]);
        let row = scan.rows[1];
        assert_eq!((row.theta_i, row.phi_i, row.theta_o, row.phi_o), (0.4, 0.0, 0.5, -0.6));
        for channel in row.value {
            assert!((channel - 2.0).abs() < 1e-12, "{channel}");
        }
    }

    #[test]
    fn scans_round_trip() {
        let row = Row { theta_i: 0.25, phi_i: 0.5, theta_o: 0.75, phi_o: -1.0, value: [0.125; 3] };
        let coloured = Row { value: [0.5, 0.25, 0.01], ..row };
        let mut bytes = Vec::new();
        write(&mut bytes, "made by a test", &[row, coloured]).unwrap();
        let read = Scan::from_bytes(&bytes).unwrap();
        for (written, read) in [row, coloured].iter().zip(&read.rows) {
            for channel in 0..3 {
                assert!((written.value[channel] - read.value[channel]).abs() < 1e-5, "{written:?} {read:?}");
            }
        }
    }

    #[test]
    fn errors_name_the_line() {
        assert!(message("").contains("wavelength count: end of data"));
        assert!(message("x").starts_with("line 1, wavelength count: found \"x\""));
        assert!(message("0").contains("expected 1 to"));
        assert!(message("99999999999").contains("expected 1 to"));
        assert!(message("2\n450").starts_with("line 2, wavelengths: end of data after 1"));
        assert!(message("2\n450 550 650").contains("found 3 numbers, expected 2"));
        assert!(message("2\n450 440\n").contains("line 2"));
        assert!(message("1\n550\n").contains("no measurements"));
        assert!(message("1\n550\n0 0 0 0\n").contains("line 3, row: found 4 numbers"));
        assert!(message("1\n550\n0 0 0 0 1 2\n").contains("expected 5 numbers"));
        assert!(message("1\n550\n0 0 0 0 nan\n").starts_with("line 3, value: found \"nan\""));
        assert!(message("1\n550\n0 0 0 0 1e400\n").contains("a finite number"));
        assert!(message("1\n550\n0 0 0 0 1e13\n").contains("-1e12 to 1e12"));
        assert!(message("1\n550\n2 0 0 0 1\n").contains("below the horizon"));
        assert!(message("1\n550\n45 0 0 0 1\n").contains("degrees"));
        assert!(message("1\n550\n0.1 0 0.1 180 1\n").contains("radians; this looks like degrees"));
        assert!(message("1\n550\n-0.1 0 0 0 1\n").contains("theta_i: found -0.1, expected 0 to 1.5708"));
        let error = Scan::from_bytes(b"1\n550\n\xff").unwrap_err().to_string();
        assert_eq!(error, "line 3, text: found byte 0xff, expected UTF-8");
    }

    #[test]
    fn every_truncation_is_an_error_or_whole_rows() {
        for length in 0..GOOD.len() {
            if let Ok(scan) = Scan::from_bytes(&GOOD.as_bytes()[..length]) {
                assert!(!scan.rows.is_empty());
            }
        }
    }
}
