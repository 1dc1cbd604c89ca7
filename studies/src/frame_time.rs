//! Times of a frame under point lights and in an environment, on a graphics adapter.

use crate::timing::fastest;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::environment_map;
use brdfc_core::Source;
use brdfc_formats::BrdfPack;
use brdfc_formats::lobes::LobesPack;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::PackReflectance;
use brdfc_gpu::{
    AdapterDescription, AdaptiveRenderer, Decoding, Gpu, GpuError, LobesRenderer, Renderer, SliceFilter,
    lobes_scene_source,
};
use brdfc_render::adaptive::{AdaptiveScene, DistantLight, Lookups};
use brdfc_render::lobes::PrefilteredLight;
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::shade::Reflectance;
use schemars::JsonSchema;
use serde::Serialize;

/// Number of runs of a timing, of which the fastest counts.
const RUNS: usize = 5;
/// Samples per pixel of forward shading.
const SAMPLES: [u32; 3] = [1, 4, 16];

/// A material with its packs.
pub struct FrameMaterial<'a> {
    /// For samples of forward shading.
    pub source: &'a dyn Source,
    /// Pack for point lights.
    pub pack: BrdfPack,
    /// Lobes for the environment.
    pub lobes: LobesPack,
}

/// Times of a frame, each until the image is read back.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FrameTimes {
    /// Adapter that drew the frames.
    pub adapter: AdapterDescription,
    /// Pixels of a frame.
    pub size: [usize; 2],
    /// Pixels that show a surface.
    pub surface: usize,
    /// Point lights.
    pub lights: usize,
    /// Look-ups of the lobes of each part.
    pub look_ups: Vec<usize>,
    /// Seconds of a frame under the point lights, by packs.
    pub points: f64,
    /// Seconds of a frame in the environment, by lobes.
    pub lobes: f64,
    /// Seconds of forward shading in the environment, from a buffer of surfaces.
    pub forward: Vec<ForwardTime>,
}

/// Time of forward shading with importance samples.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct ForwardTime {
    /// Samples per pixel.
    pub samples: u32,
    /// Seconds.
    pub seconds: f64,
}

/// Measures frames of a scene, with one material for each part. The scene's environment lights it. Calls `progress` with a
/// description of each finished step.
///
/// # Panics
/// If there are fewer materials than parts, or if the layout of maps rejects the environment or a material.
///
/// # Errors
/// Returns an error that the driver reports.
pub fn frame_times(
    gpu: &Gpu,
    scene: &Scene,
    light: &PrefilteredLight,
    materials: &[FrameMaterial<'_>],
    [width, height]: [usize; 2],
    progress: impl Fn(&str),
) -> Result<FrameTimes, GpuError> {
    let decoding = Decoding {
        filter: Filter::Bilinear,
        slices: SliceFilter::Hardware,
        level: None,
        distance_scale: DEFAULT_DISTANCE_SCALE,
    };
    let frame = Frame { width, height, samples: 1 };
    let materials = &materials[..scene.parts.len()];
    let packs: Vec<&BrdfPack> = materials.iter().map(|material| &material.pack).collect();
    let renderer = Renderer::new(gpu)?;
    let loaded = renderer.load(scene, &packs, decoding)?;
    let points = fastest(RUNS, || renderer.draw(&loaded, &scene.camera, frame))?;
    progress("point lights");

    let lobes: Vec<Option<&LobesPack>> = materials.iter().map(|material| Some(&material.lobes)).collect();
    let renderer = LobesRenderer::new(gpu, lobes_scene_source(), light)?;
    let loaded = renderer.load(scene, &lobes)?;
    let by_lobes = fastest(RUNS, || renderer.draw(&loaded, &scene.camera, frame))?;
    progress("lobes");

    let lookups = materials.iter().map(|material| Lookups::new(material.source).expect("default recipes"));
    let lookups: Vec<Lookups> = lookups.collect();
    let reflectances: Vec<PackReflectance> = packs.iter().map(|pack| PackReflectance::new(pack, decoding)).collect();
    let adaptive: Vec<_> = lookups.iter().zip(&reflectances).map(|(l, r)| l.material(r as &dyn Reflectance)).collect();
    let environment = &scene.environment;
    let map = environment_map(&environment.pixels, environment.width, DEFAULT_EPSILON).expect("default recipes");
    let distant = DistantLight::new(environment, map);
    let adaptive = AdaptiveScene { scene, light: &distant, materials: &adaptive };
    let renderer = AdaptiveRenderer::new(gpu)?;
    let loaded = renderer.load(&adaptive, &packs, decoding)?;
    let g_buffer = renderer.g_buffer(&loaded, &scene.camera, frame, 0)?;
    let buffer = renderer.read(&g_buffer)?;
    let surface = (0..buffer.part.len()).filter(|point| buffer.part_at(*point).is_some()).count();
    let mut forward = Vec::new();
    for samples in SAMPLES {
        let seconds = fastest(RUNS, || renderer.forward(&loaded, &g_buffer, samples))?;
        forward.push(ForwardTime { samples, seconds });
        progress(&format!("forward, {samples}"));
    }
    Ok(FrameTimes {
        adapter: gpu.description().clone(),
        size: [width, height],
        surface,
        lights: scene.lights.len(),
        look_ups: materials.iter().map(|material| material.lobes.fetches()).collect(),
        points,
        lobes: by_lobes,
        forward,
    })
}
