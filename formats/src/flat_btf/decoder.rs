//! CPU decoder, the reference for shaders: f32 operations in a fixed order without fused operations.

use super::directions::SampledDirections;
use super::factored::FactoredFlatBtf;
use super::layers::LayerMap;
use super::march::{MarchSteps, ReliefPoint};
use super::view_weights::BlendedDirection;
use crate::tap::wrap;

/// Parts of one asset that a decoder reads.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfParts {
    /// Heights of the relief and its parameters.
    pub layers: LayerMap,
    /// Reflectance of the surface over its parameters.
    pub reflectance: FactoredFlatBtf,
}

/// A flat BTF, ready for random access.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfDecoder {
    parts: FlatBtfParts,
    steps: MarchSteps,
}

impl FlatBtfDecoder {
    /// Creates a decoder with [`MarchSteps::of`] the relief.
    pub fn new(parts: FlatBtfParts) -> Self {
        let steps = MarchSteps::of(parts.layers.header());
        Self { parts, steps }
    }

    /// Replaces the steps of rays.
    #[must_use]
    pub fn with_steps(self, steps: MarchSteps) -> Self {
        Self { steps, ..self }
    }

    /// Parts of the asset.
    pub fn parts(&self) -> &FlatBtfParts {
        &self.parts
    }

    /// Steps of rays.
    pub fn steps(&self) -> MarchSteps {
        self.steps
    }

    /// Converts the decoder back to the parts of the asset.
    pub fn into_parts(self) -> FlatBtfParts {
        self.parts
    }

    /// Octaves by which texels of the relief are smaller than texels of the flat BTF.
    pub fn finer(&self) -> f32 {
        let (plane, flat) = (self.parts.layers.header().size, self.parts.reflectance.header().size);
        (f64::from(plane) / f64::from(flat)).log2() as f32
    }

    /// The point of the surface that a distant eye sees behind a point of the reference plane. `uv` is in tiles and
    /// unbounded; `view` is a unit vector to the viewer. `level_of_detail` refers to the texels of the flat BTF, 0 the
    /// finest.
    pub fn seen(&self, uv: [f32; 2], view: [f32; 3], level_of_detail: f32) -> ReliefPoint {
        self.parts.layers.seen(uv, view, level_of_detail + self.finer(), self.steps)
    }

    /// Parameters, in [0, 1), of a point of the surface: equation 3 of Hadim et al. 2009 without sampled views.
    pub fn parameters(&self, point: &ReliefPoint, level_of_detail: f32) -> [f32; 2] {
        self.parts.layers.parameters(point.at, point.sheet, level_of_detail + self.finer()).map(wrap)
    }

    /// Equation 1, `BTF = FBTF(VDIM)`: radiance divided by that of a white diffuser that faces the light, in linear
    /// RGB, 0 or more. A ray of sight replaces the view-dependent indirection map.
    ///
    /// # Panics
    /// Panics if samples refer to views or lights that do not exist.
    pub fn value(
        &self,
        uv: [f32; 2],
        level_of_detail: f32,
        view: BlendedDirection,
        light: BlendedDirection,
    ) -> [f32; 3] {
        let FlatBtfParts { layers, reflectance } = &self.parts;
        let detail = level_of_detail + self.finer();
        let point = layers.seen(uv, view.direction, detail, self.steps);
        let texel = reflectance.filtered(layers.parameters(point.at, point.sheet, detail).map(wrap), level_of_detail);
        let value = texel.blended(view, light);
        if !layers.header().casts_shadows || value == [0.0; 3] {
            return value;
        }
        let lit = layers.lit(&point, texel.base().normal, light.direction, detail, self.steps);
        value.map(|channel| channel * lit)
    }

    /// [`FlatBtfDecoder::value`] for any view and light, unit vectors: `flat_btf_value` of the shader. `directions` are
    /// those of the reflectance: [`SampledDirections::of`].
    ///
    /// A light that is lower than all sampled ones has the value of the nearest sampled direction, times the ratio of
    /// cosines, so that a surface goes dark towards the horizon of its light without a step.
    pub fn shaded(
        &self,
        directions: Option<&SampledDirections>,
        uv: [f32; 2],
        level_of_detail: f32,
        view: [f32; 3],
        light: [f32; 3],
    ) -> [f32; 3] {
        if light[2] <= 0.0 {
            return [0.0; 3];
        }
        let [views, lights] = SampledDirections::blended(directions, view, light);
        let dimmed = directions.map_or(1.0, |some| (light[2] / some.lowest_light).min(1.0));
        self.value(uv, level_of_detail, views, lights).map(|value| value * dimmed)
    }
}
