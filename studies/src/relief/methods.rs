//! The methods.

use super::shadows::SampledShadows;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::SurfacePoint;
use brdfc_formats::container::half;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::{
    FlatBtfDecoder, FlatBtfParts, LayerHeader, LayerMap, MacroSurface, MarchSteps, Relief, VdimSamples,
};
use brdfc_metrics::image::LinearImage;
use brdfc_render::flat::{FlatMaterial, Tiles, draw_on_cpu, draw_tiles};
use brdfc_render::scene::{Frame, Scene};
use std::sync::atomic::{AtomicU64, Ordering};

/// Draws a scene with tiles per unit of uv.
type Draw<'a> = Box<dyn Fn(&Scene, Frame, u32) -> LinearImage + 'a>;

/// Counts something in a scene with tiles per unit of uv.
type Count<'a> = Box<dyn Fn(&Scene, Frame, u32) -> f64 + 'a>;

/// A method to show a relief. All methods have the same reflectance.
pub(super) struct Method<'a> {
    pub(super) name: &'static str,
    /// Bytes and fetches; `None` for bounds.
    pub(super) stored: Option<Stored<'a>>,
    pub(super) draw: Draw<'a>,
}

/// Bytes and fetches of a method.
pub(super) struct Stored<'a> {
    /// Bytes on a GPU, mipmaps included.
    pub(super) bytes: u64,
    /// Most filtered fetches of a pixel under one light.
    pub(super) fetches: u32,
    /// Mean fetches over the samples and lights of a plane.
    pub(super) mean_fetches: Count<'a>,
}

/// Range of heights of a map without relief, in tiles.
const FLAT: [f32; 2] = [-1e-6, 1e-6];
/// Fetches of the reflectance of a texel, and of the tables of each material for a light.
const OF_TEXEL: u32 = 2;
const OF_MATERIAL: u32 = 1;

/// Number of methods.
pub(super) const COUNT: usize = 8;

/// Shares of the steps of layers, besides all.
const OTHER_STEPS: [(f64, &str); 2] = [(2.0, "layers, twice the steps"), (0.5, "layers, half the steps")];

/// Everything that the methods read.
pub(super) struct Methods<'a> {
    model: &'a MesoModel,
    layers: &'a FlatBtfDecoder,
    /// With the steps of [`OTHER_STEPS`].
    others: [FlatBtfDecoder; 2],
    height_field: FlatBtfDecoder,
    normal_map: FlatBtfDecoder,
    /// The reflectance alone: positions on its plane are parameters.
    reflectance: FlatBtfDecoder,
    /// With an indirection map and sampled shadows.
    sampled: &'a FlatBtfDecoder,
    shadows: SampledShadows,
}

impl<'a> Methods<'a> {
    /// Methods for a surface, encoded with layers and with an indirection map.
    pub(super) fn new(model: &'a MesoModel, layers: &'a FlatBtfDecoder, sampled: &'a FlatBtfDecoder) -> Self {
        let of = |map: LayerMap| FlatBtfDecoder::new(FlatBtfParts::new(map, layers.parts().reflectance.clone()));
        let highest = highest(layers_of(layers));
        Self {
            model,
            layers,
            others: OTHER_STEPS.map(|(share, _)| with_share(layers, share)),
            normal_map: of(without_relief(&highest)),
            height_field: of(highest),
            reflectance: of(plane()),
            sampled,
            shadows: SampledShadows::new(),
        }
    }

    /// All methods, then the bounds.
    pub(super) fn all(&'a self) -> [Method<'a>; COUNT] {
        let bound = |name, draw| Method { name, stored: None, draw };
        let heights = layers_of(&self.normal_map).height_bytes().len() as u64;
        let [(_, twice), (_, half)] = OTHER_STEPS;
        [
            // Without relief there are no heights.
            self.constant("normal map", maps(&self.normal_map) - heights, 1, decoded(&self.normal_map)),
            self.sampled("sampled indirections and shadows", self.sampled),
            self.marched("height field", &self.height_field),
            self.layers(),
            self.marched(twice, &self.others[0]),
            self.marched(half, &self.others[1]),
            bound("exact rays, sampled shadows", self.exact(|point, light| self.shadows.at(self.model, point, light))),
            bound("exact rays", self.exact(|point, light| f32::from(self.model.caster.sees_sky(point, light)))),
        ]
    }

