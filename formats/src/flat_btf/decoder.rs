//! CPU decoder, the reference for shaders: f32 operations in a fixed order without fused operations.

use super::directions::SampledDirections;
use super::factored::{FactoredTexel, Place};
use super::layers::Sheet;
use super::march::{MacroSurface, MarchSteps, ReliefPoint, slope};
use super::relief::{FlatBtfParts, Relief, StoredReflectance};
use super::vdim::VdimSamples;
use super::view_weights::{BlendedDirection, ViewWeights};
use crate::flat_btf_trees::FlatTrees;
use crate::tap::wrap;

/// A flat BTF, ready for random access.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfDecoder {
    parts: FlatBtfParts,
    steps: MarchSteps,
}

impl FlatBtfDecoder {
    /// Creates a decoder, with [`MarchSteps::of`] layers.
    pub fn new(parts: FlatBtfParts) -> Self {
        let steps = parts.relief.layers().map_or(MarchSteps::NONE, |layers| MarchSteps::of(layers.header()));
        Self { parts, steps }
    }

    /// Replaces the steps of rays. Without layers there are none.
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
        let (plane, flat) = (self.parts.relief.size(), self.parts.reflectance.size());
        (f64::from(plane) / f64::from(flat)).log2() as f32
    }

    /// The point of the surface that a distant eye sees behind a point of the reference plane, and its parameters, in
    /// [0, 1). `uv` is in tiles and unbounded; `view` is a unit vector to the viewer. `level_of_detail` refers to the texels
    /// of the flat BTF, 0 the finest.
    pub fn seen(&self, uv: [f32; 2], view: [f32; 3], level_of_detail: f32) -> (ReliefPoint, [f32; 2]) {
        self.seen_on(uv, view, level_of_detail, MacroSurface::PLANE)
    }

    /// Equations 2 and 3 of Hadim et al. 2009, or a ray of sight through the layers in their place.
    fn seen_on(
        &self,
        uv: [f32; 2],
        view: [f32; 3],
        level_of_detail: f32,
        surface: MacroSurface,
    ) -> (ReliefPoint, [f32; 2]) {
        let detail = level_of_detail + self.finer();
        let (point, parameters) = match &self.parts.relief {
            Relief::Layers(layers) => {
                let point = layers.seen(uv, view, surface, detail, self.steps);
                (point, layers.parameters(point.at, point.sheet, detail))
            }
            Relief::Vdim(map, _) => {
                let (parameters, rise) = map.seen(uv, surface.aligned(view), detail);
                (ReliefPoint { at: uv, height: 0.0, sheet: Sheet::Base, rise, steps: 0 }, parameters)
            }
        };
        (point, parameters.map(wrap))
    }

    /// The point of the relief that a view sees behind a point of a surface: `flat_btf_look` of the shader. `uv` is in
    /// tiles and unbounded, `view` a unit vector in the local frame of the point. An indirection map is drawn on the tangent
    /// plane of the point.
    pub fn look(&self, uv: [f32; 2], level_of_detail: f32, view: [f32; 3], surface: MacroSurface) -> FlatBtfLook<'_> {
        let FlatBtfParts { relief, reflectance } = &self.parts;
        let (point, parameters) = self.seen_on(uv, view, level_of_detail, surface);
        let moved = surface.distance_over_tiles([point.at[0] - uv[0], point.at[1] - uv[1]]);
        let tilt = surface.tilt(moved);
        let texel = match reflectance {
            StoredReflectance::Factors(factors) => {
                let mut texel = factors.filtered(parameters, level_of_detail);
                texel.set_normal(surface.stretched(texel.base().normal));
                LookedUp::Factors(texel)
            }
            StoredReflectance::Trees(trees) => LookedUp::Trees(trees, level_of_detail),
        };
        let shadows = relief.shadows().map(|map| Place::new(parameters, level_of_detail, map.size(), map.levels()));
        let (slope, view) = (slope(view), tilted(view, tilt));
        FlatBtfLook {
            decoder: self,
            surface,
            detail: level_of_detail + self.finer(),
            point,
            parameters,
            moved,
            slope,
            tilt,
            view,
            texel,
            shadows,
        }
    }

    /// Equation 1, `BTF = FBTF(VDIM)`, on the reference plane: radiance divided by that of a white diffuser that faces
    /// the light, in linear RGB, 0 or more. Through layers, a ray of sight replaces the view-dependent indirection map.
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
        self.look(uv, level_of_detail, view.direction, MacroSurface::PLANE).value(view, light)
    }

    /// [`FlatBtfDecoder::value`] for any view and light, unit vectors: `flat_btf_value` of the shader. `directions` are
    /// those of the asset: [`SampledDirections::of`].
    pub fn shaded(
        &self,
        directions: Option<&SampledDirections>,
        uv: [f32; 2],
        level_of_detail: f32,
        view: [f32; 3],
        light: [f32; 3],
    ) -> [f32; 3] {
        self.look(uv, level_of_detail, view, MacroSurface::PLANE).shaded(directions, light)
    }
}

