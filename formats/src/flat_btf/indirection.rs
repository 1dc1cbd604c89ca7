//! The part `indirection`: a block of view samples for each texel of the reference plane. A sampler can blend within a
//! block without reaching into the next one (section 3.5 of Hadim et al. 2009).

use super::MAX_COORDINATE;
use super::layout::{VERSION, check_format, half_bytes, halves, is_coordinate, word, wrong_extent};
use super::maps::is_unit;
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture, half};
use crate::cursor::Cursor;

const PART: &str = "indirection";
/// Key of the header.
const HEADER: &str = "brdfc.indirection";
/// Maximum number of polar-angle samples.
pub const MAX_ZENITH_SAMPLES: u32 = 256;
/// Maximum number of azimuth samples.
pub const MAX_AZIMUTH_SAMPLES: u32 = 256;

/// Header of an indirection map: sizes, and the views of its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IndirectionHeader {
    /// `M`, texels of the reference plane per side, 1 to 4096.
    pub size: u32,
    /// `Z`, number of polar-angle samples, 2 to [`MAX_ZENITH_SAMPLES`]: sample `k` is at `k φ_max / (Z - 1)`.
    pub zenith_samples: u32,
    /// `A`, number of azimuth samples, 3 to [`MAX_AZIMUTH_SAMPLES`]: sample `a` is at `2π a / A`.
    pub azimuth_samples: u32,
    /// `φ_max`, the largest polar angle, radians, above 0 up to π/2.
    pub largest_angle: f32,
}

impl IndirectionHeader {
    /// Width and height of the texture: `M Z` and `M (A + 1)`.
    pub fn extent(&self) -> [u32; 2] {
        [self.size * self.zenith_samples, self.size * (self.azimuth_samples + 1)]
    }

    /// Texel of the texture that holds sample `(k, a)` of texel `(i, j)` of the reference plane, `a` up to `A`.
    pub fn texel(&self, [i, j]: [u32; 2], k: u32, a: u32) -> [u32; 2] {
        [i * self.zenith_samples + k, j * (self.azimuth_samples + 1) + a]
    }

    /// Polar angle and azimuth of the view of sample `(k, a)`, radians.
    pub fn view_angles(&self, k: u32, a: u32) -> [f64; 2] {
        let polar = f64::from(self.largest_angle) * f64::from(k) / f64::from(self.zenith_samples - 1);
        [polar, std::f64::consts::TAU * f64::from(a) / f64::from(self.azimuth_samples)]
    }

    /// Checks all ranges, and that the texture is not too large.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        self.check_as(HEADER, PART)
    }

    /// Same as [`Self::check`]; `entry` and `part` name the data in errors.
    pub(super) fn check_as(&self, entry: &str, part: &'static str) -> Result<(), FormatError> {
        for (value, (field, range)) in self.to_words().into_iter().zip(FIELDS) {
            FormatError::check_range(format!("{entry} {field}"), value, range)?;
        }
        if !(self.largest_angle > 0.0 && self.largest_angle <= std::f32::consts::FRAC_PI_2) {
            let field = format!("{entry} largest angle");
            return Err(FormatError::whole(field, self.largest_angle.to_string(), "above 0, up to π/2 radians"));
        }
        let [width, height] = self.extent();
        if width.max(height) > MAX_EXTENT_2D {
            let allowed = format!("at most {MAX_EXTENT_2D} on each side");
            return Err(wrong_extent(part, Extent::D2([width, height]), allowed));
        }
        Ok(())
    }

    fn to_words(self) -> [u32; 3] {
        [self.size, self.zenith_samples, self.azimuth_samples]
    }

    fn to_bytes(self) -> Vec<u8> {
        let [size, zenith, azimuth] = self.to_words();
        [VERSION, size, zenith, azimuth, self.largest_angle.to_bits()].into_iter().flat_map(u32::to_le_bytes).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(sized(bytes, HEADER, 20)?);
        word(&mut cursor, HEADER, "version", VERSION..=VERSION)?;
        let header = Self {
            size: cursor.u32("size")?,
            zenith_samples: cursor.u32("zenith samples")?,
            azimuth_samples: cursor.u32("azimuth samples")?,
            largest_angle: cursor.f32("largest angle")?,
        };
        header.check()?;
        Ok(header)
    }
}

/// Names and ranges of the sizes in a header.
pub(super) const FIELDS: [(&str, std::ops::RangeInclusive<u32>); 3] = [
    ("size", 1..=MAX_EXTENT_2D / 2),
    ("zenith samples", 2..=MAX_ZENITH_SAMPLES),
    ("azimuth samples", 3..=MAX_AZIMUTH_SAMPLES),
];

/// Displacements of the parameters for all sampled views, in blocks by texel of the reference plane.
///
/// Each texel of the texture is `(δx, δy, d, z)`: unit direction and length of the displacement, in parameters, and the
/// height of the visible point in tiles. A displacement of length 0 may have direction 0.
#[derive(Debug, Clone, PartialEq)]
pub struct IndirectionMap {
    header: IndirectionHeader,
    /// Halves, row by row of the texture.
    texels: Vec<[u16; 4]>,
}