    /// Methods that shaders have, and what they draw: these as well, with indirection maps of these names.
    #[cfg(feature = "render")]
    pub(super) fn of_shaders(
        &'a self,
        maps: &'a [(&'static str, FlatBtfDecoder)],
    ) -> Vec<(Method<'a>, &'a FlatBtfDecoder)> {
        let [normal_map, _, height_field, layers, twice, half, ..] = self.all();
        let of_map = |(name, decoder): &'a (&'static str, FlatBtfDecoder)| (self.sampled(name, decoder), decoder);
        [(normal_map, &self.normal_map)]
            .into_iter()
            .chain(maps.iter().map(of_map))
            .chain([(height_field, &self.height_field), (layers, self.layers)])
            .chain([(twice, &self.others[0]), (half, &self.others[1])])
            .collect()
    }

    /// Layers as users get them.
    pub(super) fn layers(&'a self) -> Method<'a> {
        self.marched("layers", self.layers)
    }

    /// An indirection map, whose fetches do not depend on the view.
    fn sampled(&self, name: &'static str, decoder: &'a FlatBtfDecoder) -> Method<'a> {
        let Relief::Vdim(map, shadows) = &decoder.parts().relief else { unreachable!("an indirection map") };
        // Reference and map; with compact samples two of ranges, and one of the height; three lights.
        let of_map = if matches!(map.samples(), VdimSamples::Compact(_)) { 5 } else { 2 };
        let fetches = of_map + if shadows.is_some() { 3 } else { 0 };
        self.constant(name, maps(decoder), fetches, decoded(decoder))
    }

    fn marched(&self, name: &'static str, decoder: &'a FlatBtfDecoder) -> Method<'a> {
        let of_reflectance = f64::from(self.fetches_of_reflectance());
        let mean = move |scene: &Scene, frame, repeat| of_reflectance + mean_fetches(decoder, scene, frame, repeat);
        let most = fetches(decoder.steps());
        self.stored(name, maps(decoder), most, Box::new(mean), decoded(decoder))
    }

    /// A method whose pixels all take the same number of fetches.
    fn constant(&self, name: &'static str, bytes: u64, fetches: u32, draw: Draw<'a>) -> Method<'a> {
        let all = f64::from(self.fetches_of_reflectance() + fetches);
        self.stored(name, bytes, fetches, Box::new(move |_, _, _| all), draw)
    }

    /// A method that has these bytes and fetches next to those of the reflectance.
    fn stored(
        &self,
        name: &'static str,
        bytes: u64,
        fetches: u32,
        mean_fetches: Count<'a>,
        draw: Draw<'a>,
    ) -> Method<'a> {
        let bytes = self.layers.parts().reflectance.factors().map_or(0, FactoredFlatBtf::gpu_bytes) + bytes;
        let stored = Stored { bytes, fetches: self.fetches_of_reflectance() + fetches, mean_fetches };
        Method { name, stored: Some(stored), draw }
    }

    fn fetches_of_reflectance(&self) -> u32 {
        OF_TEXEL
            + OF_MATERIAL * self.layers.parts().reflectance.factors().map_or(0, |factors| factors.header().materials)
    }

    /// Rays against the surface itself; `reaches` is the fraction of the light that reaches a point.
    fn exact(&'a self, reaches: impl Fn(&SurfacePoint, Vector) -> f32 + Sync + Copy + 'a) -> Draw<'a> {
        self.on_tiles(move |at, level, view| {
            let seen = self.model.seen(at.map(f64::from), view);
            let point = self.model.point(&seen.hit);
            let parameters = seen.parameters.map(|c| c as f32);
            let shade = move |light: Vector| {
                let lit = if light[2] > 0.0 { reaches(&point, light) } else { 0.0 };
                self.lit(parameters, level, view, light, lit)
            };
            (view.map(|c| point.position[2] / view[2] * c), shade)
        })
    }

    /// Draws by [`draw_tiles`].
    fn on_tiles<Shade: Fn(Vector) -> [f32; 3] + 'a>(
        &self,
        look: impl Fn([f32; 2], f32, Vector) -> (Vector, Shade) + Sync + 'a,
    ) -> Draw<'a> {
        let texels = self.layers.parts().reflectance.size() as usize;
        Box::new(move |scene, frame, repeat| draw_tiles(scene, frame, Tiles { repeat, texels }, &look))
    }

    fn lit(&self, parameters: [f32; 2], level: f32, view: Vector, light: Vector, lit: f32) -> [f32; 3] {
        self.reflectance.shaded(None, parameters, level, single(view), single(light)).map(|channel| lit * channel)
    }
}

