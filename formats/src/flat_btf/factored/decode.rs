//! CPU decoder, the reference for shaders: f32 operations in a fixed order without fused operations.

use super::base::{BaseTexel, TablePlace, base_texel};
use super::basis::BasisMap;
use super::domain::{from_opponent, to_opponent};
use super::header::{BASE_LAYERS, FactoredErrors, FactoredHeader, GROUP, MAX_GROUPS};
use super::maps::{ResidualMap, WeightMap};
use crate::FormatError;
use crate::container::rgb9e5;
use crate::flat_btf::flat_view::{FlatHeader, FlatView, unit_vectors};
use crate::flat_btf::view_weights::{BlendedDirection, ViewWeights, raised};
use crate::tap::{footprint, periodic_tap, wrap};

const MAX_COMPONENTS: usize = MAX_GROUPS as usize * GROUP;
const BASE_NUMBERS: usize = BASE_LAYERS as usize * GROUP;
/// Step of a byte.
const UNIT: f32 = 1.0 / 255.0;

/// Factored flat BTF: a base plus a sum of components for each view and light with weights for each texel, and the
/// residual of shadows. It replaces all views. Without components, the base alone is the value.
#[derive(Debug, Clone, PartialEq)]
pub struct FactoredFlatBtf {
    basis: BasisMap,
    weights: WeightMap,
    residual: Option<ResidualMap>,
    views: Vec<[f32; 3]>,
    lights: Vec<[f32; 3]>,
    lowest_light: f32,
}

/// Texels around a point on the two mipmap levels around a level of detail.
#[derive(Debug, Clone, Copy)]
pub(in crate::flat_btf) struct Place {
    level: u32,
    fine: [(usize, f32); 4],
    /// Coarser level with its weight, unless the weight is 0.
    coarse: Option<([(usize, f32); 4], f32)>,
}

/// One texel of a factored flat BTF.
#[derive(Debug, Clone)]
pub struct FactoredTexel<'a> {
    asset: &'a FactoredFlatBtf,
    /// In the residual, if there is one.
    cells: Option<Place>,
    base: BaseTexel,
    components: [f32; MAX_COMPONENTS],
}

impl FactoredTexel<'_> {
    /// Values of the base.
    pub fn base(&self) -> &BaseTexel {
        &self.base
    }

    /// Replaces the unit normal.
    pub(in crate::flat_btf) fn set_normal(&mut self, normal: [f32; 3]) {
        self.base.normal = normal;
    }

    /// Value in a view under a light, before shadows.
    ///
    /// # Panics
    /// Panics if there is no such view or light.
    pub fn value(&self, view: u32, light: u32) -> [f32; 3] {
        let asset = self.asset;
        let directions = [asset.views[view as usize], asset.lights[light as usize]];
        asset.colour(&self.base, directions, asset.sum(&self.components, view, light))
    }

    /// A value if `lit` of a light, 0 to 1, reaches the texel: that share of it without a residual. `lights` are sampled
    /// ones, blended.
    ///
    /// # Panics
    /// Panics if there is a residual and no such light.
    pub fn shadowed(&self, value: [f32; 3], lights: ViewWeights, lit: f32) -> [f32; 3] {
        let (Some(residual), Some(cells)) = (&self.asset.residual, &self.cells) else {
            return value.map(|channel| channel * lit);
        };
        let mut roots = [0.0f32; 2];
        for (light, weight) in lights.indices.into_iter().zip(lights.weights) {
            if weight == 0.0 {
                continue;
            }
            for (channel, root) in roots.iter_mut().enumerate() {
                *root += weight * cells.sample(|level, at| residual.layer(level, light)[2 * at + channel]);
            }
        }
        let [reached, shaded] = roots.map(ResidualMap::share);
        let (reached, shaded) = (lit * reached, (1.0 - lit) * shaded);
        [0, 1, 2].map(|c: usize| value[c] * reached + self.base.diffuse[c] * shaded)
    }

    /// Value in a view under a light, before shadows, relative to a white diffuser that faces the light: linear RGB, 0 or
    /// more. Sums of components are blended over the sampled directions. The base is evaluated for the exact directions,
    /// with the light raised to the lowest sampled light. Without components only the base is evaluated.
    ///
    /// # Panics
    /// Panics if weights refer to views or lights that do not exist.
    pub fn blended(&self, view: BlendedDirection, light: BlendedDirection) -> [f32; 3] {
        let asset = self.asset;
        if asset.header().groups == 0 {
            return asset.basis.colour(&self.base, view.direction, light.direction);
        }
        let (views, lights) = (view.samples, light.samples);
        let mut sum = [0.0f32; 3];
        for (view, view_weight) in views.indices.into_iter().zip(views.weights) {
            if view_weight == 0.0 {
                continue;
            }
            for (k, light) in lights.indices.into_iter().enumerate() {
                if lights.weights[k] == 0.0 {
                    continue;
                }
                let weight = view_weight * lights.weights[k];
                let of_pair = asset.sum(&self.components, view, light);
                for colour in 0..3 {
                    sum[colour] += weight * of_pair[colour];
                }
            }
        }
        let light = raised(light.direction, asset.lowest_light);
        asset.colour(&self.base, [view.direction, light], sum)
    }
}

