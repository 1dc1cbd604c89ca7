//! Maps of local bandwidth: rate of variation of BRDF lobes, environments or textures. Layout:
//! `formats/src/bandwidth/spec.md`.
//!
//! Look-ups are f32 operations in a fixed order, and `formats/src/bandwidth/map.wgsl` produces the same bits.

use crate::FormatError;
use crate::bindings::PackFile;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, TexelFormat, Texture, half};
use crate::cursor::Cursor;
use crate::direction::{polynomial_atan2, polynomial_atan2_each, subtracted_if};
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Cells per axis of each hemisphere of a BRDF's map.
pub const CELLS: u32 = 16;
/// Texels per side of a BRDF's map.
pub const BRDF_SIDE: u32 = CELLS * CELLS;
/// Maximum texels per side of a map.
pub const MAX_SIDE: u32 = 512;
/// Maximum pixels per side of the transformed image.
pub const MAX_TRANSFORMED: u32 = 1 << 16;

const VERSION: u32 = 1;
/// Key that identifies a bandwidth map.
pub const BANDWIDTH_ENTRY: &str = "brdfc.bandwidth";
const HEADER_BYTES: usize = 40;

/// Subject of a map, with the properties that only that kind has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BandwidthKind {
    /// Lobes of a BRDF: cycles per radian of the outgoing direction.
    Brdf,
    /// An environment: cycles per radian of the direction.
    Environment,
    /// A texture: cycles per metre.
    Texture {
        /// Width and height of the texture in metres, positive.
        metres: [f32; 2],
        /// True if the texture repeats.
        tiles: bool,
    },
}

impl BandwidthKind {
    /// Name for command line and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brdf => "brdf",
            Self::Environment => "environment",
            Self::Texture { .. } => "texture",
        }
    }

    /// Unit of the values.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Brdf | Self::Environment => "cycles per radian",
            Self::Texture { .. } => "cycles per metre",
        }
    }

    fn codes(self) -> [u32; 2] {
        match self {
            Self::Brdf => [0, 0],
            Self::Environment => [1, 0],
            Self::Texture { .. } => [2, 1],
        }
    }
}

/// Header of a bandwidth map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandwidthHeader {
    /// Subject of the map.
    pub kind: BandwidthKind,
    /// `ε` of the rule by which the values were determined, positive, at most 1.
    pub epsilon: f32,
    /// Width and height of the transformed image, each 1 to [`MAX_TRANSFORMED`]; for BRDFs, of each lobe.
    pub transformed: [u32; 2],
}

/// A bandwidth map in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct BandwidthMap {
    header: BandwidthHeader,
    size: [u32; 2],
    /// Factor of texel values.
    scale: f32,
    /// Halves, row by row.
    texels: Vec<u16>,
}

