//! Parts of a flat BTF that do not depend on view or light: normals, diffuse colour and reference.

use super::layout::{
    check_square, check_texels, floats, half_bytes, halves, is_coordinate, square, words as packed_words,
};
use crate::FormatError;
use crate::container::{TexelFormat, Texture, half, rgb9e5};

/// Maximum deviation of the squared length of a direction in halves from 1.
const UNIT_TOLERANCE: f32 = 1.0 / 128.0;

/// Returns true for unit vectors, up to rounding of components to halves.
pub(super) fn is_unit(v: &[f32]) -> bool {
    (v.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() <= UNIT_TOLERANCE
}

/// The part `normal`: unit shading normals in the frame of the reference plane.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMap {
    size: u32,
    /// Exactly representable as halves.
    normals: Vec<[f32; 3]>,
}

impl NormalMap {
    const PART: &'static str = "normal";

    /// Creates a map from `T x T` unit vectors, row by row; components are rounded to halves.
    ///
    /// # Errors
    /// Returns an error if the size is 0 or above 8192, the number of normals is wrong, or a vector does not have unit
    /// length.
    pub fn new(size: u32, normals: Vec<[f32; 3]>) -> Result<Self, FormatError> {
        check_square(Self::PART, size, 1, 1, normals.len())?;
        check_texels(Self::PART, size, &normals, "a unit vector", |n| format!("{n:?}"), |n| is_unit(n))?;
        let mut normals = normals;
        for normal in &mut normals {
            *normal = normal.map(|c| half::decode(half::encode(c)));
        }
        Ok(Self { size, normals })
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Normals rounded to halves, row by row.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Texels in GPU layout: four halves each, the last of them 0.
    pub fn texel_bytes(&self) -> Vec<u8> {
        let texels: Vec<_> =
            self.normals.iter().map(|[x, y, z]| [half::encode(*x), half::encode(*y), half::encode(*z), 0]).collect();
        half_bytes(&texels)
    }

    /// Reads and validates the image of a file.
    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let size = square(texture, Self::PART, TexelFormat::Rgba16Float)?;
        let texels = halves(&texture.texels);
        check_texels(Self::PART, size, &texels, "0 as w", |t| half::decode(t[3]).to_string(), |t| t[3] == 0)?;
        Self::new(size, texels.into_iter().map(|[x, y, z, _]| [x, y, z].map(half::decode)).collect())
    }
}

/// The part `diffuse`: reflectance of a Lambertian surface, fitted to the visible samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiffuseMap {
    size: u32,
    texels: Vec<u32>,
}

impl DiffuseMap {
    const PART: &'static str = "diffuse";

    /// Creates a map from `T x T` texels of [`rgb9e5`], row by row.
    ///
    /// # Errors
    /// Returns an error if the size is 0 or above 8192, or the number of texels is wrong.
    pub fn new(size: u32, texels: Vec<u32>) -> Result<Self, FormatError> {
        check_square(Self::PART, size, 1, 1, texels.len())?;
        Ok(Self { size, texels })
    }

    /// Creates a map from `T x T` colours, linear RGB, row by row, which are rounded to [`rgb9e5`].
    ///
    /// # Errors
    /// Returns an error if the size is 0 or above 8192, or the number of colours is wrong.
    pub fn from_colours(size: u32, colours: &[[f32; 3]]) -> Result<Self, FormatError> {
        Self::new(size, colours.iter().map(|colour| rgb9e5::encode(*colour)).collect())
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Packed texels, row by row.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Reads and validates the image of a file.
    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let size = square(texture, Self::PART, TexelFormat::Rgb9E5)?;
        Self::new(size, packed_words(&texture.texels))
    }
}

/// The part `reference`: parameters of the surface point visible through each texel of the reference plane `z = 0` in
/// the view along the normal. Must not be filtered.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceMap {
    size: u32,
    parameters: Vec<[f32; 2]>,
}

impl ReferenceMap {
    const PART: &'static str = "reference";

    /// Creates a map from `M x M` pairs of parameters, row by row. Only their fractional parts matter.
    ///
    /// # Errors
    /// Returns an error if the size is 0 or above 8192, the number of pairs is wrong, or parameters exceed
    /// [`super::MAX_COORDINATE`] or are NaN.
    pub fn new(size: u32, parameters: Vec<[f32; 2]>) -> Result<Self, FormatError> {
        check_square(Self::PART, size, 1, 1, parameters.len())?;
        let good = |p: &[f32; 2]| p.iter().all(|c| is_coordinate(*c));
        check_texels(Self::PART, size, &parameters, "parameters of -1024 to 1024", |p| format!("{p:?}"), good)?;
        Ok(Self { size, parameters })
    }

    /// `M`, texels per side.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Parameters, row by row: texel `(i, j)` has its centre at `((i + ½) / M, (j + ½) / M)` on the plane.
    pub fn parameters(&self) -> &[[f32; 2]] {
        &self.parameters
    }

    /// Reads and validates the image of a file.
    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let size = square(texture, Self::PART, TexelFormat::Rg32Float)?;
        Self::new(size, floats::<2>(&texture.texels))
    }
}
