//! MERL `.binary`: a dense isotropic table over half and difference angles. Layout: `crates/readers/src/merl.md`.

use crate::file_kind::{Begins, FileKind};
use brdfc_formats::direction::{DirectionPair, from_polar, rotate_from_normal};
use brdfc_formats::{FormatError, memory};
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::{Read, Seek, SeekFrom, Write};

/// MERL tables: their length matches the header.
pub static KIND: FileKind = FileKind {
    description: "a MERL table (.binary)",
    extensions: &["binary"],
    begins: Begins::Fitting(|start, length| Dimensions::from_header(start, length).is_ok()),
};

/// Size of the header: three little-endian `i32`.
pub const HEADER_BYTES: u64 = 12;
/// Factors from stored numbers to `f_r` in 1/sr, for R, G and B.
pub const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Maximum number of samples per axis.
pub const MAX_DIMENSION: usize = 4096;
/// Largest stored number, far above any reflectance; the limit keeps single precision safe.
pub const MAX_STORED: f64 = 1e30;

/// Number of samples along each angle, in the order of the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimensions {
    /// Half vector's polar angle, `[0, π/2)`, square-root warped.
    pub theta_half: usize,
    /// Difference vector's polar angle, `[0, π/2)`.
    pub theta_difference: usize,
    /// Difference vector's azimuth, `[0, π)`, or `[0, 2π)`: see [`Dimensions::azimuth_period`].
    pub phi_difference: usize,
}

impl Dimensions {
    /// The dimensions of the MERL database.
    pub const MERL: Self = Self { theta_half: 90, theta_difference: 90, phi_difference: 180 };

    /// Maximum number of cells of a written table.
    pub const MAX_CELLS: usize = 1 << 28;

    /// Checks the sides and their product.
    ///
    /// # Errors
    /// Returns an error for a side that is not 1 to [`MAX_DIMENSION`], and for more than [`Self::MAX_CELLS`] cells.
    pub fn check_for_writing(self) -> Result<(), FormatError> {
        let Self { theta_half, theta_difference, phi_difference } = self;
        let sides = [theta_half, theta_difference, phi_difference];
        if sides.iter().all(|n| (1..=MAX_DIMENSION).contains(n)) && self.cells() <= Self::MAX_CELLS {
            return Ok(());
        }
        let allowed =
            format!("three numbers from 1 to {MAX_DIMENSION}, such as 90x90x180, of at most {} cells", Self::MAX_CELLS);
        Err(FormatError::whole("dimensions", sides.map(|n| n.to_string()).join("x"), allowed))
    }

    /// Number of cells of one colour plane.
    pub fn cells(self) -> usize {
        self.theta_half * self.theta_difference * self.phi_difference
    }

    /// Period of the azimuth. π, because reciprocity makes half a turn enough, and the database stores no more. 2π if
    /// there are four azimuths per theta_d sample (90 x 90 x 360), the layout of full-turn files.
    pub fn azimuth_period(self) -> f64 {
        if self.is_full_turn() { 2.0 * PI } else { PI }
    }

    /// Returns true if the azimuths cover a full turn.
    pub fn is_full_turn(self) -> bool {
        self.phi_difference == 4 * self.theta_difference
    }

    /// Angles `(theta_half, theta_difference, phi_difference)` of the sample with these indices, radians.
    ///
    /// Samples are on the lower edges of their bins, so index 0 is angle 0: `theta_h = (i/n)² π/2`.
    pub fn sample_angles(self, i: usize, j: usize, k: usize) -> [f64; 3] {
        let u = i as f64 / self.theta_half as f64;
        [
            u * u * FRAC_PI_2,
            j as f64 / self.theta_difference as f64 * FRAC_PI_2,
            k as f64 / self.phi_difference as f64 * self.azimuth_period(),
        ]
    }

    /// The direction pair of the sample with these indices.
    pub fn pair(self, i: usize, j: usize, k: usize) -> DirectionPair {
        pair_of_angles(self.sample_angles(i, j, k))
    }

