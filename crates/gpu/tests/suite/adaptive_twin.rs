//! Adaptive shading by shaders, compared with its CPU twin on any adapter.

use brdfc_bandwidth::environment::environment_bandwidth;
use brdfc_bandwidth::lobe::lobe_bandwidth;
use brdfc_bandwidth::map::texture_map;
use brdfc_bandwidth::texture::Placement;
use brdfc_core::Source;
use brdfc_core::address::parse_synth;
use brdfc_formats::BrdfPack;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::importance::ImportancePack;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::PackReflectance;
use brdfc_gpu::{AdaptiveRenderer, AdaptiveShaders, Decoding, GpuError, LoadedAdaptive, LoadedGBuffer, SliceFilter};
use brdfc_importance::{ImportanceRecipe, importance_samples};
use brdfc_metrics::image::LinearImage;
use brdfc_render::adaptive::{
    self, AdaptiveMaterial, AdaptiveScene, DistantLight, PartTexture, Prediction, Pyramid, Settings, ShadedLevels,
    coarsest,
};
use brdfc_render::curvature::curvature;
use brdfc_render::gbuffer::{BACKGROUND, GBuffer};
use brdfc_render::mipmaps::Mipmaps;
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_table::recipe::TableRecipe;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::Recipe;
use std::f32::consts::TAU;
use std::sync::LazyLock;
use wgpu::naga;

const FRAME: Frame = Frame { width: 67, height: 49, samples: 1 };
const EXACT: Decoding = Decoding {
    filter: Filter::Slices,
    slices: SliceFilter::Exact,
    level: None,
    distance_scale: DEFAULT_DISTANCE_SCALE,
};
const SETTINGS: Settings =
    Settings { directions: 16, samples: 12.0, fewest: 4, most: 512, white: 1.0, caution: 0.7, antialiasing_levels: 0 };
const EPSILON: f64 = 0.01;

struct Material {
    pack: BrdfPack,
    samples: ImportancePack,
    bandwidth: BandwidthMap,
}

fn header(kind: BandwidthKind) -> BandwidthHeader {
    BandwidthHeader { kind, epsilon: EPSILON as f32, transformed: [64, 64] }
}

fn wavelet(source: &dyn Source) -> BrdfPack {
    let recipe = Recipe { levels: 4, stored_levels: 4, measure_off_grid: false, ..Recipe::default() };
    BrdfPack::Wavelet(encode(source, &recipe, &()).unwrap().pack)
}

fn table(source: &dyn Source) -> BrdfPack {
    let recipe = TableRecipe { measure: false, ..TableRecipe::default() };
    BrdfPack::Table(brdfc_table::encode::encode(source, &recipe, &()).unwrap().pack)
}

fn material(address: &str, pack: fn(&dyn Source) -> BrdfPack) -> Material {
    let source = parse_synth(address).unwrap();
    let pack = pack(source.as_ref());
    let recipe = ImportanceRecipe { samples: 256, ..ImportanceRecipe::default() };
    let (samples, _) = importance_samples(source.as_ref(), &recipe).unwrap();
    let lobes = lobe_bandwidth(source.as_ref(), 32, EPSILON);
    let bandwidth = BandwidthMap::new(header(BandwidthKind::Brdf), [256, 256], &lobes.values).unwrap();
    Material { pack, samples, bandwidth }
}

/// A glossy and an anisotropic material, with packs of either codec. Parts alternate between them.
static MATERIALS: LazyLock<[Material; 2]> = LazyLock::new(|| {
    let anisotropic = "synth:ward?kd=0.3,0.1,0.05&ks=0.1&ax=0.2&ay=0.5";
    [material("synth:ggx?alpha=0.25", wavelet), material(anisotropic, table)]
});

/// A scene with its maps and materials, and their decoding.
struct World {
    scene: Scene,
    light: DistantLight,
    reflectances: [PackReflectance; 2],
    decoding: Decoding,
    /// Texture of the first material.
    texture: Option<(Mipmaps, BandwidthMap)>,
}

