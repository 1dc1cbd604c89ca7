//! Importance-sample pack: directions drawn in proportion to a material's lobe, with their densities, for each outgoing
//! direction (Bagher et al. 2012, "Interactive rendering of acquired materials on dynamic geometry using bandwidth
//! prediction", section 3.3). Byte layout: `formats/src/importance/spec.md`.

use crate::FormatError;
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{check_texels, entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::{Cursor, block_bytes};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("importance", 1);

/// WGSL look-up. It declares a uniform block and a texture in bind group 1; see the file.
pub const IMPORTANCE_WGSL: &str = include_str!("pack.wgsl");

/// Key that identifies an importance-sample pack.
pub const IMPORTANCE_ENTRY: &str = "brdfc.importance";

const VERSION: u32 = 1;
/// Maximum deviation of the squared length of a half vector from 1.
const UNIT_TOLERANCE: f32 = 1e-5;

/// Sizes of a pack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImportanceHeader {
    /// `P`, number of polar angles of the outgoing direction, 1 to 1024.
    pub polar: u32,
    /// `A`, number of azimuths of the outgoing direction: 1 for isotropic materials, otherwise a multiple of 4 up to
    /// 256.
    pub azimuths: u32,
    /// `M`, samples per outgoing direction, 1 to 8192.
    pub samples: u32,
}

const FIELDS: [(&str, RangeInclusive<u32>); 3] =
    [("polar rows", 1..=1024), ("azimuth columns", 1..=256), ("samples", 1..=MAX_EXTENT_2D)];

impl ImportanceHeader {
    /// Size of the uniform block, bytes.
    pub const UNIFORM_SIZE: usize = 16;

    /// Returns true if samples are rotated to the azimuth of the outgoing direction.
    pub fn isotropic(&self) -> bool {
        self.azimuths == 1
    }

    /// Rows of the texture: outgoing directions, azimuth fastest.
    pub fn rows(&self) -> u32 {
        self.polar * self.azimuths
    }

    /// Row of the cell that contains this unit vector.
    ///
    /// Polar angles are equally spaced in `sqrt(1 - z)`, which is nearly proportional to the angle. Azimuths are
    /// equally spaced in `y` along the sides of the square `|x| + |y| = 1`, so that no row crosses a mirror plane.
    pub fn row(&self, outgoing: [f32; 3]) -> u32 {
        let [x, y, z] = outgoing;
        let polar = (((1.0 - z).max(0.0).sqrt() * self.polar as f32) as u32).min(self.polar - 1);
        if self.isotropic() {
            return polar;
        }
        let length = x.abs() + y.abs();
        // 0 at the tangent, 1 at the bitangent, below 4 in total.
        let first = if length > 0.0 { y.abs() / length } else { 0.0 };
        let half = if x < 0.0 { 2.0 - first } else { first };
        let turn = if y < 0.0 { 4.0 - half } else { half };
        let azimuth = ((0.25 * turn * self.azimuths as f32) as u32).min(self.azimuths - 1);
        polar * self.azimuths + azimuth
    }

    /// Outgoing direction at the centre of a row, a unit vector. `shift` moves it across the row in polar angle, from
    /// -½ at the upper border to ½ at the lower one.
    pub fn outgoing(&self, row: u32, shift: f64) -> [f64; 3] {
        let (polar, azimuth) = (row / self.azimuths, row % self.azimuths);
        let root = (f64::from(polar) + 0.5 + shift) / f64::from(self.polar);
        let z = 1.0 - root * root;
        let r = (1.0 - z * z).max(0.0).sqrt();
        if self.isotropic() {
            return [r, 0.0, z];
        }
        let turn = 4.0 * (f64::from(azimuth) + 0.5) / f64::from(self.azimuths);
        let (quarter, t) = (turn.floor() as u32 % 4, turn.fract());
        let (x, y) = [(1.0 - t, t), (-t, 1.0 - t), (t - 1.0, -t), (t, t - 1.0)][quarter as usize];
        let length = x.hypot(y);
        [r * x / length, r * y / length, z]
    }

    /// The uniform block `ImportanceParameters`: little-endian fields in order, padded with 4 zero bytes.
    pub fn uniform(&self) -> [u8; Self::UNIFORM_SIZE] {
        block_bytes(self.words())
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        for (value, (field, range)) in self.words().into_iter().zip(FIELDS) {
            FormatError::check_range(format!("{IMPORTANCE_ENTRY} {field}"), value, range)?;
        }
        if !self.isotropic() && !self.azimuths.is_multiple_of(4) {
            let field = format!("{IMPORTANCE_ENTRY} {}", FIELDS[1].0);
            return Err(FormatError::whole(field, self.azimuths.to_string(), "1, or a multiple of 4"));
        }
        FormatError::check_range(format!("{IMPORTANCE_ENTRY} rows"), self.rows(), 1..=MAX_EXTENT_2D)
    }

    fn words(&self) -> [u32; 3] {
        [self.polar, self.azimuths, self.samples]
    }