impl BandwidthMap {
    /// Creates a map from `size` values, row by row. Values are rounded to halves; if the largest exceeds the range of
    /// halves, all are divided by a power of two first.
    ///
    /// # Errors
    /// Returns an error if the header is out of range, the size does not fit the kind, the number of values is wrong,
    /// or a value is negative or not finite.
    pub fn new(header: BandwidthHeader, size: [u32; 2], values: &[f32]) -> Result<Self, FormatError> {
        check_header(&header)?;
        check_size(&header, size)?;
        let expected = u64::from(size[0]) * u64::from(size[1]);
        if values.len() as u64 != expected {
            let allowed = format!("{expected}, as its size says");
            return Err(FormatError::whole("values of a bandwidth map", values.len().to_string(), allowed));
        }
        if let Some(at) = values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            return Err(wrong_texel(size, at, values[at]));
        }
        let mut scale = 1.0f32;
        let largest = values.iter().copied().fold(0.0, f32::max);
        while largest / scale > half::MAX {
            scale *= 2.0;
        }
        let texels = values.iter().map(|value| half::encode((value / scale).min(half::MAX).abs())).collect();
        Ok(Self { header, size, scale, texels })
    }

    /// Header of the map.
    pub fn header(&self) -> &BandwidthHeader {
        &self.header
    }

    /// Width and height of a texture in metres; `None` for other kinds.
    pub fn metres(&self) -> Option<[f32; 2]> {
        match self.header.kind {
            BandwidthKind::Texture { metres, .. } => Some(metres),
            _ => None,
        }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Factor of texel values.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Values in the unit of the kind, row by row.
    pub fn values(&self) -> Vec<f32> {
        self.texels.iter().map(|texel| half::decode(*texel) * self.scale).collect()
    }

    /// Texels in GPU layout: little-endian halves.
    pub fn texel_bytes(&self) -> Vec<u8> {
        self.texels.iter().flat_map(|texel| texel.to_le_bytes()).collect()
    }

    /// Bandwidth of the lobe of `incoming` at `outgoing`, from the nearest cell, in cycles per radian. Directions are
    /// unit vectors in the frame z = normal; those below the horizon use the last cell. 0 for other kinds of maps.
    pub fn brdf(&self, incoming: [f32; 3], outgoing: [f32; 3]) -> f32 {
        self.brdf_cells(brdf_cell(incoming), brdf_cell(outgoing))
    }

    /// Same as [`Self::brdf`] for directions whose [`brdf_cell`] is known.
    pub fn brdf_cells(&self, [i, j]: [u32; 2], [k, l]: [u32; 2]) -> f32 {
        if self.header.kind != BandwidthKind::Brdf {
            return 0.0;
        }
        self.texel([i * CELLS + k, j * CELLS + l])
    }

    /// Bandwidth of an environment in a direction of any length, `x = sin θ cos φ, y = cos θ, z = sin θ sin φ`, from
    /// the nearest texel, in cycles per radian. 0 for other kinds of maps.
    pub fn environment(&self, direction: [f32; 3]) -> f32 {
        if self.header.kind != BandwidthKind::Environment {
            return 0.0;
        }
        self.texel(self.environment_texel(direction))
    }

    /// Values of [`Self::environment`] for all texels, row by row.
    pub fn environment_values(&self) -> Vec<f32> {
        match self.header.kind {
            BandwidthKind::Environment => self.values(),
            _ => vec![0.0; self.texels.len()],
        }
    }

    /// Column and row that [`Self::environment`] reads, also valid for other images of the same size.
    pub fn environment_texel(&self, direction: [f32; 3]) -> [u32; 2] {
        let [x, y, z] = direction;
        let turn = azimuth(x, z) / TAU;
        let fall = polynomial_atan2((x * x + z * z).sqrt(), y) / PI;
        [index(turn, self.size[0]), index(fall, self.size[1])]
    }

    /// [`brdf_cell`] of one direction and [`Self::environment_texel`] of another, faster than two calls.
    pub fn cell_and_texel(&self, local: [f32; 3], world: [f32; 3]) -> ([u32; 2], [u32; 2]) {
        let ([a, b, c], [x, y, z]) = (local, world);
        let legs = [b.abs(), (a * a + b * b).sqrt(), z.abs(), (x * x + z * z).sqrt()];
        let [ab, ac, xz, xy] = polynomial_atan2_each(legs, [a, c, x, y]);
        let turned = [subtracted_if(b < 0.0, TAU, ab), ac, subtracted_if(z < 0.0, TAU, xz), xy];
        let whole = [TAU, FRAC_PI_2, TAU, PI];
        let count = [CELLS, CELLS, self.size[0], self.size[1]];
        let [i, j, column, row] = std::array::from_fn(|k| index(turned[k] / whole[k], count[k]));
        ([i, j], [column, row])
    }

    /// Bandwidth of a texture at the nearest texel, in cycles per metre. `(0, 0)` is the corner of the first texel, v
    /// follows the rows, and the texture has width and height 1; outside it repeats or is clamped as the header says. 0
    /// for other kinds of maps.
    pub fn texture(&self, uv: [f32; 2]) -> f32 {
        let BandwidthKind::Texture { tiles, .. } = self.header.kind else { return 0.0 };
        let inside = |c: f32| if tiles { c - c.floor() } else { c };
        self.texel([index(inside(uv[0]), self.size[0]), index(inside(uv[1]), self.size[1])])
    }

    fn texel(&self, [column, row]: [u32; 2]) -> f32 {
        half::decode(self.texels[(row * self.size[0] + column) as usize]) * self.scale
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let h = &self.header;
        let [kind, unit] = h.kind.codes();
        let (metres, tiles) = match h.kind {
            BandwidthKind::Texture { metres, tiles } => (metres, tiles),
            _ => ([0.0; 2], false),
        };
        let words = [
            VERSION,
            kind,
            unit,
            h.epsilon.to_bits(),
            h.transformed[0],
            h.transformed[1],
            metres[0].to_bits(),
            metres[1].to_bits(),
            u32::from(tiles),
            self.scale.to_bits(),
        ];
        let header = words.into_iter().flat_map(u32::to_le_bytes).collect();
        self.bindings().to_file(BTreeMap::from([(BANDWIDTH_ENTRY.to_owned(), header)]), supercompress)
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/bandwidth/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/bandwidth/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let map = Self::from_texture(&file.take_own())?;
        file.check_same(&map.bindings())?;
        Ok(map)
    }

    /// Reads and validates a texture with the header among its key/value data.
    ///
    /// # Errors
    /// Returns an error if the texture or its header violates `formats/src/bandwidth/spec.md`.
    pub fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        texture.check_one_level()?;
        let (header, scale) = read_header(entry(texture, BANDWIDTH_ENTRY, "a bandwidth map")?)?;
        if texture.format != TexelFormat::R16Float {
            return Err(FormatError::whole("texels of a bandwidth map", format!("{:?}", texture.format), "R16Float"));
        }
        let Extent::D2(size) = texture.extent else { return Err(wrong_size(texture.extent, "a 2D texture")) };
        check_size(&header, size)?;
        let texels: Vec<u16> = texture.texels.as_chunks::<2>().0.iter().map(|half| u16::from_le_bytes(*half)).collect();
        // Bits of finite non-negative halves.
        if let Some(at) = texels.iter().position(|texel| *texel >= 0x7c00) {
            return Err(wrong_texel(size, at, half::decode(texels[at])));
        }
        Ok(Self { header, size, scale, texels })
    }
}