/// Waves on a gradient in three colours, with sides that are no powers of two.
fn texture() -> (Mipmaps, BandwidthMap) {
    let (width, height) = (45, 30);
    let pixel = |i: usize| {
        let (u, v) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
        [
            0.5 + 0.4 * (TAU * 3.0 * u).sin(),
            0.2 + 0.6 * v,
            if u < 0.3 { 0.9 } else { 0.5 - 0.3 * (TAU * 5.0 * v).cos() },
        ]
    };
    let pixels: Vec<[f32; 3]> = (0..width * height).map(pixel).collect();
    let placement = Placement { metres: [0.4, 0.3], tiles: true };
    let map = texture_map(&pixels, width, placement, EPSILON).unwrap();
    (Mipmaps::new(width, pixels), map)
}

impl World {
    fn new(builtin: Builtin, decoding: Decoding) -> Self {
        let mut scene = builtin.scene();
        // Zoomed in, so that pixels have many different bandwidths.
        scene.camera.field_of_view *= 0.4;
        let map = environment_bandwidth(&scene.environment.pixels, scene.environment.width, EPSILON);
        let size = [map.width as u32, map.height as u32];
        let map = BandwidthMap::new(header(BandwidthKind::Environment), size, &map.values).unwrap();
        let light = DistantLight::new(&scene.environment, map);
        let reflectances = [0, 1].map(|k| PackReflectance::new(&MATERIALS[k].pack, decoding));
        Self { scene, light, reflectances, decoding, texture: None }
    }

    fn textured(builtin: Builtin, decoding: Decoding) -> Self {
        Self { texture: Some(texture()), ..Self::new(builtin, decoding) }
    }