    fn to_bytes(self) -> Vec<u8> {
        let [polar, azimuths, samples] = self.words();
        let words = [VERSION, polar, azimuths, samples, u32::from(self.isotropic())];
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(sized(bytes, IMPORTANCE_ENTRY, 20)?);
        let expect = |field: &str, found: u32, allowed: u32| {
            if found == allowed {
                return Ok(());
            }
            let field = format!("{IMPORTANCE_ENTRY} {field}");
            Err(FormatError::whole(field, found.to_string(), allowed.to_string()))
        };
        expect("version", cursor.u32("version")?, VERSION)?;
        let header = Self {
            polar: cursor.u32("polar rows")?,
            azimuths: cursor.u32("azimuth columns")?,
            samples: cursor.u32("samples")?,
        };
        header.check()?;
        expect("isotropic", cursor.u32("isotropic")?, u32::from(header.isotropic()))?;
        Ok(header)
    }
}

/// Samples of a material's lobe for all outgoing directions.
///
/// Each texel has a unit half vector in the local frame, above the horizon, and its density per steradian of half
/// vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportancePack {
    header: ImportanceHeader,
    texels: Vec<[f32; 4]>,
}

impl ImportancePack {
    /// Creates a pack from `M x rows` texels, row by row.
    ///
    /// # Errors
    /// Returns an error if the header is out of range, the number of texels is wrong, a half vector does not have unit
    /// length or points down, or a density is not positive and finite.
    pub fn new(header: ImportanceHeader, texels: Vec<[f32; 4]>) -> Result<Self, FormatError> {
        header.check()?;
        let expected = u64::from(header.rows()) * u64::from(header.samples);
        if texels.len() as u64 != expected {
            let allowed = format!("{expected}, as the header says");
            return Err(FormatError::whole("importance texels", texels.len().to_string(), allowed));
        }
        for (at, [x, y, z, density]) in texels.iter().enumerate() {
            let unit = (x * x + y * y + z * z - 1.0).abs() <= UNIT_TOLERANCE && *z >= 0.0;
            if !unit || !density.is_normal() || *density < 0.0 {
                let (column, row) = (at % header.samples as usize, at / header.samples as usize);
                let allowed = "a unit vector with z >= 0, and a positive density";
                let found = format!("[{x}, {y}, {z}, {density}]");
                return Err(FormatError::whole(format!("importance texel ({column}, {row})"), found, allowed));
            }
        }
        Ok(Self { header, texels })
    }

    /// Sizes of the pack.
    pub fn header(&self) -> ImportanceHeader {
        self.header
    }

    /// Half vectors and densities, row by row.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Size on a GPU, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        std::mem::size_of_val(&self.texels[..]) as u64
    }

    /// Sample `index`, modulo M, for an outgoing unit vector. Returns the incoming unit vector and the inverse of its
    /// density per steradian, `4 (wo · h) / p(h)`.
    ///
    /// The mean of `value / density` over any `N` consecutive indices estimates an integral over incoming directions.
    /// The inverse is 0 if the incoming direction is below the horizon; such samples count among the `N` and contribute
    /// nothing.
    pub fn sample(&self, outgoing: [f32; 3], index: u32) -> ([f32; 3], f32) {
        let [x, y, z] = outgoing;
        let column = index % self.header.samples;
        let [hx, hy, hz, density] = self.texels[(self.header.row(outgoing) * self.header.samples + column) as usize];
        let mut half = [hx, hy, hz];
        if self.header.isotropic() {
            let length = (x * x + y * y).sqrt();
            if length > 0.0 {
                let (cosine, sine) = (x / length, y / length);
                half = [cosine * hx - sine * hy, sine * hx + cosine * hy, hz];
            }
        }
        let projection = x * half[0] + y * half[1] + z * half[2];
        let double = 2.0 * projection;
        let incoming = [double * half[0] - x, double * half[1] - y, double * half[2] - z];
        // Seen from behind the half vector, the incoming direction is below the horizon.
        if incoming[2] <= 0.0 || z <= 0.0 {
            return (incoming, 0.0);
        }
        (incoming, 4.0 * projection / density)
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let entries = BTreeMap::from([(IMPORTANCE_ENTRY.to_owned(), self.header.to_bytes())]);
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        let texels: Vec<u8> = self.texels.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        let extent = Extent::D2([self.header.samples, self.header.rows()]);
        let all = [
            Binding::uniform(35, "importance_parameters", self.header.uniform().to_vec()),
            Binding::texture(36, "importance_texels", Texels::new(TexelFormat::Rgba32Float, extent, texels).of_file()),
        ];
        Bindings::new(DECODER.0, DECODER.1, all)
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/importance/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/importance/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let pack = Self::from_texture(&file.take_own())?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    /// Reads and validates a texture with the header among its key/value data.
    ///
    /// # Errors
    /// Returns an error if the texture or its header violates `formats/src/importance/spec.md`.
    pub fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        texture.check_one_level()?;
        let header = ImportanceHeader::from_bytes(entry(texture, IMPORTANCE_ENTRY, "an importance-sample pack")?)?;
        let extent = Extent::D2([header.samples, header.rows()]);
        check_texels(texture, "texture", extent, TexelFormat::Rgba32Float, IMPORTANCE_ENTRY)?;
        let (words, _) = texture.texels.as_chunks::<4>();
        Self::new(header, words.as_chunks::<4>().0.iter().map(|texel| texel.map(f32::from_le_bytes)).collect())
    }
}
