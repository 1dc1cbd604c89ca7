//! A flat BTF as a material of surfaces.

use super::cover::covered;
use crate::scene::Scene;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};

/// A flat BTF, and its mapping to a surface.
#[derive(Debug, Clone)]
pub struct FlatMaterial {
    decoder: FlatBtfDecoder,
    repeat: u32,
    directions: Option<SampledDirections>,
}

impl FlatMaterial {
    /// A material that repeats `repeat` times per unit of a mesh's uv, a whole number of at least 1, so that the material
    /// closes where u completes a turn.
    ///
    /// # Errors
    /// Returns an error if the directions cannot be blended (see [`SampledDirections::new`]), or if `repeat` is 0.
    pub fn new(decoder: FlatBtfDecoder, repeat: u32) -> Result<Self, FormatError> {
        if repeat == 0 {
            return Err(FormatError::whole("repeat", "0", "1 or more tiles per unit of uv"));
        }
        let directions = SampledDirections::of(decoder.parts())?;
        Ok(Self { decoder, repeat, directions })
    }

    /// The decoder.
    pub fn decoder(&self) -> &FlatBtfDecoder {
        &self.decoder
    }

    /// Tiles per unit of a mesh's uv.
    pub fn repeat(&self) -> u32 {
        self.repeat
    }

    /// The blending of sampled directions; `None` without components and sampled shadows.
    pub fn directions(&self) -> Option<&SampledDirections> {
        self.directions.as_ref()
    }

    /// A scene as it is drawn with the relief of this material: [`covered`], unless the relief has no outline of its own.
    pub fn cover(&self, scene: &Scene) -> Scene {
        let outline = self.decoder.parts().relief.outline();
        outline.map_or_else(|| scene.clone(), |heights| covered(scene, self.repeat, heights))
    }

    /// Relative radiance at a position in tiles: [`FlatBtfDecoder::shaded`]. `view` and `light` are unit vectors in the
    /// local frame; `level_of_detail` is the mipmap level of the texels, 0 the finest.
    pub fn value(&self, at: [f32; 2], level_of_detail: f32, view: Vector, light: Vector) -> [f32; 3] {
        let [view, light] = [view, light].map(|direction| direction.map(|c| c as f32));
        self.decoder.shaded(self.directions(), at, level_of_detail, view, light)
    }
}