    fn with<T>(&self, run: impl FnOnce(&AdaptiveScene<'_>) -> T) -> T {
        let material = |k: usize| AdaptiveMaterial {
            reflectance: &self.reflectances[k % 2],
            samples: &MATERIALS[k % 2].samples,
            bandwidth: &MATERIALS[k % 2].bandwidth,
            albedo: [0.5, 0.2][k % 2],
            texture: self.texture.as_ref().filter(|_| k.is_multiple_of(2)).map(|(colours, bandwidth)| PartTexture {
                colours,
                bandwidth,
                repeats: [12.0, 5.0],
            }),
        };
        let materials: Vec<_> = (0..self.scene.parts.len()).map(material).collect();
        run(&AdaptiveScene { scene: &self.scene, light: &self.light, materials: &materials })
    }

    fn load(&self, renderer: &AdaptiveRenderer<'_>) -> LoadedAdaptive {
        let packs: Vec<_> = (0..self.scene.parts.len()).map(|k| &MATERIALS[k % 2].pack).collect();
        self.with(|scene| renderer.load(scene, &packs, self.decoding)).unwrap()
    }
}

/// Differences between two G-buffers, as shares of the points.
#[derive(Debug)]
struct PointDifferences {
    /// Points with another part or background.
    parts: f64,
    /// Points of the same part at another position: the ray hit another triangle.
    elsewhere: f64,
    /// Points at the same position with values beyond the bounds of rounding.
    values: f64,
}

fn point_differences(a: &GBuffer, b: &GBuffer) -> PointDifferences {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let (mut parts, mut elsewhere, mut values) = (0, 0, 0);
    let far = |p: &[f32], q: &[f32]| p.iter().zip(q).map(|(p, q)| (p - q).abs()).fold(0.0, f32::max);
    for at in 0..a.part.len() {
        if a.part[at] != b.part[at] {
            parts += 1;
        } else if far(&a.position[at], &b.position[at]) > 1e-4 * a.distance[at] {
            elsewhere += 1;
        } else if a.part[at] != BACKGROUND {
            // Height maps convert differences of coordinates to differences of normals.
            let turned = far(&a.normal[at], &b.normal[at]).max(far(&a.tangent[at], &b.tangent[at]));
            let facing = (0..3).map(|k| a.normal[at][k] * a.to_viewer[at][k]).sum::<f32>() > 0.9999;
            let across = if facing { 0.0 } else { far(&a.across[at], &b.across[at]) };
            let rest = far(&a.to_viewer[at], &b.to_viewer[at])
                .max(far(&a.uv[at], &b.uv[at]))
                .max((a.distance[at] / b.distance[at] - 1.0).abs());
            values += usize::from(turned > 2e-3 || across > 2e-2 || rest > 1e-4);
        }
    }
    let share = |count: usize| count as f64 / a.part.len() as f64;
    PointDifferences { parts: share(parts), elsewhere: share(elsewhere), values: share(values) }
}

#[test]
fn the_drawn_g_buffer_is_the_traced_one() {
    let Some(gpu) = crate::common::gpu() else { return };
    let renderer = AdaptiveRenderer::new(gpu).unwrap();
    for builtin in [Builtin::BumpyBall, Builtin::RibbedTorus, Builtin::Table] {
        let world = World::new(builtin, EXACT);
        let loaded = world.load(&renderer);
        for levels in [0, 1] {
            let rastered = renderer.read(&g_buffer(&renderer, &loaded, &world, levels)).unwrap();
            let same = |scene: &Scene| {
                let traced = GBuffer::new(scene, Frame { samples: 1 << levels, ..FRAME });
                let found = point_differences(&traced, &rastered);
                println!("{builtin:?} {levels}: {found:?}");
                found.parts < 0.01 && found.elsewhere < 0.01 && found.values < 0.005
            };
            assert!(same(&world.scene), "{builtin:?} {levels}");
            // The controls: another camera, other normals, another tangent.
            let changed = |change: fn(&mut Scene)| {
                let mut scene = world.scene.clone();
                change(&mut scene);
                scene
            };
            assert!(!same(&changed(|scene| scene.camera.eye[0] += 0.02)));
            assert!(!same(&changed(|scene| scene.parts[0].mesh.vertices.iter_mut().for_each(|v| v.normal[0] += 0.1))));
            assert!(!same(&changed(|scene| scene.parts[0].mesh.vertices.iter_mut().for_each(|v| v.tangent[2] += 0.3))));
            if world.scene.parts[0].surface.bump.is_some() {
                assert!(!same(&changed(|scene| scene.parts[0].surface.bump = None)));
            }
        }
    }
}

/// Differences of the device's results on its own G-buffer.
#[derive(Debug, Default)]
struct Differences {
    /// Share of the points whose curvature has other bits.
    curvature: f64,
    /// Largest relative differences.
    bandwidth: f64,
    deviation: f64,
    /// Shares of the points.
    levels: f64,
    samples: f64,
    /// Number of different nodes in the pyramids of one prediction.
    pyramids: usize,
    /// Shading by one prediction: whether all counts are equal, and the largest difference, in units of the larger of
    /// the radiance and a hundredth of the maximum.
    counts: bool,
    radiance: f64,
    /// Largest difference of the forward renderer in the same units, and of coverage.
    forward: f64,
    coverage: bool,
}

fn relative(a: &[f32], b: &[f32]) -> f64 {
    let pair = |(a, b): (&f32, &f32)| f64::from((a - b).abs()) / f64::from(a.abs().max(b.abs())).max(1e-30);
    a.iter().zip(b).map(pair).fold(0.0, f64::max)
}

fn of_radiance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let brightest = a.as_flattened().iter().copied().fold(0.0, f32::max);
    let pair = |(a, b): (&f32, &f32)| f64::from((a - b).abs() / a.abs().max(0.01 * brightest));
    a.as_flattened().iter().zip(b.as_flattened()).map(pair).fold(0.0, |m, d| if d.is_nan() { d } else { d.max(m) })
}

fn share<T: PartialEq>(a: &[T], b: &[T]) -> f64 {
    a.iter().zip(b).filter(|(a, b)| a != b).count() as f64 / a.len() as f64
}

