//! A flat BTF as a material of surfaces.

use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{BlendedDirection, FlatBtfDecoder, ViewWeights};

/// What is drawn of a flat BTF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlatForm {
    /// Every sampled view and light (equation 1 of Hadim et al. 2009), blended between the directions of the samples.
    Full,
    /// A diffuse colour under a normal map (section 3.5).
    Light,
}

/// A flat BTF, and what is needed to put it on a surface.
#[derive(Debug, Clone)]
pub struct FlatMaterial {
    decoder: FlatBtfDecoder,
    repeat: u32,
    directions: Option<SampledDirections>,
}

/// Between the sampled directions of the full form.
#[derive(Debug, Clone)]
pub struct SampledDirections {
    /// Of views.
    pub views: DirectionMesh,
    /// Of lights.
    pub lights: DirectionMesh,
    /// Cosine of the largest polar angle of a sampled light.
    pub lowest_light: f32,
}

impl FlatMaterial {
    /// A material that repeats `repeat` times per unit of a mesh's uv. A whole number, 1 or more, so that it closes
    /// where u has gone once around.
    ///
    /// # Errors
    /// SampledDirections directions that cannot be blended: what [`DirectionMesh::new`] refuses; a repetition of 0.
    pub fn new(decoder: FlatBtfDecoder, repeat: u32) -> Result<Self, FormatError> {
        if repeat == 0 {
            return Err(FormatError::whole("repeat", "0", "1 or more tiles per unit of uv"));
        }
        let directions = match decoder.parts().values.directions() {
            None => None,
            Some([views, lights]) => {
                let mesh = |name: &str, angles: &[[f32; 2]]| {
                    let angles = angles.iter().map(|angles| angles.map(|angle| f64::from(angle).to_degrees()));
                    DirectionMesh::new(&DirectionSet::new(name, angles.collect())?)
                };
                let largest = lights.iter().map(|[polar, _]| *polar).fold(0.0, f32::max);
                Some(SampledDirections {
                    views: mesh("views", views)?,
                    lights: mesh("lights", lights)?,
                    lowest_light: f64::from(largest).cos() as f32,
                })
            }
        };
        Ok(Self { decoder, repeat, directions })
    }

    /// The parts.
    pub fn decoder(&self) -> &FlatBtfDecoder {
        &self.decoder
    }

    /// Tiles per unit of a mesh's uv.
    pub fn repeat(&self) -> u32 {
        self.repeat
    }

    /// Whether there are values of views and lights: [`FlatForm::Full`] needs them.
    pub fn has_views(&self) -> bool {
        self.directions.is_some()
    }

    /// What blends sampled directions.
    ///
    /// # Panics
    /// Without values of views.
    pub fn sampled_directions(&self) -> &SampledDirections {
        self.directions.as_ref().expect("the full form needs views")
    }

    /// Relative radiance at the coordinates `uv` of a mesh. `view` and `light` are unit vectors in the local frame;
    /// `level_of_detail` is that of the texels, 0 the finest, and makes a difference where they have mipmaps.
    ///
    /// Lights lower than all sampled ones have the value of the nearest sampled direction, times the ratio of cosines:
    /// a surface goes dark towards the horizon of its light without a step. The light form needs none of this.
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
