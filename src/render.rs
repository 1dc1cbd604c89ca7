//! Renderings of packs by the shaders that engines use and by the CPU, with their differences: `brdfc render`, with the feature
//! `render`.
//!
//! [`Gpu::open`] opens a graphics adapter, [`views`] draws a [`Scene`] of materials, [`Verification`] measures the renderings.
//! [`AdaptiveRenderer`] shades where predicted bandwidth requires it.

pub use brdfc_bandwidth::map::environment_map;
pub use brdfc_formats::bindings::FrameBlock;
pub use brdfc_formats::pwt::{PwtDecoder, PwtPack};
pub use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
pub use brdfc_gpu::verify::{Material, PackReflectance, Views, lobes_views, views};
pub use brdfc_gpu::{AdapterChoice, AdaptiveRenderer, Decoding, Gpu, GpuError, SliceFilter, draw_flat_btf, draw_pwt};
pub use brdfc_jobs::pwt::DistantPhotographs;
pub use brdfc_jobs::report::adaptive::{AdaptiveRates, AdaptiveVerification, PartTextureReport, Shading};
pub use brdfc_jobs::report::contact::MaterialVerification;
pub use brdfc_jobs::report::render::{PartMaterial, RenderingGates, Verification, nothing_shown};
pub use brdfc_jobs::tabulated::{Tabulated, tabulated};
pub use brdfc_metrics::image::{LinearImage, auto_exposure};
pub use brdfc_render::adaptive::{
    AdaptiveMaterial, AdaptiveRendering, AdaptiveScene, DistantLight, Lookups, PartTexture, Prediction, RATE_TILES,
    RateImage, Settings, Start, ground_truth, repeats,
};
pub use brdfc_render::contact_sheet::contact_sheet;
pub use brdfc_render::flat::{FlatMaterial, draw_on_cpu as draw_flat_btf_on_cpu};
pub use brdfc_render::lobes::{Integral, IntegralMaterial, PrefilteredLight, converged_integral, draw_integral};
pub use brdfc_render::pwt::{
    Photograph, PwtMaterial, distant_light, draw_on_cpu as draw_pwt_on_cpu, draw_photographs, image_scene,
};
pub use brdfc_render::rendering::{difference_panel, rates_png, rgb_png, sheet, to_exr, to_panel, to_png};
pub use brdfc_render::scene::{Environment, Frame, PointLight, Scene};
pub use brdfc_render::scenes::Builtin;
pub use brdfc_render::shade::Reflectance;
pub use brdfc_source::flat_btf::flat_view;
pub use brdfc_source::pack::open_brdf_pack;
pub use brdfc_source::radiance_image::open_radiance_image;

use crate::flatten::{AssetFile, MesoOptions, PLANE};
use crate::inspect::{AnyPack, RtiCapture};
use crate::{Error, Input, Source};
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::texture_map;
use brdfc_bandwidth::texture::Placement;
use brdfc_core::PackSource;
use brdfc_core::address::is_synth;
use brdfc_flat_btf::model::MesoModel;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::direction::dot;
use brdfc_jobs::flatten::{open_appearance, open_geometry};
use brdfc_render::adaptive::ANY_LEVEL;
use brdfc_render::flat::reference;
use brdfc_render::mipmaps::Mipmaps;
use brdfc_render::rendering::{heat_map, octave_map};
use brdfc_source::tile_image::open_colours;

/// Bandwidth and importance samples of a material for adaptive shading: from `maps` if it has both, otherwise from the source or
/// the pack.
///
/// # Errors
/// Returns an error if the maps do not fit the material.
pub fn lookups(material: &Material<'_>, maps: &[AnyPack]) -> Result<Lookups, Error> {
    let unpacked;
    let source = match material.source {
        Some(source) => source,
        None => {
            unpacked = PackSource::new(&**material.pack, None);
            &unpacked
        }
    };
    let found = match maps {
        [AnyPack::Bandwidth(bandwidth), AnyPack::Importance(samples), ..] => {
            Lookups::of_packs(source, bandwidth.clone(), samples.clone())
        }
        _ => Lookups::new(source),
    };
    found.map_err(|error| Error::internal(error.to_string()))
}

/// Maximum pixels per side of a texture.
pub const MAX_TEXTURE_SIDE: usize = 4096;

/// A texture for adaptive shading. It repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Factors on `f_r`, linear RGB, with mipmaps.
    pub colours: Mipmaps,
    /// Bandwidth map, with the size in metres.
    pub bandwidth: BandwidthMap,
}