fn unequal<T: PartialEq>(a: &Pyramid<T>, b: &Pyramid<T>) -> usize {
    assert_eq!(a.levels.len(), b.levels.len());
    let mut count = 0;
    for ((w, h, a), (v, g, b)) in a.levels.iter().zip(&b.levels) {
        assert_eq!((w, h, a.len()), (v, g, b.len()));
        count += a.iter().zip(b).filter(|(a, b)| a != b).count();
    }
    count
}

/// Results of the CPU on a G-buffer.
struct Expected {
    curvature: Vec<f32>,
    prediction: Prediction,
    targets: Pyramid<i32>,
    samples: Pyramid<u32>,
    shaded: ShadedLevels,
    forward: LinearImage,
}

/// Samples of the forward renderer, more than one slice.
const FORWARD: u32 = 40;

fn expected(world: &World, buffer: &GBuffer, settings: &Settings) -> Expected {
    world.with(|scene| {
        let prediction = adaptive::predict(scene, FRAME, buffer, settings);
        let (width, height, coarsest) = (buffer.width, buffer.height, coarsest(buffer) as usize);
        Expected {
            curvature: curvature(buffer),
            targets: Pyramid::new(width, height, prediction.level.clone(), coarsest, i32::min),
            samples: Pyramid::new(width, height, prediction.samples.clone(), coarsest, u32::max),
            shaded: adaptive::shade(scene, buffer, &prediction, settings.most),
            forward: adaptive::forward(scene, FRAME, buffer, FORWARD),
            prediction,
        }
    })
}

fn g_buffer(renderer: &AdaptiveRenderer<'_>, loaded: &LoadedAdaptive, world: &World, levels: u32) -> LoadedGBuffer {
    renderer.g_buffer(loaded, &world.scene.camera, FRAME, levels).unwrap()
}

fn differences(
    renderer: &AdaptiveRenderer<'_>,
    world: &World,
    settings: &Settings,
    expected: &Expected,
) -> Differences {
    let loaded = world.load(renderer);
    let buffer = g_buffer(renderer, &loaded, world, settings.antialiasing_levels);
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect::<Vec<_>>();
    let curved = bits(renderer.curvature(&buffer).unwrap());
    let prediction = renderer.predict(&loaded, &buffer, settings).unwrap();
    let (targets, samples) = renderer.pyramids(&buffer, &expected.prediction).unwrap();
    let shaded = renderer.shade(&loaded, &buffer, &expected.prediction, settings.most).unwrap();
    let forward = renderer.forward(&loaded, &buffer, FORWARD).unwrap();
    Differences {
        curvature: share(&bits(expected.curvature.clone()), &curved),
        bandwidth: relative(&expected.prediction.bandwidth, &prediction.bandwidth),
        deviation: relative(&expected.prediction.deviation, &prediction.deviation),
        levels: share(&expected.prediction.level, &prediction.level),
        samples: share(&expected.prediction.samples, &prediction.samples),
        pyramids: unequal(&expected.targets, &targets) + unequal(&expected.samples, &samples),
        counts: expected.shaded.levels == shaded.levels,
        radiance: of_radiance(&expected.shaded.radiance, &shaded.radiance),
        forward: of_radiance(&expected.forward.pixels, &forward.pixels),
        coverage: expected.forward.coverage == forward.coverage,
    }
}

impl Differences {
    /// Names of the results beyond their bounds. Curvature, pyramids and counts must be bit-identical. The environment
    /// is mixed in double precision on the CPU, and the exponential of the packs' decoder is the driver's.
    fn beyond(&self) -> Vec<&'static str> {
        [
            ("curvature", self.curvature > 0.0),
            ("bandwidth", self.bandwidth > 2e-6),
            ("deviation", self.deviation > 2e-6),
            ("levels", self.levels > 0.001),
            ("samples", self.samples > 0.005),
            ("pyramids", self.pyramids > 0),
            ("counts", !self.counts),
            ("radiance", self.radiance.is_nan() || self.radiance > 1e-5),
            ("forward", self.forward.is_nan() || self.forward > 1e-5),
            ("coverage", !self.coverage),
        ]
        .into_iter()
        .filter_map(|(name, wrong)| wrong.then_some(name))
        .collect()
    }
}