impl Place {
    pub(in crate::flat_btf) fn new(uv: [f32; 2], level_of_detail: f32, size: u32, levels: u32) -> Self {
        let uv = uv.map(wrap);
        let detail = level_of_detail.max(0.0).min((levels - 1) as f32);
        let finer = detail.floor();
        let blend = detail - finer;
        let texels = |level: u32| {
            let side = (size >> level).max(1);
            let taps = footprint(periodic_tap(uv[0], side), periodic_tap(uv[1], side));
            taps.map(|([column, row], weight)| ((row * side + column) as usize, weight))
        };
        let level = finer as u32;
        Self { level, fine: texels(level), coarse: (blend > 0.0).then(|| (texels(level + 1), blend)) }
    }

    /// Filtered component; `texel(level, index)` is 0 to 255.
    pub(in crate::flat_btf) fn sample(&self, texel: impl Fn(u32, usize) -> u8) -> f32 {
        let filtered = |level: u32, taps: [(usize, f32); 4]| {
            taps.into_iter().fold(0.0f32, |sum, (at, weight)| sum + weight * (f32::from(texel(level, at)) * UNIT))
        };
        let fine = filtered(self.level, self.fine);
        match self.coarse {
            Some((taps, blend)) => fine + blend * (filtered(self.level + 1, taps) - fine),
            None => fine,
        }
    }
}

impl FactoredFlatBtf {
    /// Creates an asset after checking that the parts match.
    ///
    /// # Errors
    /// Returns an error that names a part whose size, levels or layers differ from the basis, or that is missing or
    /// superfluous.
    pub fn new(basis: BasisMap, weights: WeightMap, residual: Option<ResidualMap>) -> Result<Self, FormatError> {
        let header = basis.header();
        let text = |[size, levels, layers]: [u32; 3]| format!("{levels} levels of {layers} layers of {size} x {size}");
        let same = |part: &str, found: [u32; 3], expected: [u32; 3]| {
            if found == expected {
                return Ok(());
            }
            let allowed = format!("{}, as the header says", text(expected));
            Err(FormatError::whole(format!("size of the part {part}"), text(found), allowed))
        };
        let of_weights = [header.size, header.levels, BASE_LAYERS + header.groups];
        same("weights", [weights.size(), weights.levels(), weights.layers()], of_weights)?;
        match (&residual, header.residual) {
            (None, 0) => {}
            (Some(map), 1..) => {
                let expected = [header.residual, map.levels(), header.lights.len() as u32];
                same("residual", [map.size(), map.levels(), map.lights()], expected)?;
            }
            (None, _) => {
                return Err(FormatError::whole("part residual", "missing", "a part, as the header requires").problem());
            }
            (Some(_), _) => {
                let allowed = "no part, as the header requires";
                return Err(FormatError::whole("part residual", "superfluous", allowed).problem());
            }
        }
        let (views, lights) = (unit_vectors(&header.views), unit_vectors(&header.lights));
        let lowest_light = lights.iter().map(|light| light[2]).reduce(f32::min).unwrap_or(0.0);
        Ok(Self { basis, weights, residual, views, lights, lowest_light })
    }

    /// Header of the asset.
    pub fn header(&self) -> &FactoredHeader {
        self.basis.header()
    }

    /// The part `basis`.
    pub fn basis(&self) -> &BasisMap {
        &self.basis
    }

    /// The part `weights`.
    pub fn weights(&self) -> &WeightMap {
        &self.weights
    }

    /// The part `residual`, if there is one.
    pub fn residual(&self) -> Option<&ResidualMap> {
        self.residual.as_ref()
    }

    /// Octaves between texels and cells of the residual; 0 without one.
    pub(super) fn residual_octaves(&self) -> f32 {
        let FactoredHeader { size, residual, .. } = self.header();
        if *residual == 0 { 0.0 } else { (*size as f32 / *residual as f32).log2() }
    }

    /// Cells of the residual around a point; none without one.
    fn cells(&self, uv: [f32; 2], level_of_detail: f32) -> Option<Place> {
        let map = self.residual.as_ref()?;
        let detail = level_of_detail.max(0.0).min((self.header().levels - 1) as f32) - self.residual_octaves();
        Some(Place::new(uv, detail, map.size(), map.levels()))
    }