    /// Returns, for each cell, whether both directions of its sample are above the horizon.
    fn above_horizon(self) -> impl Fn(usize) -> bool {
        /// Heights of directions are within rounding of 0 below this.
        const ROUNDING: f64 = 1e-12;
        let table = |count: usize, angle: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            (0..count).map(|at| angle(at).sin_cos()).collect()
        };
        let half = table(self.theta_half, &|i| self.sample_angles(i, 0, 0)[0]);
        let difference = table(self.theta_difference, &|j| self.sample_angles(0, j, 0)[1]);
        let azimuth = table(self.phi_difference, &|k| self.sample_angles(0, 0, k)[2]);
        move |cell| {
            let (ring, k) = (cell / self.phi_difference, cell % self.phi_difference);
            let (i, j) = (ring / self.theta_difference, ring % self.theta_difference);
            let ((sin_h, cos_h), (sin_d, cos_d)) = (half[i], difference[j]);
            // The lower one of both directions.
            let height = cos_h * cos_d - (sin_h * sin_d * azimuth[k].1).abs();
            if height.abs() > ROUNDING { height > 0.0 } else { self.pair(i, j, k).is_above_horizon() }
        }
    }

    /// Reads the header at the beginning of `start`, for a file of `length` bytes.
    ///
    /// # Errors
    /// Returns an error for a truncated header, and for dimensions that are out of range or do not match `length`.
    pub fn from_header(start: &[u8], length: u64) -> Result<Self, FormatError> {
        let fields = start.as_chunks::<4>().0;
        let [a, b, c] = *fields.first_chunk::<3>().ok_or_else(|| too_short(start.len() as u64))?;
        Self::check([a, b, c].map(i32::from_le_bytes), length)
    }

    fn check(raw: [i32; 3], length: u64) -> Result<Self, FormatError> {
        const NAMES: [&str; 3] = ["theta_h count", "theta_d count", "phi_d count"];
        for (axis, value) in raw.into_iter().enumerate() {
            if !(1..=MAX_DIMENSION as i32).contains(&value) {
                return Err(FormatError::at_byte(
                    4 * axis as u64,
                    NAMES[axis],
                    value.to_string(),
                    format!("1 to {MAX_DIMENSION}"),
                ));
            }
        }
        let dimensions =
            Self { theta_half: raw[0] as usize, theta_difference: raw[1] as usize, phi_difference: raw[2] as usize };
        let expected = HEADER_BYTES + 24 * raw.into_iter().map(|v| v as u64).product::<u64>();
        if length != expected {
            return Err(FormatError::whole(
                "file length",
                format!("{length} bytes"),
                format!("{expected} bytes for a table of {} x {} x {}", raw[0], raw[1], raw[2]),
            ));
        }
        Ok(dimensions)
    }
}

/// A pair with these half and difference angles, radians; the half vector is at the tangent's azimuth.
pub fn pair_of_angles([theta_h, theta_d, phi_d]: [f64; 3]) -> DirectionPair {
    let half = from_polar(theta_h, 0.0);
    DirectionPair::new(
        rotate_from_normal(half, from_polar(theta_d, phi_d)),
        rotate_from_normal(half, from_polar(theta_d, phi_d + PI)),
    )
}

/// A MERL table in memory.
#[derive(Debug, Clone)]
pub struct Merl {
    /// Number of samples along `θ_h`, `θ_d` and `φ_d`.
    pub dimensions: Dimensions,
    /// `f_r` in 1/sr, `[theta_h][theta_d][phi_d]`, phi_d fastest. NaN in all channels if the cell is invalid: not
    /// measured (a negative number in any channel of the file), or with a direction below the horizon, where some programs write 0.
    pub values: Vec<[f32; 3]>,
    /// Number of cells with a measurement, at least 1.
    pub valid_cells: usize,
    /// Number of cells above the horizon without one.
    pub missing_cells: usize,
}