#[test]
fn each_step_agrees_with_its_twin() {
    let Some(gpu) = crate::common::gpu() else { return };
    let renderer = AdaptiveRenderer::new(gpu).unwrap();
    for (builtin, filter, antialiasing_levels, textured) in [
        (Builtin::BumpyBall, Filter::Slices, 0, false),
        (Builtin::BumpyBall, Filter::Nearest, 1, true),
        (Builtin::RibbedTorus, Filter::Bilinear, 0, false),
        (Builtin::Table, Filter::Slices, 0, false),
        (Builtin::Table, Filter::Slices, 0, true),
    ] {
        let make = if textured { World::textured } else { World::new };
        let world = make(builtin, Decoding { filter, ..EXACT });
        let settings = Settings { antialiasing_levels, ..SETTINGS };
        let loaded = world.load(&renderer);
        let buffer = renderer.read(&g_buffer(&renderer, &loaded, &world, antialiasing_levels)).unwrap();
        let expected = expected(&world, &buffer, &settings);
        // Every kind of outcome occurs.
        let levels = &expected.shaded.levels;
        assert!(levels[0].shaded > 0 && levels[0].shaded < levels[0].pixels && levels[1].shaded > 0, "{levels:?}");
        let found = differences(&renderer, &world, &settings, &expected);
        println!("{builtin:?}, {filter:?}, {antialiasing_levels}: {found:?}");
        assert_eq!(found.beyond(), [""; 0], "{builtin:?}, {filter:?}, {antialiasing_levels}: {found:?}");
    }
}

/// Small changes of the look-ups of textures, and the result that detects each.
const TEXTURE_CHANGES: [(&str, &str, &str); 13] = [
    ("outgoing.z, bend, lobe, spatial", "outgoing.z, bend, lobe, 0.0", "bandwidth"),
    ("uv_of(point) * job.material.repeats", "uv_of(point)", "bandwidth"),
    ("vec2<f32>(1.0, -1.0)", "vec2<f32>(1.0)", "forward"),
    ("bandwidth_texture(place) * footprint.x", "bandwidth_texture(place)", "bandwidth"),
    ("repetitions * job.material.metres", "repetitions", "bandwidth"),
    ("turn - floor(turn + 0.5)", "turn", "levels"),
    ("job.material.albedo * texture_luminance(textures[k].colour)", "job.material.albedo", "deviation"),
    ("texture_point(point).colour * sum", "sum", "forward"),
    ("texture_colour(place, footprint.y)", "texture_colour(place, 0.0)", "forward"),
    ("texture_colour(place, footprint.y)", "texture_colour(place, 4.0 * footprint.y)", "forward"),
    ("finer + share * (coarser - finer)", "finer", "forward"),
    ("vec2<f32>(size) - 0.5", "vec2<f32>(size)", "forward"),
    (
        "u32(level); finer += 1u) {\n        row += size.y",
        "u32(level); finer += 1u) {\n        row += size.x",
        "forward",
    ),
];

