//! A flat BTF as a material of surfaces.

use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::{BlendedDirection, FlatBtfDecoder, SampledDirections, ViewWeights};

/// Form in which a flat BTF is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlatForm {
    /// Every sampled view and light (equation 1 of Hadim et al. 2009), blended between the directions of the samples.
    Full,
    /// A diffuse colour under a normal map (section 3.5).
    Light,
}

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
        let directions = SampledDirections::of(&decoder.parts().values)?;
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

    /// Returns true if there are values of views and lights, which [`FlatForm::Full`] needs.
    pub fn has_views(&self) -> bool {
        self.directions.is_some()
    }

    /// The blending of sampled directions.
    ///
    /// # Panics
    /// If the material has no values of views.
    pub fn sampled_directions(&self) -> &SampledDirections {
        self.directions.as_ref().expect("the full form needs views")
    }

    /// Relative radiance at the coordinates `uv` of a mesh. `view` and `light` are unit vectors in the local frame;
    /// `level_of_detail` is the mipmap level of the texels, 0 the finest, and has no effect without mipmaps.
    ///
    /// Lights lower than all sampled directions have the value of the nearest sampled direction, times the ratio of cosines,
    /// so that a surface goes dark towards the horizon of its light without a step. The light form does not need this.
    ///
    /// # Panics
    /// For the full form without views.
    pub fn value(&self, form: FlatForm, uv: [f64; 2], level_of_detail: f32, view: Vector, light: Vector) -> [f32; 3] {
        let single = |v: Vector| v.map(|c| c as f32);
        let tile = uv.map(|c| c as f32 * self.repeat as f32);
        let (view, light) = (single(view), single(light));
        match form {
            FlatForm::Light => self.decoder.light_form(tile, view, light),
            FlatForm::Full => {
                let directions = self.sampled_directions();
                let blended = |mesh: &DirectionMesh, direction| {
                    let (indices, weights) = mesh.weights(direction);
                    BlendedDirection { direction, samples: ViewWeights { indices, weights } }
                };
                let dimmed = (light[2] / directions.lowest_light).min(1.0);
                let (view, light) = (blended(&directions.views, view), blended(&directions.lights, light));
                self.decoder.value(tile, level_of_detail, view, light).map(|value| value * dimmed)
            }
        }
    }
}