    /// Replaces the measured errors in the header.
    #[must_use]
    pub fn with_errors(self, errors: FactoredErrors) -> Self {
        Self { basis: self.basis.with_errors(errors), ..self }
    }

    /// GPU memory including mipmaps, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        self.header().gpu_bytes()
    }

    /// Filtered texels at parameters of the flat BTF. `uv` is unbounded with period 1; `level_of_detail` refers to the
    /// texels, 0 the finest.
    pub fn filtered(&self, uv: [f32; 2], level_of_detail: f32) -> FactoredTexel<'_> {
        let place = Place::new(uv, level_of_detail, self.header().size, self.header().levels);
        let (base, components) = self.texel_at(&place);
        FactoredTexel { asset: self, cells: self.cells(uv, level_of_detail), base, components }
    }

    /// Height of the lowest sampled light above the surface, the cosine of its polar angle; 0 without lights.
    pub fn lowest_light(&self) -> f32 {
        self.lowest_light
    }

    /// Texel `[column, row]` of the finest level, for all views and lights.
    ///
    /// # Panics
    /// Panics if there is no such texel.
    pub fn texel(&self, [column, row]: [u32; 2]) -> FactoredTexel<'_> {
        let size = self.header().size;
        assert!(column < size && row < size, "texel ({column}, {row}) of {size} x {size}");
        let at = (row * size + column) as usize;
        let place = Place { level: 0, fine: [(at, 1.0), (at, 0.0), (at, 0.0), (at, 0.0)], coarse: None };
        let (base, components) = self.texel_at(&place);
        let centre = [column, row].map(|at| (at as f32 + 0.5) / size as f32);
        FactoredTexel { asset: self, cells: self.cells(centre, 0.0), base, components }
    }

    /// Reconstructs an uncompressed view at the finest level, before shadows.
    ///
    /// # Panics
    /// Panics if there is no such view.
    pub fn view(&self, view: u32) -> FlatView {
        let FactoredHeader { size, views, lights, .. } = self.header();
        let (size, pixels) = (*size, (*size * *size) as usize);
        let mut texels = vec![0; lights.len() * pixels];
        for at in 0..pixels {
            let texel = self.texel([at as u32 % size, at as u32 / size]);
            for light in 0..lights.len() {
                texels[light * pixels + at] = rgb9e5::encode(texel.value(view, light as u32));
            }
        }
        let header = FlatHeader { size, view, views: views.clone(), lights: lights.clone() };
        FlatView::new(header, texels).expect("the directions were checked, and values are not negative")
    }

    /// Values of the base and weights of all components at a place.
    fn texel_at(&self, place: &Place) -> (BaseTexel, [f32; MAX_COMPONENTS]) {
        let (mut base, mut components) = ([0.0; BASE_NUMBERS], [0.0; MAX_COMPONENTS]);
        let (bases, groups) = (base.chunks_exact_mut(GROUP), components.chunks_exact_mut(GROUP));
        let ranges = self.weights.ranges().chunks_exact(GROUP);
        for (layer, (numbers, ranges)) in (0..).zip(bases.chain(groups).zip(ranges)) {
            let of_level = |level| self.weights.layer(level, layer);
            let fine = of_level(place.level);
            let coarse = place.coarse.map(|_| of_level(place.level + 1));
            for (channel, (number, range)) in numbers.iter_mut().zip(ranges).enumerate() {
                let texels = |level| coarse.filter(|_| level > place.level).unwrap_or(fine);
                let sample = place.sample(|level, at| texels(level)[at * GROUP + channel]);
                *number = range.low + range.scale * sample;
            }
        }
        let blend = place.coarse.map_or(0.0, |(_, blend)| blend);
        (base_texel(TablePlace::new(place.level, blend, self.header().table_levels), base), components)
    }

    /// Sum of the components in a view under a light, which is added to the base.
    fn sum(&self, components: &[f32; MAX_COMPONENTS], view: u32, light: u32) -> [f32; 3] {
        let steps = &self.header().steps;
        [0, 1, 2].map(|colour: usize| {
            let terms = components.iter().zip(&steps[colour]).zip(self.basis.integers(view, light, colour));
            terms.fold(0.0f32, |sum, ((weight, step), integer)| sum + (weight * step) * integer)
        })
    }

    /// Colour of a base and a sum in a view under an unshadowed light.
    fn colour(&self, base: &BaseTexel, [view, light]: [[f32; 3]; 2], sum: [f32; 3]) -> [f32; 3] {
        let opponent = to_opponent(self.basis.colour(base, view, light));
        let all = [opponent[0] + sum[0], opponent[1] + sum[1], opponent[2] + sum[2]];
        from_opponent(self.header().chroma.bound(all))
    }
}