/// Small changes of the shaders, and the result that detects each.
const CHANGES: [(&str, &str, &str); 32] = [
    ("product(turned, turned) / length_squared", "product(turned, turned)", "curvature"),
    ("rise * rise > MAX_RISE_SQUARED", "rise > MAX_RISE_SQUARED", "curvature"),
    ("0.0, surface, viewer.w)", "0.0, surface, 1.0)", "bandwidth"),
    ("outgoing.z, bend, lobe", "outgoing.z, 0.0, lobe", "bandwidth"),
    ("Bandwidth(0.0, found.y), 0.0", "Bandwidth(0.0, lobe), 0.0", "bandwidth"),
    ("sqrt(variance) * sqrt(shown)", "sqrt(variance) * shown", "deviation"),
    ("exponent >> 1u", "exponent", "deviation"),
    ("direction) >> vec2<u32>(level)", "direction)", "bandwidth"),
    ("(number + 1u) * run", "(number + 1u) * run - 1u", "bandwidth"),
    ("share_of(points[k], k, textures", "share_of(points[k], 0u, textures", "bandwidth"),
    ("joined(all, share_of(point, next, textures[k].bandwidth))", "all", "deviation"),
    ("job.material.albedo *", "0.4 *", "deviation"),
    ("rendering_bandwidth(settings.caution * predicted[point].w)", "rendering_bandwidth(predicted[point].w)", "levels"),
    ("rendering_bandwidth(settings.caution * predicted[point].w)", "settings.caution * predicted[point].x", "levels"),
    ("level + i32(settings.antialiasing_levels)", "level", "levels"),
    ("covered += 1u", "covered += 2u", "samples"),
    ("min(a.finest, b.finest)", "max(a.finest, b.finest)", "pyramids"),
    ("max(a.samples, b.samples)", "min(a.samples, b.samples)", "pyramids"),
    ("min(samples << doublings, settings.most)", "min(samples, settings.most)", "counts"),
    ("max(level, 1u) - 1u", "level", "counts"),
    ("node.finest > i32(job.level)", "node.finest >= i32(job.level)", "counts"),
    ("(drawn.incoming.z * drawn.inverse_density)", "drawn.inverse_density", "forward"),
    ("scattered(point) + first", "scattered(point)", "forward"),
    ("sum / f32(max(node.w, 1u))", "sum / f32(node.z)", "forward"),
    ("h ^= h >> 13u", "h ^= h >> 12u", "radiance"),
    ("corner + vec2<u32>(1u << (level - 1u))", "corner", "radiance"),
    ("NONE, own + 1u, own + 1u < size", "NONE, own, own + 1u < size", "radiance"),
    ("computed[coarser.z + node]", "computed[own.z + node]", "radiance"),
    ("off * off /", "off /", "radiance"),
    ("return alpha * exp", "return exp", "radiance"),
    ("here.cosine * sideways", "sideways", "radiance"),
    ("vec4<f32>(computed[point].xyz, 1.0)", "vec4<f32>(computed[point].xyz, 2.0)", "coverage"),
];

#[test]
fn changed_shaders_are_detected() {
    let mut world = World::new(Builtin::BumpyBall, Decoding { filter: Filter::Nearest, ..EXACT });
    // From further away, so that there is more detail than pixels show.
    world.scene.camera.field_of_view = Builtin::BumpyBall.scene().camera.field_of_view;
    assert_detected(&world, &CHANGES);
}

#[test]
fn changed_textures_are_detected() {
    let mut world = World::textured(Builtin::BumpyBall, Decoding { filter: Filter::Nearest, ..EXACT });
    world.scene.camera.field_of_view = Builtin::BumpyBall.scene().camera.field_of_view;
    // The seam of the coordinates in the middle.
    world.scene.camera.eye = [4.4, 0.3, 1.2];
    assert_detected(&world, &TEXTURE_CHANGES);
}

fn assert_detected(world: &World, changes: &[(&str, &str, &str)]) {
    let Some(gpu) = crate::common::gpu() else { return };
    let settings = Settings { antialiasing_levels: 1, caution: 0.4, ..SETTINGS };
    let shaders = AdaptiveShaders::default();
    let renderer = AdaptiveRenderer::with_shaders(gpu, &shaders).unwrap();
    let loaded = world.load(&renderer);
    let buffer = renderer.read(&g_buffer(&renderer, &loaded, world, 1)).unwrap();
    let expected = expected(world, &buffer, &settings);
    for (from, to, what) in changes {
        assert_eq!(shaders.steps.matches(from).count(), 1, "{from}");
        let changed = AdaptiveShaders { steps: shaders.steps.replace(from, to), ..shaders.clone() };
        let renderer = AdaptiveRenderer::with_shaders(gpu, &changed).unwrap();
        let found = differences(&renderer, world, &settings, &expected);
        assert!(found.beyond().contains(what), "{from} -> {to}: {found:?}");
    }
}

