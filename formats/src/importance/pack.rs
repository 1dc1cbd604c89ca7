//! The importance-sample pack: directions drawn in proportion to a material's lobe, with their densities, for every
//! outgoing direction ("Interactive rendering of acquired materials on dynamic geometry using bandwidth prediction",
//! 2012, section 3.3). Byte layout: `formats/src/importance/spec.md`.

use crate::FormatError;
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{check_texels, entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::{Cursor, block_bytes};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// The name of the decoder and the version of its bindings.
pub(super) const DECODER: (&str, u32) = ("importance", 1);

/// The WGSL look-up. It declares a uniform block and a texture in bind group 1; see the file.
pub const IMPORTANCE_WGSL: &str = include_str!("pack.wgsl");

/// The entry that makes a texture this kind of pack.
pub const IMPORTANCE_ENTRY: &str = "brdfc.importance";

const VERSION: u32 = 1;
/// How far the squared length of a half vector may be from 1.
const UNIT_TOLERANCE: f32 = 1e-5;

/// Sizes of a pack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImportanceHeader {
    /// `P`, polar angles of the outgoing direction, 1 to 1024.
    pub polar: u32,
    /// `A`, azimuths of the outgoing direction: 1 for isotropic materials, else a multiple of 4 up to 256.
    pub azimuths: u32,
    /// `M`, samples of each outgoing direction, 1 to 8192.
    pub samples: u32,
}

const FIELDS: [(&str, RangeInclusive<u32>); 3] =
    [("polar rows", 1..=1024), ("azimuth columns", 1..=256), ("samples", 1..=MAX_EXTENT_2D)];

impl ImportanceHeader {
    /// Bytes of the uniform block that the shader reads.
    pub const UNIFORM_SIZE: usize = 16;

    /// Whether samples are turned to the azimuth of the outgoing direction.
    pub fn isotropic(&self) -> bool {
        self.azimuths == 1
    }

    /// Rows of the texture: outgoing directions, azimuth fastest.
    pub fn rows(&self) -> u32 {
        self.polar * self.azimuths
    }

    /// The row of the outgoing directions around this unit vector.
    ///
    /// Polar angles are in equal steps of `sqrt(1 - z)`, which is nearly the angle. Azimuths are in equal steps of `y` on
    /// the lines of the square `|x| + |y| = 1`: no row is on either side of a mirror plane.
    pub fn row(&self, outgoing: [f32; 3]) -> u32 {
        let [x, y, z] = outgoing;
        let polar = (((1.0 - z).max(0.0).sqrt() * self.polar as f32) as u32).min(self.polar - 1);
        if self.isotropic() {
            return polar;
        }
        let length = x.abs() + y.abs();
        // From 0 at the tangent by 1 at the bitangent to below 4.
        let first = if length > 0.0 { y.abs() / length } else { 0.0 };
        let half = if x < 0.0 { 2.0 - first } else { first };
        let turn = if y < 0.0 { 4.0 - half } else { half };
        let azimuth = ((0.25 * turn * self.azimuths as f32) as u32).min(self.azimuths - 1);
        polar * self.azimuths + azimuth
    }

    /// The outgoing direction in the middle of a row, a unit vector. `shift` moves it across the row in polar angle, from
    /// -½ at its upper border to ½ at its lower one.
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

    /// The uniform block `ImportanceParameters` of the shader: little-endian, fields in order, 4 bytes of zero at the
    /// end.
    pub fn uniform(&self) -> [u8; Self::UNIFORM_SIZE] {
        block_bytes(self.words())
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// Names the field that is out of range.
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

/// Samples of a material's lobe, for all outgoing directions.
///
/// A texel is a unit half vector in the local frame, above the horizon, and its density per steradian of half vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportancePack {
    header: ImportanceHeader,
    texels: Vec<[f32; 4]>,
}

impl ImportancePack {
    /// A pack of `M x rows` texels, row by row.
    ///
    /// # Errors
    /// A header out of range, another number of texels, half vectors that are not of unit length or point down, densities
    /// that are not positive and finite.
    pub fn new(header: ImportanceHeader, texels: Vec<[f32; 4]>) -> Result<Self, FormatError> {
        header.check()?;
        let wanted = u64::from(header.rows()) * u64::from(header.samples);
        if texels.len() as u64 != wanted {
            let allowed = format!("{wanted}, as the header says");
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

    /// Sizes.
    pub fn header(&self) -> ImportanceHeader {
        self.header
    }

    /// Half vectors and densities, row by row.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Bytes on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        std::mem::size_of_val(&self.texels[..]) as u64
    }

    /// Sample `index`, modulo M, for an outgoing unit vector: the incoming unit vector, and the inverse of its density
    /// per steradian, `4 (wo · h) / p(h)`.
    ///
    /// `N` samples with any `N` consecutive indices estimate an integral over incoming directions by the mean of
    /// `value / density`. The inverse is 0 where a direction comes out below the horizon: such samples count among the N
    /// and bring nothing.
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
        // A half vector seen from behind has its incoming direction below the horizon.
        if incoming[2] <= 0.0 || z <= 0.0 {
            return (incoming, 0.0);
        }
        (incoming, 4.0 * projection / density)
    }

    /// The bytes of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let entries = BTreeMap::from([(IMPORTANCE_ENTRY.to_owned(), self.header.to_bytes())]);
        self.bindings().to_file(entries, supercompress)
    }

    /// What its shader has bound.
    pub fn bindings(&self) -> Bindings<'_> {
        let texels: Vec<u8> = self.texels.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        let extent = Extent::D2([self.header.samples, self.header.rows()]);
        let all = [
            Binding::uniform(35, "importance_parameters", self.header.uniform().to_vec()),
            Binding::texture(36, "importance_texels", Texels::new(TexelFormat::Rgba32Float, extent, texels).of_file()),
        ];
        Bindings::new(DECODER.0, DECODER.1, all)
    }

    /// Reads and checks a KTX2 file.
    ///
    /// # Errors
    /// Whatever breaks the rules of `formats/src/importance/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// [`Self::from_bytes`] of a file whose bindings have been read.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let pack = Self::from_texture(&file.take_own())?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    /// Reads and checks a texture with the entry of its header, as a file has them.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        texture.check_one_level()?;
        let header = ImportanceHeader::from_bytes(entry(texture, IMPORTANCE_ENTRY, "an importance-sample pack")?)?;
        let extent = Extent::D2([header.samples, header.rows()]);
        check_texels(texture, "texture", extent, TexelFormat::Rgba32Float, IMPORTANCE_ENTRY)?;
        let (words, _) = texture.texels.as_chunks::<4>();
        Self::new(header, words.as_chunks::<4>().0.iter().map(|texel| texel.map(f32::from_le_bytes)).collect())
    }
}
