//! Values of a flat BTF before factorisation: one view under all lights, and the texels that views see.

use super::layout::{check_square, floats};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{MAX_LAYERS, Texture};
use crate::direction::from_polar;

const PART: &str = "flat";
/// Key of the sampled views.
pub(super) const VIEWS: &str = "brdfc.views";
/// Key of the sampled lights.
pub(super) const LIGHTS: &str = "brdfc.lights";
/// Maximum number of views, and of lights.
pub const MAX_DIRECTIONS: u32 = MAX_LAYERS;

/// A view, and the directions of all views and lights, which are the same throughout the asset.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatHeader {
    /// `T`, texels per side, 1 to 8192.
    pub size: u32,
    /// Index of this view, from 0.
    pub view: u32,
    /// Polar angle, 0 to π/2, and azimuth, [0, 2π), of all views, radians. 1 to [`MAX_DIRECTIONS`].
    pub views: Vec<[f32; 2]>,
    /// Same for all lights.
    pub lights: Vec<[f32; 2]>,
}

impl FlatHeader {
    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error if there are too many directions, a direction is out of range, or the view does not exist.
    pub fn check(&self) -> Result<(), FormatError> {
        check_directions(&self.views, &self.lights)?;
        if self.view as usize >= self.views.len() {
            let allowed = format!("below {}, the number of views", self.views.len());
            return Err(FormatError::whole(format!("view of the part {PART}"), self.view.to_string(), allowed));
        }
        Ok(())
    }
}

/// Unit vectors for polar angles and azimuths, radians. Sines and cosines are computed in double precision and rounded.
pub fn unit_vectors(angles: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let vector = |[polar, azimuth]: &[f32; 2]| from_polar(f64::from(*polar), f64::from(*azimuth)).map(|c| c as f32);
    angles.iter().map(vector).collect()
}

/// Checks the numbers of views and lights, and the ranges of their angles.
pub(super) fn check_directions(views: &[[f32; 2]], lights: &[[f32; 2]]) -> Result<(), FormatError> {
    for (key, directions) in [(VIEWS, views), (LIGHTS, lights)] {
        if !(1..=MAX_DIRECTIONS as usize).contains(&directions.len()) {
            let found = format!("{} directions", directions.len());
            return Err(FormatError::whole(key, found, format!("1 to {MAX_DIRECTIONS}")));
        }
        for (k, [polar, azimuth]) in directions.iter().enumerate() {
            let good =
                (0.0..=std::f32::consts::FRAC_PI_2).contains(polar) && (0.0..std::f32::consts::TAU).contains(azimuth);
            if !good {
                let (field, found) = (format!("{key} direction {k}"), format!("{polar}, {azimuth}"));
                let allowed = "a polar angle of 0 to π/2 and an azimuth of 0 to less than 2π";
                return Err(FormatError::whole(field, found, allowed));
            }
        }
    }
    Ok(())
}

/// Key and value of views or lights.
pub(super) fn direction_entry(key: &'static str, directions: &[[f32; 2]]) -> (String, Vec<u8>) {
    (key.to_owned(), directions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect())
}

/// Reads views or lights. Their number comes from a header of `kind`.
pub(super) fn read_directions(
    texture: &Texture,
    kind: &str,
    key: &'static str,
    count: u32,
) -> Result<Vec<[f32; 2]>, FormatError> {
    Ok(floats::<2>(sized(entry(texture, key, kind)?, key, 8 * count as usize)?))
}

/// Values of the flat BTF for one view: radiance over the radiance of a white diffuser that faces the light.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatView {
    header: FlatHeader,
    texels: Vec<u32>,
}

impl FlatView {
    /// Creates a view from its [`crate::container::rgb9e5`] texels: light by light, each `T x T` row by row.
    ///
    /// # Errors
    /// Returns an error if the header is out of range or the number of texels is not `T x T x lights`.
    pub fn new(header: FlatHeader, texels: Vec<u32>) -> Result<Self, FormatError> {
        header.check()?;
        check_square(PART, header.size, header.lights.len() as u32, MAX_DIRECTIONS, texels.len())?;
        Ok(Self { header, texels })
    }

    /// Header of the view.
    pub fn header(&self) -> &FlatHeader {
        &self.header
    }

    /// All packed texels, light by light.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Packed texels of a light, row by row.
    ///
    /// # Panics
    /// Panics if there is no such light.
    pub fn light(&self, light: u32) -> &[u32] {
        let length = self.header.size as usize * self.header.size as usize;
        &self.texels[light as usize * length..][..length]
    }
}

/// Texels of a flat BTF that each view sees. Values of the other texels were filled in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VisibilityMask {
    size: u32,
    views: u32,
    texels: Vec<u8>,
}

impl VisibilityMask {
    const PART: &'static str = "mask";

    /// Creates a mask from its texels, view by view, each `T x T` row by row: 255 if visible, otherwise 0.
    ///
    /// # Errors
    /// Returns an error if sizes are out of range, the number of texels is wrong, or there are other values.
    pub fn new(size: u32, views: u32, texels: Vec<u8>) -> Result<Self, FormatError> {
        check_square(Self::PART, size, views, MAX_DIRECTIONS, texels.len())?;
        if let Some(at) = texels.iter().position(|texel| !matches!(texel, 0 | 255)) {
            let field = format!("{} texel {at}", Self::PART);
            return Err(FormatError::whole(field, texels[at].to_string(), "0 (filled in) or 255 (seen)"));
        }
        Ok(Self { size, views, texels })
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Number of views.
    pub fn views(&self) -> u32 {
        self.views
    }

    /// Returns true if texel `(column, row)` is visible in a view.
    ///
    /// # Panics
    /// Panics outside the mask.
    pub fn is_seen(&self, view: u32, [column, row]: [u32; 2]) -> bool {
        assert!(column < self.size, "column {column} of {}", self.size);
        let [size, view, column, row] = [self.size, view, column, row].map(|n| n as usize);
        self.texels[(view * size + row) * size + column] == 255
    }
}