/// The whole pipeline: few values differ, even if a level or a count does.
#[test]
fn complete_renderings_are_those_of_the_cpu() {
    let Some(gpu) = crate::common::gpu() else { return };
    let renderer = AdaptiveRenderer::new(gpu).unwrap();
    let world = World::new(Builtin::Table, EXACT);
    let loaded = world.load(&renderer);
    let buffer = g_buffer(&renderer, &loaded, &world, 0);
    let found = renderer.draw(&loaded, &buffer, &SETTINGS).unwrap();
    assert_eq!(found, renderer.draw(&loaded, &buffer, &SETTINGS).unwrap(), "two runs");
    let read = renderer.read(&buffer).unwrap();
    let expected = world.with(|scene| adaptive::draw(scene, FRAME, &read, &SETTINGS));
    assert_eq!(found.image.coverage, expected.image.coverage);
    assert_eq!(found.image.background, expected.image.background);
    let far = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3 * a[k].abs().max(0.01));
    let differ = found.image.pixels.iter().zip(&expected.image.pixels).filter(|(a, b)| far(b, a)).count();
    assert!(differ < found.image.pixels.len() / 100, "{differ}");
    let ratio = found.samples() as f64 / expected.samples() as f64;
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn the_sampler_filters_nearly_as_the_shader_does() {
    let Some(gpu) = crate::common::gpu() else { return };
    let renderer = AdaptiveRenderer::new(gpu).unwrap();
    let renderings = [SliceFilter::Exact, SliceFilter::Hardware].map(|slices| {
        let world = World::new(Builtin::BumpyBall, Decoding { slices, level: Some(3.0), ..EXACT });
        let loaded = world.load(&renderer);
        renderer.forward(&loaded, &g_buffer(&renderer, &loaded, &world, 0), 8).unwrap()
    });
    let [exact, hardware] = &renderings;
    let found = of_radiance(&exact.pixels, &hardware.pixels);
    assert!(found > 0.0 && found < 0.1, "{found}");
}

#[test]
fn too_large_sizes_are_refused() {
    let Some(gpu) = crate::common::gpu() else { return };
    let renderer = AdaptiveRenderer::new(gpu).unwrap();
    let world = World::new(Builtin::BumpyBall, EXACT);
    let loaded = world.load(&renderer);
    let sized = |width, height, levels| {
        let frame = Frame { width, height, samples: 1 };
        renderer.g_buffer(&loaded, &world.scene.camera, frame, levels).map(|buffer| buffer.size())
    };
    assert_eq!(sized(7, 5, 1), Ok([14, 10]));
    for (width, height, levels) in [(100_000, 4, 0), (64, 64, 12), (64, 64, 200), (4000, 4000, 0)] {
        let refused = sized(width, height, levels);
        assert!(matches!(refused, Err(GpuError::TooLarge(_))), "{width} {height} {levels}: {refused:?}");
    }
    let buffer = g_buffer(&renderer, &loaded, &world, 0);
    let refused = renderer.forward(&loaded, &buffer, 1 << 25);
    assert!(matches!(refused, Err(GpuError::TooLarge(_))), "{refused:?}");
}

/// naga's error for a shader, validated without optional capabilities.
fn complaint(text: &str) -> Option<String> {
    let module = match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => return Some(error.emit_to_string(text)),
    };
    let flags = naga::valid::ValidationFlags::all();
    let result = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty()).validate(&module);
    result.err().map(|error| error.emit_to_string(text))
}

#[test]
fn the_shaders_validate() {
    let shaders = AdaptiveShaders::default();
    assert_eq!(complaint(&shaders.g_buffer), None);
    assert_eq!(complaint(&shaders.steps), None);
    let bad = shaders.steps.replace("var count = 0u", "let count = 0u");
    assert!(bad != shaders.steps && complaint(&bad).is_some());
    let bad = shaders.g_buffer.replace("frame[2]", "frame");
    assert!(bad != shaders.g_buffer && complaint(&bad).is_some());
}