impl IndirectionMap {
    /// Creates a map from the texels of the texture, as halves.
    ///
    /// # Errors
    /// Returns an error if the header or the number of texels is out of range, or texels violate
    /// `formats/src/flat_btf/spec.md`.
    pub fn new(header: IndirectionHeader, texels: Vec<[u16; 4]>) -> Result<Self, FormatError> {
        header.check()?;
        let [width, height] = header.extent();
        let expected = u64::from(width) * u64::from(height);
        if texels.len() as u64 != expected {
            let field = format!("texels of the part {PART}");
            return Err(FormatError::whole(field, texels.len().to_string(), format!("{expected}, as the header says")));
        }
        check_blocks(&header, &texels)?;
        Ok(Self { header, texels })
    }

    /// Creates a map from displacements. `sample([i, j], k, a)` returns the displacement from the reference, in
    /// parameters, and the height in tiles of the point visible through texel `(i, j)` in view `(k, a)`, `a` below `A`.
    /// The displacement at the pole, `k = 0`, is set to 0. `sample` is called in the order of the texture's rows.
    ///
    /// # Errors
    /// Same as [`Self::new`], for example if distances or heights exceed [`MAX_COORDINATE`] or are NaN.
    pub fn from_displacements(
        header: IndirectionHeader,
        mut sample: impl FnMut([u32; 2], u32, u32) -> ([f32; 2], f32),
    ) -> Result<Self, FormatError> {
        header.check()?;
        let [width, height] = header.extent();
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        let block_row = (width * header.azimuth_samples) as usize;
        for j in 0..header.size {
            let start = texels.len();
            for a in 0..header.azimuth_samples {
                for i in 0..header.size {
                    let pole = texels.len();
                    for k in 0..header.zenith_samples {
                        let (displacement, height) = sample([i, j], k, a);
                        texels.push(encode(displacement, height));
                    }
                    let [x, y, ..] = texels[pole + 1];
                    texels[pole] = [x, y, 0, texels[pole][3]];
                }
            }
            debug_assert_eq!(texels.len(), start + block_row);
            texels.extend_from_within(start..start + width as usize);
        }
        Self::new(header, texels)
    }

    /// Size of the map, and angles of its view samples.
    pub fn header(&self) -> &IndirectionHeader {
        &self.header
    }

    /// Texels of the texture as halves, row by row.
    pub fn texels(&self) -> &[[u16; 4]] {
        &self.texels
    }

    /// Texels in GPU layout.
    pub fn texel_bytes(&self) -> Vec<u8> {
        half_bytes(&self.texels)
    }

    /// Sample `(k, a)` of texel `(i, j)` of the reference plane, `a` up to `A`: `(δx, δy, d, z)`.
    pub fn sample(&self, texel: [u32; 2], k: u32, a: u32) -> [f32; 4] {
        let [column, row] = self.header.texel(texel, k, a);
        self.texels[row as usize * self.header.extent()[0] as usize + column as usize].map(half::decode)
    }

    /// Displacement of that sample, in parameters.
    pub fn displacement(&self, texel: [u32; 2], k: u32, a: u32) -> [f32; 2] {
        let [x, y, distance, _] = self.sample(texel, k, a);
        [x * distance, y * distance]
    }

    /// Key and value of the header.
    pub(super) fn entry(&self) -> (String, Vec<u8>) {
        (HEADER.to_owned(), self.header.to_bytes())
    }

    /// Reads and validates the image of a file with its header.
    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let header = IndirectionHeader::from_bytes(entry(texture, HEADER, "an indirection map")?)?;
        check_format(texture, PART, TexelFormat::Rgba16Float)?;
        let extent = Extent::D2(header.extent());
        if texture.extent != extent {
            return Err(wrong_extent(PART, texture.extent, format!("a 2D texture of {extent}, as {HEADER} says")));
        }
        Self::new(header, halves(&texture.texels))
    }
}

/// Splits a displacement into direction and length.
fn encode([x, y]: [f32; 2], height: f32) -> [u16; 4] {
    let [x, y] = [f64::from(x), f64::from(y)];
    let distance = x.hypot(y);
    let rounded = half::encode(distance as f32);
    let direction = if rounded == 0 { [0.0; 2] } else { [x / distance, y / distance] };
    let [x, y] = direction.map(|c| half::encode(c as f32));
    [x, y, rounded, half::encode(height)]
}

fn check_blocks(header: &IndirectionHeader, texels: &[[u16; 4]]) -> Result<(), FormatError> {
    let width = header.extent()[0] as usize;
    let (zenith, rows) = (header.zenith_samples as usize, header.azimuth_samples as usize + 1);
    for (row, line) in texels.chunks_exact(width).enumerate() {
        for (column, texel) in line.iter().enumerate() {
            let [x, y, distance, height] = texel.map(half::decode);
            let rejected = |allowed: &str| {
                let field = format!("{PART} texel ({column}, {row})");
                Err(FormatError::whole(field, format!("[{x}, {y}, {distance}, {height}]"), allowed))
            };
            if !(0.0..=MAX_COORDINATE).contains(&distance) || !is_coordinate(height) {
                return rejected("a distance of 0 to 1024 and a height of -1024 to 1024");
            }
            let nowhere = [x, y, distance] == [0.0; 3];
            if !(nowhere || is_unit(&[x, y])) {
                return rejected("a unit direction, or 0 with a distance of 0");
            }
            if column % zenith == 0 && (distance != 0.0 || texel[..2] != line[column + 1][..2]) {
                return rejected("a distance of 0 and the direction of the next sample, at the pole");
            }
            if row % rows == rows - 1 && *texel != texels[(row + 1 - rows) * width + column] {
                return rejected("in the last row of a block, the value of its first row");
            }
        }
    }
    Ok(())
}
