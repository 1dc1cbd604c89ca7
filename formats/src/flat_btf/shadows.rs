//! Sampled shadows of a flat BTF: the share of each sampled light that reaches each texel (section 3.3 of Hadim et al. 2009).

use super::factored::{ByteLayers, Place};
use super::flat_view::{LIGHTS, MAX_DIRECTIONS, check_directions, direction_entry, read_directions};
use super::layout::wrong_extent;
use super::view_weights::ViewWeights;
use crate::FormatError;
use crate::container::{TexelFormat, Texture};

const PART: &str = "shadows";

/// Shares of the light of sampled lights that reach the texels of the flat BTF, with mipmaps.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowMap {
    /// Polar angle and azimuth of each light, radians.
    lights: Vec<[f32; 2]>,
    layers: ByteLayers,
}

impl ShadowMap {
    /// Creates a map of `size` texels per side from bytes, 255 for all of the light: all mipmap levels from the finest, light
    /// by light, row by row.
    ///
    /// # Errors
    /// Returns an error if sizes or directions are out of range, or the number of bytes is wrong.
    pub fn new(lights: Vec<[f32; 2]>, size: u32, levels: u32, texels: Vec<u8>) -> Result<Self, FormatError> {
        check_directions(&lights, &lights)?;
        let (part, format, count) = (PART, TexelFormat::R8Unorm, lights.len() as u32);
        let layers = ByteLayers { part, format, size, layers: count, levels, texels }.check(MAX_DIRECTIONS)?;
        Ok(Self { lights, layers })
    }

    /// Polar angles, 0 to π/2, and azimuths, [0, 2π), of the lights, radians.
    pub fn lights(&self) -> &[[f32; 2]] {
        &self.lights
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.layers.size
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.layers.levels
    }

    /// All texels in GPU layout.
    pub fn texels(&self) -> &[u8] {
        &self.layers.texels
    }

    /// Share, 0 to 1, of the light of blended sampled lights that reaches a place of the flat BTF.
    pub(super) fn lit(&self, place: &Place, lights: ViewWeights) -> f32 {
        let mut lit = 0.0f32;
        for (light, weight) in lights.indices.into_iter().zip(lights.weights) {
            if weight != 0.0 {
                lit += weight * place.sample(|level, at| self.layers.layer(level, light)[at]);
            }
        }
        lit
    }

    /// Key and value of the lights.
    pub(super) fn entry(&self) -> (String, Vec<u8>) {
        direction_entry(LIGHTS, &self.lights)
    }

    /// Reads and validates the image of a file and its `lights` directions.
    pub(super) fn from_texture(texture: Texture, lights: u32) -> Result<Self, FormatError> {
        let lights = read_directions(&texture, "a flat BTF with sampled shadows", LIGHTS, lights)?;
        let layers = ByteLayers::from_texture(texture, PART, TexelFormat::R8Unorm, MAX_DIRECTIONS)?;
        if layers.layers as usize != lights.len() {
            let allowed = format!("{} layers, one for each light", lights.len());
            return Err(wrong_extent(PART, layers.extent(), allowed));
        }
        Self::new(lights, layers.size, layers.levels, layers.texels)
    }
}