impl Merl {
    /// Reads a file of known `length` through small buffers, one for each of the three colour planes.
    ///
    /// # Errors
    /// Returns an error for dimensions that are out of range or do not match `length`, more cells than there is memory
    /// for, a read that ends early or fails, NaN, infinite or absurd numbers, and no valid cell.
    pub fn read(mut input: impl Read + Seek, length: u64) -> Result<Self, MerlError> {
        const BLOCK: usize = 1 << 13;
        let mut header = [0u8; HEADER_BYTES as usize];
        if length < HEADER_BYTES {
            return Err(too_short(length).into());
        }
        read_exact(&mut input, &mut header, 0)?;
        let dimensions = Dimensions::from_header(&header, length)?;

        let cells = dimensions.cells();
        let mut values: Vec<[f32; 3]> = memory::reserved("table", cells)?;
        let mut buffer = vec![0u8; 8 * BLOCK.min(cells)];
        let (mut valid_cells, mut missing_cells) = (0, 0);
        let is_above = dimensions.above_horizon();
        for block in 0..cells.div_ceil(BLOCK) {
            values.resize(cells.min((block + 1) * BLOCK), [0.0; 3]);
            let block_values = &mut values[block * BLOCK..];
            for (channel, scale) in SCALES.into_iter().enumerate() {
                let offset = HEADER_BYTES + 8 * (channel * cells + block * BLOCK) as u64;
                let bytes = &mut buffer[..8 * block_values.len()];
                input.seek(SeekFrom::Start(offset)).map_err(MerlError::Io)?;
                read_exact(&mut input, bytes, offset)?;
                let mut clean = true;
                for (value, raw) in block_values.iter_mut().zip(bytes.as_chunks::<8>().0) {
                    let number = f64::from_le_bytes(*raw);
                    clean &= number.abs() <= MAX_STORED;
                    value[channel] = if number < 0.0 { f32::NAN } else { (number * scale) as f32 };
                }
                if !clean {
                    return Err(bad_number(bytes, offset).into());
                }
            }
            for (cell, value) in block_values.iter_mut().enumerate() {
                let is_above = is_above(block * BLOCK + cell);
                if !is_above || value.iter().any(|v| v.is_nan()) {
                    *value = [f32::NAN; 3];
                    missing_cells += usize::from(is_above);
                } else {
                    valid_cells += 1;
                }
            }
        }
        if valid_cells == 0 {
            return Err(FormatError::whole(
                "table",
                "no valid measurement, because every cell above the horizon has a negative number",
                "at least one cell above the horizon without negative numbers",
            )
            .problem()
            .into());
        }
        Ok(Self { dimensions, values, valid_cells, missing_cells })
    }

    /// Reads from bytes in memory.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MerlError> {
        Self::read(std::io::Cursor::new(bytes), bytes.len() as u64)
    }

    /// Returns true if every cell equals its mirror image (`phi_d` to `-phi_d`) to within a fraction `tolerance`.
    pub fn is_mirror_symmetric(&self, tolerance: f32) -> bool {
        self.is_unchanged_by(|k, n| if k == 0 { 0 } else { n - k }, tolerance)
    }

    /// Returns true if every cell equals its reciprocal (`phi_d` to `phi_d + π`) to within a fraction `tolerance`.
    /// Always true if the azimuths cover half a turn.
    pub fn is_reciprocal(&self, tolerance: f32) -> bool {
        !self.dimensions.is_full_turn()
            || self.is_unchanged_by(|k, n| if k + n / 2 < n { k + n / 2 } else { k + n / 2 - n }, tolerance)
    }

    /// Stops at the first ring with a difference, which is early in measured data.
    fn is_unchanged_by(&self, partner: impl Fn(usize, usize) -> usize, tolerance: f32) -> bool {
        let n = self.dimensions.phi_difference;
        self.values.chunks_exact(n).all(|ring| {
            (0..=n / 2).fold(true, |all, k| {
                let (value, other) = (ring[k], ring[partner(k, n)]);
                let both_invalid = value[0].is_nan() & other[0].is_nan();
                let close = |c: usize| (value[c] - other[c]).abs() <= tolerance * value[c].max(other[c]);
                all & (both_invalid | (close(0) & close(1) & close(2)))
            })
        })
    }
}