/// Angle of `(x, y)`, 0 to 2π.
fn azimuth(x: f32, y: f32) -> f32 {
    subtracted_if(y < 0.0, TAU, polynomial_atan2(y.abs(), x))
}

/// Index of the part of `[0, 1]`, divided into `count` equal parts, that contains a fraction; clamped at the ends.
fn index(share: f32, count: u32) -> u32 {
    // NaN becomes 0.
    let at = if share > 0.0 { share * count as f32 } else { 0.0 };
    (at.min(count as f32 - 1.0)) as u32
}

/// Cell of a direction in the map of a BRDF: azimuth, polar angle.
pub fn brdf_cell([x, y, z]: [f32; 3]) -> [u32; 2] {
    let turn = azimuth(x, y) / TAU;
    let fall = polynomial_atan2((x * x + y * y).sqrt(), z) / FRAC_PI_2;
    [index(turn, CELLS), index(fall, CELLS)]
}

fn wrong_texel(size: [u32; 2], at: usize, value: f32) -> FormatError {
    let (column, row) = (at % size[0] as usize, at / size[0] as usize);
    let field = format!("bandwidth texel ({column}, {row})");
    FormatError::whole(field, value.to_string(), "a finite number of 0 or more")
}

fn wrong_size(found: Extent, allowed: impl Into<String>) -> FormatError {
    FormatError::whole("size of a bandwidth map", found.to_string(), allowed)
}

fn check_size(header: &BandwidthHeader, size: [u32; 2]) -> Result<(), FormatError> {
    if header.kind == BandwidthKind::Brdf {
        return match size == [BRDF_SIDE; 2] {
            true => Ok(()),
            false => Err(wrong_size(Extent::D2(size), format!("{BRDF_SIDE} x {BRDF_SIDE} for a BRDF"))),
        };
    }
    match size.iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        true => Ok(()),
        false => Err(wrong_size(Extent::D2(size), format!("1 to {MAX_SIDE} on each side"))),
    }
}

fn check_header(header: &BandwidthHeader) -> Result<(), FormatError> {
    let wrong = |field: &str, found: String, allowed: String| {
        Err(FormatError::whole(format!("{BANDWIDTH_ENTRY} {field}"), found, allowed))
    };
    let positive = |value: f32| value.is_normal() && value > 0.0;
    if !(positive(header.epsilon) && header.epsilon <= 1.0) {
        return wrong("epsilon", header.epsilon.to_string(), "a positive number of at most 1".to_owned());
    }
    for side in header.transformed {
        FormatError::check_range(format!("{BANDWIDTH_ENTRY} transformed size"), side, 1..=MAX_TRANSFORMED)?;
    }
    if let BandwidthKind::Texture { metres, .. } = header.kind
        && let Some(side) = metres.into_iter().find(|side| !positive(*side))
    {
        return wrong("metres", side.to_string(), "a positive number".to_owned());
    }
    Ok(())
}