/// Opens a texture of this size in metres, a PNG or JPEG. `built` is its map, if a build has made it.
///
/// # Errors
/// Returns an error if the image cannot be read or is larger than [`MAX_TEXTURE_SIDE`] along a side.
pub fn texture(input: &Input, metres: [f64; 2], built: Option<BandwidthMap>) -> Result<Texture, Error> {
    let image = open_colours(input)?;
    let (width, height) = (image.width, image.height);
    if width.max(height) > MAX_TEXTURE_SIDE {
        let allowed = format!("expected at most {MAX_TEXTURE_SIDE} pixels along a side of a texture");
        return Err(Error::input(format!("{input}: image: found {width} x {height} pixels, {allowed}")));
    }
    let map = || texture_map(&image.pixels, width, Placement { metres, tiles: true }, DEFAULT_EPSILON);
    let bandwidth = built.map_or_else(map, Ok).map_err(Error::own_layout)?;
    Ok(Texture { colours: Mipmaps::new(width, image.pixels), bandwidth })
}

impl Texture {
    /// The texture with a map that is 0 everywhere.
    pub fn without_bandwidth(&self) -> Self {
        let size = self.bandwidth.size();
        let zeros = vec![0.0; size.into_iter().product::<u32>() as usize];
        let map = BandwidthMap::new(*self.bandwidth.header(), size, &zeros).expect("zeros are valid values");
        Self { colours: self.colours.clone(), bandwidth: map }
    }
}

/// Prepares a source for [`draw_integral`].
///
/// # Errors
/// Returns an error if the lobes of the source cannot be tabulated.
pub fn integral_material(source: &dyn Source) -> Result<IntegralMaterial<'_>, Error> {
    IntegralMaterial::new(source).map_err(|error| Error::internal(error.to_string()))
}

/// Draws the surface from which a flat BTF was made on the objects of a scene, with `repeat` tiles per unit of uv. Returns `None` if
/// its geometry or a material came from a file, or if it contains light of bounces.
///
/// # Errors
/// Returns an error for addresses that this version does not know.
pub fn draw_surface(scene: &Scene, frame: Frame, asset: &AssetFile, repeat: u32) -> Result<Option<LinearImage>, Error> {
    let (source, materials) = (&asset.source, &asset.materials);
    let from_formula = is_synth(source) || source == PLANE;
    let from_files = !from_formula || materials.is_empty() || !materials.iter().all(|m| is_synth(m));
    if from_files || asset.settings.bounces > 0 || asset.images_over_the_tile {
        return Ok(None);
    }
    let options = MesoOptions {
        geometry: is_synth(source).then(|| source.into()),
        tile: 1.0,
        height_scale: 1.0,
        height_offset: 0.0,
        materials: Vec::new(),
        colour: None,
        weights: None,
    };
    let geometry = open_geometry(&options)?;
    let materials: Vec<Input> = materials.iter().map(Input::from).collect();
    let appearance = open_appearance(&options, &materials, &())?;
    let model = MesoModel::new(geometry.mesh, 0, &()).map_err(|error| Error::input(format!("{source}: {error}")))?;
    Ok(Some(reference(scene, frame, &model, &appearance, repeat)))
}

/// Finds the photograph whose light is nearest to the light of the scene, seen from the middle of the rendering. Returns the
/// number of the photograph, and the angle between the two lights in degrees.
pub fn nearest_photograph(stack: &RtiCapture, light: &PointLight) -> (usize, f64) {
    let [x, y, z] = light.position;
    let length = dot(light.position, light.position).sqrt();
    let towards = [x, -z, y].map(|c| c / length);
    let cosine = |k: &usize| dot(stack.lights()[*k].map(f64::from), towards);
    let best = (0..stack.len()).max_by(|a, b| cosine(a).total_cmp(&cosine(b))).unwrap_or(0);
    (best, cosine(&best).clamp(-1.0, 1.0).acos().to_degrees())
}

/// Encodes bandwidth, levels and variance of a prediction of `width` x `height` points side by side, as a PNG: logarithms, from
/// dark to pale yellow, on a dark background.
pub fn prediction_png(prediction: &Prediction, [width, height]: [usize; 2]) -> Vec<u8> {
    let coarsest = prediction.level.iter().filter(|level| **level != ANY_LEVEL).max().copied().unwrap_or(0);
    let fineness = |level: &i32| if *level == ANY_LEVEL { 0.0 } else { 1.0 - *level as f32 / (coarsest + 1) as f32 };
    let levels: Vec<f32> = prediction.level.iter().map(fineness).collect();
    let variance: Vec<f32> = prediction.deviation.iter().map(|deviation| deviation * deviation).collect();
    rgb_png(&sheet(&[
        octave_map(&prediction.bandwidth, width, height, 8.0),
        heat_map(&levels, width, height, 1.0),
        octave_map(&variance, width, height, 16.0),
    ]))
}