/// Writes a MERL file. `value(theta_h, theta_d, phi_d)` gives `f_r` in 1/sr, or `None` for an invalid cell, stored as
/// -1.
pub fn write(
    output: &mut impl Write,
    dimensions: Dimensions,
    value: impl Fn([f64; 3]) -> Option<[f64; 3]>,
) -> std::io::Result<()> {
    for n in [dimensions.theta_half, dimensions.theta_difference, dimensions.phi_difference] {
        output.write_all(&(n as i32).to_le_bytes())?;
    }
    let mut planes = [(); 3].map(|()| Vec::with_capacity(dimensions.cells()));
    for i in 0..dimensions.theta_half {
        for j in 0..dimensions.theta_difference {
            for k in 0..dimensions.phi_difference {
                let cell = value(dimensions.sample_angles(i, j, k));
                for channel in 0..3 {
                    planes[channel].push(cell.map_or(-1.0, |f| f[channel] / SCALES[channel]));
                }
            }
        }
    }
    for plane in planes {
        for number in plane {
            output.write_all(&f64::to_le_bytes(number))?;
        }
    }
    Ok(())
}

/// Error of reading a MERL file: of the disk, or of the contents.
#[derive(Debug, thiserror::Error)]
pub enum MerlError {
    /// The file violates the layout.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The input could not be read.
    #[error(transparent)]
    Io(std::io::Error),
}

fn too_short(length: u64) -> FormatError {
    FormatError::whole("file length", format!("{length} bytes"), "at least 12 bytes")
}

fn read_exact(input: &mut impl Read, buffer: &mut [u8], offset: u64) -> Result<(), MerlError> {
    let needed = buffer.len();
    input.read_exact(buffer).map_err(|error| {
        if error.kind() == std::io::ErrorKind::UnexpectedEof {
            FormatError::at_byte(offset, "table", "end of data", format!("{needed} more bytes")).problem().into()
        } else {
            MerlError::Io(error)
        }
    })
}