/// Reflectance at a point.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)]
enum LookedUp<'a> {
    Factors(FactoredTexel<'a>),
    /// Trees, which are looked up for each light at this level of detail.
    Trees(&'a FlatTrees, f32),
}

/// A point of the relief as one view sees it.
#[derive(Debug, Clone)]
pub struct FlatBtfLook<'a> {
    decoder: &'a FlatBtfDecoder,
    surface: MacroSurface,
    /// Level of the layers.
    detail: f32,
    point: ReliefPoint,
    /// Parameters of `point`.
    parameters: [f32; 2],
    /// Distance of `point` along the surface from the point that is drawn, in sides of a tile.
    moved: [f32; 2],
    /// Tangent of the view's polar angle where it is drawn.
    slope: [f32; 2],
    /// See [`MacroSurface::tilt`].
    tilt: [f32; 2],
    /// The view in the frame below `point`.
    view: [f32; 3],
    texel: LookedUp<'a>,
    /// In sampled shadows, if there are any.
    shadows: Option<Place>,
}

impl FlatBtfLook<'_> {
    /// Returns true if the ray of sight passes the relief of a convex surface: nothing is to be drawn.
    pub fn passes(&self) -> bool {
        self.point.height < 0.0
    }

    /// Distance of the visible point along tangent and bitangent of the surface from the point that is drawn, in sides of a
    /// tile.
    pub fn moved(&self) -> [f32; 2] {
        self.moved
    }

    /// Unit normal of the relief, in the frame of the surface below the visible point. Trees store none: that of the surface.
    pub fn normal(&self) -> [f32; 3] {
        match &self.texel {
            LookedUp::Factors(texel) => texel.base().normal,
            LookedUp::Trees(..) => [0.0, 0.0, 1.0],
        }
    }

    /// Parameters of the visible point, in [0, 1).
    pub fn parameters(&self) -> [f32; 2] {
        self.parameters
    }

    /// Base and components at the visible point; `None` for trees.
    pub fn texel(&self) -> Option<&FactoredTexel<'_>> {
        match &self.texel {
            LookedUp::Factors(texel) => Some(texel),
            LookedUp::Trees(..) => None,
        }
    }

    /// The visible point.
    pub fn point(&self) -> ReliefPoint {
        self.point
    }

    /// Position of the visible point less that of the point that is drawn, in the local frame and in tiles: along the
    /// line of sight. Distances and directions to near lights begin there.
    pub fn offset(&self) -> [f32; 3] {
        let [x, y] = self.slope;
        [self.point.rise * x, self.point.rise * y, self.point.rise]
    }

    /// Value under a light, a unit vector in the local frame of the point that is drawn: `flat_btf_shade` of the
    /// shader. `directions` are those of the asset: [`SampledDirections::of`].
    ///
    /// A light that is lower than all sampled ones has the value of the nearest sampled direction, times the ratio of
    /// cosines, so that a surface goes dark towards the horizon of its light without a step.
    pub fn shaded(&self, directions: Option<&SampledDirections>, light: [f32; 3]) -> [f32; 3] {
        let light = tilted(light, self.tilt);
        if light[2] <= 0.0 {
            return [0.0; 3];
        }
        let aligned = [self.view, light].map(|direction| self.surface.aligned(direction));
        let [views, lights] = SampledDirections::blended(directions, aligned[0], aligned[1]);
        let views = BlendedDirection { direction: self.view, ..views };
        let lights = BlendedDirection { direction: light, ..lights };
        let dimmed = match &self.decoder.parts.reflectance {
            // Without components, the base is exact for any light.
            StoredReflectance::Factors(factors) => directions
                .filter(|_| factors.header().groups > 0)
                .map_or(1.0, |some| (light[2] / some.lowest_light).min(1.0)),
            StoredReflectance::Trees(trees) => trees.dimmed(light),
        };
        self.value(views, lights).map(|value| value * dimmed)
    }

    /// Share, 0 to 1, of a light above the normal that reaches the visible point. `light` is in the frame below the point;
    /// `lights` are sampled ones that approximate it, for sampled shadows.
    fn lit(&self, light: [f32; 3], lights: ViewWeights) -> f32 {
        match (&self.decoder.parts.relief, &self.shadows) {
            (Relief::Layers(layers), _) => {
                layers.lit(&self.point, self.normal(), light, self.surface, self.detail, self.decoder.steps)
            }
            (Relief::Vdim(_, Some(shadows)), Some(place)) => shadows.lit(place, lights),
            (Relief::Vdim(..), _) => 1.0,
        }
    }

    /// Share, 0 to 1, of a light above the normal that reaches the visible point, before the reflectance. `light` is a unit
    /// vector in the local frame of the point that is drawn; `directions` are those of the asset.
    pub fn reached(&self, directions: Option<&SampledDirections>, light: [f32; 3]) -> f32 {
        let light = tilted(light, self.tilt);
        let [_, lights] = SampledDirections::blended(directions, self.view, self.surface.aligned(light));
        self.lit(light, lights.samples)
    }

    /// Filtered fetches of the relief: those of the parameters, and those of the shadow. Without components.
    #[doc(hidden)]
    pub fn fetches(&self, light: [f32; 3]) -> [u32; 2] {
        let (normal, light) = (self.normal(), tilted(light, self.tilt));
        let unlit = self.passes()
            || light[2] <= 0.0
            || normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2] <= 0.0;
        let steps = self.decoder.steps;
        match &self.decoder.parts.relief {
            Relief::Layers(layers) => {
                let refined = if self.passes() { 0 } else { steps.refine };
                let march = || layers.lit_counted(&self.point, normal, light, self.surface, self.detail, steps).1;
                [1 + self.point.steps + refined + 1, if unlit { 0 } else { march() }]
            }
            Relief::Vdim(map, shadows) => {
                let of_map = match map.samples() {
                    VdimSamples::Halves(_) => 2,
                    // With two of ranges, and one of the height.
                    VdimSamples::Compact(_) => 5,
                };
                [of_map, if unlit || shadows.is_none() { 0 } else { 3 }]
            }
        }
    }

    /// Value of directions in the frame below the point.
    fn value(&self, view: BlendedDirection, light: BlendedDirection) -> [f32; 3] {
        let texel = match &self.texel {
            LookedUp::Factors(texel) => texel,
            LookedUp::Trees(trees, level) => return self.value_of_trees(trees, *level, view.direction, light),
        };
        let value = texel.blended(view, light);
        let (normal, to) = (self.normal(), light.direction);
        let is_turned_away = normal[0] * to[0] + normal[1] * to[1] + normal[2] * to[2] <= 0.0;
        let lit = if value == [0.0; 3] || is_turned_away { 0.0 } else { self.lit(to, light.samples) };
        texel.shadowed(value, light.samples, lit)
    }

    /// [`Self::value`] of trees, whose mesh of views replaces the sampled ones.
    fn value_of_trees(&self, trees: &FlatTrees, level: f32, view: [f32; 3], light: BlendedDirection) -> [f32; 3] {
        let aligned = [view, light.direction].map(|direction| self.surface.aligned(direction));
        let value = trees.value(self.parameters, level, aligned[0], aligned[1]);
        let is_complete = value == [0.0; 3] || trees.has_shadows();
        let lit = if is_complete { 1.0 } else { self.lit(light.direction, light.samples) };
        value.map(|value| value * lit)
    }
}

/// A direction in the frame of a normal whose x and y are `tilt`, with z = 1.
fn tilted([x, y, z]: [f32; 3], tilt: [f32; 2]) -> [f32; 3] {
    if tilt == [0.0; 2] {
        return [x, y, z];
    }
    let turned = [x - z * tilt[0], y - z * tilt[1], z + x * tilt[0] + y * tilt[1]];
    let length = (turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2]).sqrt();
    turned.map(|c| c / length)
}