/// Bytes of the relief.
fn maps(decoder: &FlatBtfDecoder) -> u64 {
    match &decoder.parts().relief {
        Relief::Layers(map) => (map.height_bytes().len() + map.displacement_bytes().len()) as u64,
        Relief::Vdim(map, shadows) => {
            let shadows = shadows.as_ref().map_or(0, |shadows| shadows.texels().len());
            let compact = match map.samples() {
                VdimSamples::Halves(_) => 0,
                // Ranges are halves.
                VdimSamples::Compact(samples) => 4 * samples.ranges.len() + samples.heights.len(),
            };
            (map.reference_bytes().len() + map.packed_bytes().len() + compact + shadows) as u64
        }
    }
}

fn layers_of(decoder: &FlatBtfDecoder) -> &LayerMap {
    decoder.parts().relief.layers().expect("a flat BTF with layers")
}

/// Most fetches of rays: their starts, steps and refinements; and parameters.
fn fetches(steps: MarchSteps) -> u32 {
    2 + steps.both + steps.refine + 1
}

/// Mean fetches of the rays of samples for each of their lights, on a plane.
fn mean_fetches(decoder: &FlatBtfDecoder, scene: &Scene, frame: Frame, repeat: u32) -> f64 {
    let texels = decoder.parts().reflectance.size() as usize;
    let [fetches, rays] = [0; 2].map(AtomicU64::new);
    let add = |of_both: [u32; 2]| {
        fetches.fetch_add(of_both.iter().map(|count| u64::from(*count)).sum(), Ordering::Relaxed);
        rays.fetch_add(1, Ordering::Relaxed);
        [0.0; 3]
    };
    draw_tiles(scene, frame, Tiles { repeat, texels }, |at, level, view| {
        let look = decoder.look(at, level, single(view), MacroSurface::PLANE);
        (look.offset().map(f64::from), move |light| add(look.fetches(single(light))))
    });
    fetches.into_inner() as f64 / rays.into_inner().max(1) as f64
}

/// The same layers with a share of the steps.
fn with_share(layers: &FlatBtfDecoder, share: f64) -> FlatBtfDecoder {
    let of = |count: u32| (share * f64::from(count)).ceil() as u32;
    let steps = layers.steps();
    layers.clone().with_steps(MarchSteps { sight: of(steps.sight), both: of(steps.both), ..steps })
}

/// Draws a flat BTF as it is drawn for users.
fn decoded(decoder: &FlatBtfDecoder) -> Draw<'_> {
    Box::new(|scene, frame, repeat| {
        let material = FlatMaterial::new(decoder.clone(), repeat).expect("directions that were checked");
        draw_on_cpu(scene, frame, &material)
    })
}

fn single(v: Vector) -> [f32; 3] {
    v.map(|c| c as f32)
}

/// The highest sheet of each texel: what relief mapping has.
fn highest(layers: &LayerMap) -> LayerMap {
    let header = *layers.header();
    let channels = header.height_format().texel_bytes();
    let displacements = displacements(layers);
    let (mut heights, mut moved) = (Vec::new(), Vec::new());
    let (mut texels, mut pairs) = (layers.height_bytes().chunks_exact(channels), &displacements[..]);
    for level in 0..header.levels {
        let count = ((header.size >> level).max(1) as usize).pow(2);
        for (at, texel) in texels.by_ref().take(count).enumerate() {
            // Where an overhanging part is absent, its upper side is below its underside.
            let sheet = match texel {
                [base, top, underside, _] if top > underside && top > base => 1,
                _ => 0,
            };
            heights.push(texel[sheet]);
            // Level 0 of the displacements has as many texels as level 1 of the heights.
            if level > 0 {
                moved.push(pairs[sheet * count + at]);
            }
        }
        if level > 0 {
            pairs = &pairs[count * header.sheets as usize..];
        }
    }
    LayerMap::new(LayerHeader { sheets: 1, ..header }, heights, moved).expect("texels of a map of layers")
}

/// The same parameters on a plane that casts no shadows.
fn without_relief(field: &LayerMap) -> LayerMap {
    let header = LayerHeader { heights: FLAT, ..*field.header() };
    LayerMap::new(header, vec![127; field.height_bytes().len()], displacements(field))
        .expect("texels of a height field")
}

fn displacements(map: &LayerMap) -> Vec<[f32; 2]> {
    let numbers = map.displacement_bytes();
    let pairs = numbers.as_chunks::<2>().0.as_chunks::<2>().0;
    pairs.iter().map(|pair| pair.map(|bytes| half::decode(u16::from_le_bytes(bytes)))).collect()
}

/// A plane whose parameters are its positions.
fn plane() -> LayerMap {
    let header = LayerHeader { size: 1, sheets: 1, levels: 1, heights: FLAT };
    LayerMap::new(header, vec![127], vec![[0.0; 2]]).expect("a texel")
}