fn bad_number(bytes: &[u8], offset: u64) -> FormatError {
    for (k, raw) in bytes.as_chunks::<8>().0.iter().enumerate() {
        let number = f64::from_le_bytes(*raw);
        if number.is_nan() || number.abs() > MAX_STORED {
            return FormatError::at_byte(
                offset + 8 * k as u64,
                "table",
                number.to_string(),
                format!("0 to {MAX_STORED:e}, or negative for an invalid cell"),
            );
        }
    }
    FormatError::at_byte(offset, "table", "unreadable number", "finite numbers").problem()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Dimensions = Dimensions { theta_half: 3, theta_difference: 4, phi_difference: 5 };

    fn file(dimensions: Dimensions, value: impl Fn([f64; 3]) -> Option<[f64; 3]>) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, dimensions, value).unwrap();
        bytes
    }

    fn message(bytes: &[u8]) -> String {
        Merl::from_bytes(bytes).unwrap_err().to_string()
    }

    #[test]
    fn files_round_trip() {
        let bytes = file(SMALL, |[h, d, p]| (d < 1.0).then_some([h, 10.0 + d, p]));
        let merl = Merl::from_bytes(&bytes).unwrap();
        assert_eq!(merl.dimensions, SMALL);
        let above = |d: f64, [i, j, k]: [usize; 3]| d < 1.0 && SMALL.pair(i, j, k).is_above_horizon();
        let cells = (0..3 * 4 * 5).map(|cell| [cell / 20, cell / 5 % 4, cell % 5]);
        let valid = cells.filter(|at| above(SMALL.sample_angles(0, at[1], 0)[1], *at)).count();
        assert_eq!(merl.valid_cells, valid);
        let [h, d, p] = SMALL.sample_angles(2, 1, 3);
        let value = merl.values[(2 * 4 + 1) * 5 + 3];
        for (read, written) in value.into_iter().zip([h, 10.0 + d, p]) {
            assert!((f64::from(read) - written).abs() < 1e-6, "{read} {written}");
        }
        assert!(merl.values[3 * 5][0].is_nan(), "theta_d = 67.5 degrees was written as invalid");
    }

    #[test]
    fn any_negative_channel_makes_a_cell_invalid() {
        let bytes = file(SMALL, |[h, ..]| Some([1.0, if h > 0.0 { -0.5 } else { 1.0 }, 1.0]));
        assert_eq!(Merl::from_bytes(&bytes).unwrap().valid_cells, 4 * 5);
    }

    /// Cells below the horizon do not count, whether they hold 0, 1 or -1.
    #[test]
    fn cells_below_the_horizon_are_never_valid() {
        let n = Dimensions { theta_half: 9, theta_difference: 9, phi_difference: 18 };
        let is_above = n.above_horizon();
        let by_pair = (0..n.cells()).filter(|cell| n.pair(cell / 162, cell / 18 % 9, cell % 18).is_above_horizon());
        assert!(by_pair.clone().all(&is_above));
        let above = by_pair.count();
        assert!(above < n.cells() * 9 / 10, "{above}");
        for below in [Some([0.0; 3]), Some([1.0; 3]), None] {
            let value = |angles| if pair_of_angles(angles).is_above_horizon() { Some([0.5; 3]) } else { below };
            let merl = Merl::from_bytes(&file(n, value)).unwrap();
            assert_eq!(merl.valid_cells, above);
            assert!((0..n.cells()).all(|cell| merl.values[cell][0].is_nan() != is_above(cell)), "{below:?}");
        }
        // A measured 0 above the horizon counts.
        assert_eq!(Merl::from_bytes(&file(n, |_| Some([0.0; 3]))).unwrap().valid_cells, above);
    }

    #[test]
    fn samples_are_on_lower_bin_edges() {
        assert_eq!(Dimensions::MERL.sample_angles(0, 0, 0), [0.0; 3]);
        let degrees = Dimensions::MERL.sample_angles(30, 7, 11).map(f64::to_degrees);
        for (found, expected) in degrees.into_iter().zip([10.0, 7.0, 11.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        let full = Dimensions { phi_difference: 360, ..Dimensions::MERL };
        assert!((full.sample_angles(0, 0, 270)[2].to_degrees() - 270.0).abs() < 1e-12);
    }

    #[test]
    fn bad_headers_and_lengths() {
        let good = file(SMALL, |_| Some([1.0; 3]));
        assert!(message(&[]).contains("0 bytes"));
        for length in 0..good.len() {
            assert!(Merl::from_bytes(&good[..length]).is_err(), "{length}");
        }
        for (raw, text) in [(0i32, "found 0"), (-3, "found -3"), (i32::MAX, "found 2147483647"), (i32::MIN, "-214")] {
            for axis in 0..3 {
                let mut bytes = good.clone();
                bytes[4 * axis..4 * axis + 4].copy_from_slice(&raw.to_le_bytes());
                let text_found = message(&bytes);
                assert!(text_found.contains(text) && text_found.contains("expected 1 to 4096"), "{text_found}");
            }
        }
        let mut longer = good.clone();
        longer.push(0);
        assert!(message(&longer).contains("1453 bytes, expected 1452 bytes for a table of 3 x 4 x 5"));
    }

    #[test]
    fn bad_numbers() {
        for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e31] {
            let mut bytes = file(SMALL, |_| Some([1.0; 3]));
            bytes[12 + 8 * 70..12 + 8 * 71].copy_from_slice(&number.to_le_bytes());
            assert!(message(&bytes).starts_with("byte 572, table: found"), "{}", message(&bytes));
        }
        assert!(message(&file(SMALL, |_| None)).contains("no valid measurement"));
    }

    #[test]
    fn symmetry_is_measured() {
        let n = Dimensions { theta_half: 2, theta_difference: 2, phi_difference: 8 };
        let even = Merl::from_bytes(&file(n, |[.., p]| Some([2.0 + (2.0 * p).cos(); 3]))).unwrap();
        assert!(even.is_mirror_symmetric(1e-5));
        let odd = Merl::from_bytes(&file(n, |[.., p]| Some([2.0 + (2.0 * p).sin(); 3]))).unwrap();
        assert!(!odd.is_mirror_symmetric(0.1));
        assert!(even.dimensions.is_full_turn() && even.is_reciprocal(1e-5) && odd.is_reciprocal(1e-5));
        let turning = Merl::from_bytes(&file(n, |[.., p]| Some([2.0 + p.cos(); 3]))).unwrap();
        assert!(turning.is_mirror_symmetric(1e-5) && !turning.is_reciprocal(0.1));
    }
}