/// Reads the header and the scale of the texels.
fn read_header(bytes: &[u8]) -> Result<(BandwidthHeader, f32), FormatError> {
    let mut cursor = Cursor::new(sized(bytes, BANDWIDTH_ENTRY, HEADER_BYTES)?);
    let wrong = |field: &str, found: String, allowed: &str| {
        FormatError::whole(format!("{BANDWIDTH_ENTRY} {field}"), found, allowed)
    };
    let version = cursor.u32("version")?;
    if version != VERSION {
        return Err(wrong("version", version.to_string(), "1"));
    }
    let [kind, unit] = [cursor.u32("kind")?, cursor.u32("unit")?];
    let epsilon = cursor.f32("epsilon")?;
    let transformed = [cursor.u32("transformed size")?, cursor.u32("transformed size")?];
    let metres = [cursor.f32("metres")?, cursor.f32("metres")?];
    let tiles = cursor.u32("tiles")?;
    let scale = cursor.f32("scale")?;
    if tiles > 1 {
        return Err(wrong("tiles", tiles.to_string(), "0 or 1"));
    }
    let kind = match kind {
        0 => BandwidthKind::Brdf,
        1 => BandwidthKind::Environment,
        2 => BandwidthKind::Texture { metres, tiles: tiles == 1 },
        other => return Err(wrong("kind", other.to_string(), "0 (brdf), 1 (environment) or 2 (texture)")),
    };
    if unit != kind.codes()[1] {
        let allowed = format!("{} ({}) for the kind {}", kind.codes()[1], kind.unit(), kind.name());
        return Err(wrong("unit", unit.to_string(), &allowed));
    }
    let is_texture = matches!(kind, BandwidthKind::Texture { .. });
    if !is_texture && (metres.map(f32::to_bits) != [0; 2] || tiles != 0) {
        let found = format!("{} x {} metres, tiles {tiles}", metres[0], metres[1]);
        return Err(wrong("metres", found, "0 for other kinds than textures"));
    }
    // Powers of two from 1 to 2^127 have a zero mantissa.
    if !(scale.is_normal() && scale >= 1.0 && scale.to_bits() & 0x7f_ffff == 0 && scale <= 2f32.powi(112)) {
        return Err(wrong("scale", scale.to_string(), "a power of two from 1 to 2^112"));
    }
    let header = BandwidthHeader { kind, epsilon, transformed };
    check_header(&header)?;
    Ok((header, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::from_polar;

    fn map(kind: BandwidthKind, size: [u32; 2]) -> BandwidthMap {
        let header = BandwidthHeader { kind, epsilon: 0.01, transformed: [64, 64] };
        let values: Vec<f32> = (0..size[0] * size[1]).map(|i| i as f32 / 32.0).collect();
        BandwidthMap::new(header, size, &values).unwrap()
    }

    #[test]
    fn centres_map_to_their_cells() {
        let map = map(BandwidthKind::Brdf, [256; 2]);
        let centre = |i: u32, j: u32| {
            let (azimuth, polar) = (TAU * (i as f32 + 0.5) / 16.0, FRAC_PI_2 * (j as f32 + 0.5) / 16.0);
            from_polar(f64::from(polar), f64::from(azimuth)).map(|c| c as f32)
        };
        for (i, j, k, l) in [(0, 0, 0, 0), (3, 15, 9, 7), (15, 2, 15, 15), (8, 9, 4, 0)] {
            assert_eq!(map.brdf(centre(i, j), centre(k, l)), map.values()[((16 * j + l) * 256 + 16 * i + k) as usize]);
        }
        assert_eq!(map.brdf([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]), map.texel([0, 15]));
        assert_eq!((map.environment([1.0, 0.0, 0.0]), map.texture([0.0; 2])), (0.0, 0.0));
    }

    #[test]
    fn directions_and_points_find_their_texels() {
        let sky = map(BandwidthKind::Environment, [8, 4]);
        for row in 0..4 {
            for column in 0..8 {
                let (theta, phi) = (PI * (row as f32 + 0.5) / 4.0, TAU * (column as f32 + 0.5) / 8.0);
                let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|c| 7.0 * c);
                let local = [d[2], d[0], d[1].abs()];
                assert_eq!(sky.cell_and_texel(local, d), (brdf_cell(local), [column, row]));
                assert_eq!(sky.environment(d), sky.texel([column, row]));
            }
        }
        let cloth = |tiles| map(BandwidthKind::Texture { metres: [0.5, 1.0], tiles }, [8, 4]);
        for (uv, repeated, ended) in [
            ([0.3, 0.6], [2, 2], [2, 2]),
            ([1.3, -0.4], [2, 2], [7, 0]),
            ([-1e-9, 1.0], [7, 0], [0, 3]),
            ([f32::NAN, f32::INFINITY], [0, 0], [0, 3]),
        ] {
            assert_eq!(cloth(true).texture(uv), cloth(true).texel(repeated), "{uv:?}");
            assert_eq!(cloth(false).texture(uv), cloth(false).texel(ended), "{uv:?}");
        }
    }

    #[test]
    fn values_beyond_halves_are_scaled() {
        let header = BandwidthHeader {
            kind: BandwidthKind::Texture { metres: [1e-4; 2], tiles: true },
            epsilon: 0.01,
            transformed: [2, 1],
        };
        for largest in [65504.0f32, 65505.0, 2.5e6, 3e38] {
            let map = BandwidthMap::new(header, [2, 1], &[largest, 0.0]).unwrap();
            assert!((map.values()[0] / largest - 1.0).abs() < 6e-4, "{largest}");
            assert_eq!(BandwidthMap::from_bytes(&map.to_bytes(true)).unwrap(), map);
        }
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            let error = BandwidthMap::new(header, [2, 1], &[1.0, bad]).unwrap_err();
            assert_eq!(error.field, "bandwidth texel (1, 0)");
        }
        assert!(BandwidthMap::new(header, [2, 1], &[1.0]).is_err());
    }
}
