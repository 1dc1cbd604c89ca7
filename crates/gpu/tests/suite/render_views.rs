//! The rasteriser compared with the CPU's ray caster: the same scenes and packs give the same renderings.

use brdfc_core::address::parse_synth;
use brdfc_formats::BrdfPack;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::{Material, PackReflectance, views};
use brdfc_gpu::{Decoding, Gpu, Renderer, SliceFilter};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_render::scene::{Environment, Frame, PointLight, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::shade;
use brdfc_render::trace::trace;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::Recipe;

const FRAME: Frame = Frame { width: 96, height: 72, samples: 2 };
const EXACT: Decoding = Decoding {
    filter: Filter::Bilinear,
    slices: SliceFilter::Exact,
    level: None,
    distance_scale: DEFAULT_DISTANCE_SCALE,
};

fn pack(address: &str) -> BrdfPack {
    let recipe = Recipe { levels: 4, stored_levels: 4, measure_off_grid: false, ..Recipe::default() };
    BrdfPack::Wavelet(encode(parse_synth(address).unwrap().as_ref(), &recipe, &()).unwrap().pack)
}

fn by_shader(gpu: &Gpu, scene: &Scene, pack: &BrdfPack, decoding: Decoding, frame: Frame) -> LinearImage {
    let renderer = Renderer::new(gpu).unwrap();
    let packs = vec![pack; scene.parts.len()];
    let loaded = renderer.load(scene, &packs, decoding).unwrap();
    renderer.draw(&loaded, &scene.camera, frame).unwrap()
}

fn by_cpu(scene: &Scene, pack: &BrdfPack, decoding: Decoding, frame: Frame) -> LinearImage {
    let reflectance = PackReflectance::new(pack, decoding);
    let materials: Vec<_> = scene.parts.iter().map(|_| &reflectance as _).collect();
    shade(scene, frame, &trace(scene, frame), &materials)
}

/// Share of pixels that differ by more than a thousandth of white, and mean ΔE of those with equal coverage.
fn difference(a: &LinearImage, b: &LinearImage) -> (f64, f64) {
    let exposure = auto_exposure(b);
    let differs = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|k| f64::from((a[k] - b[k]).abs()) * exposure > 1e-3);
    let count = a.pixels.iter().zip(&b.pixels).filter(|pair| differs(*pair)).count();
    let mut alike = a.clone();
    let outlines = (0..a.pixels.len()).filter(|pixel| a.coverage[*pixel] != b.coverage[*pixel]);
    outlines.for_each(|pixel| (alike.pixels[pixel], alike.coverage[pixel]) = (b.pixels[pixel], b.coverage[pixel]));
    (count as f64 / a.pixels.len() as f64, compare_images(&alike, b, exposure).delta_e.mean)
}

#[test]
fn shader_and_cpu_draw_the_same_renderings() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:ward?kd=0.3,0.1,0.05&ks=0.1&ax=0.2&ay=0.5");
    for (name, builtin) in Builtin::NAMES {
        let mut scene = builtin.scene();
        if scene.lights.is_empty() {
            scene.lights = Builtin::Sphere.scene().lights;
        }
        for (filter, level) in [(Filter::Bilinear, None), (Filter::Slices, Some(2.5))] {
            let decoding = Decoding { filter, level, ..EXACT };
            let shader = by_shader(gpu, &scene, &pack, decoding, FRAME);
            let cpu = by_cpu(&scene, &pack, decoding, FRAME);
            let (share, mean) = difference(&shader, &cpu);
            // Differences at outlines, where a sample may fall on either side, and at borders of cells with nearest
            // inner cells.
            assert!(share < 0.015 && mean < 0.05, "{name}, {filter:?}: {share} of the pixels, mean ΔE {mean}");
            let covered = shader.coverage.iter().zip(&cpu.coverage).filter(|(a, b)| a != b).count();
            assert!(covered < FRAME.width * FRAME.height / 100, "{name}: {covered} outlines");
        }
    }
}

type Change = fn(&mut Scene);

/// The controls: changes that one twin could ignore are detected.
#[test]
fn a_change_of_the_scene_is_a_difference() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:lewis?kd=0.3,0.1,0.05&ks=0.5&n=15");
    let scene = Builtin::Table.scene();
    let shader = by_shader(gpu, &scene, &pack, EXACT, FRAME);
    let changes: [(&str, Change); 7] = [
        ("light moved", |s| s.lights[0].position[0] += 0.4),
        ("light gone", |s| s.lights.truncate(s.lights.len() - 1)),
        ("light dimmed", |s| s.lights[0].intensity[1] *= 0.8),
        ("camera moved", |s| s.camera.eye[0] += 0.05),
        ("no bumps", |s| s.parts[0].surface.bump = None),
        ("no mirror", |s| s.parts[3].surface.mirror = 0.0),
        ("another environment", |s| {
            s.environment = Environment { width: 1, height: 1, pixels: vec![[3.0, 0.0, 0.0]] };
        }),
    ];
    for (what, change) in changes {
        let mut changed = scene.clone();
        change(&mut changed);
        let (share, mean) = difference(&shader, &by_cpu(&changed, &pack, EXACT, FRAME));
        assert!(share > 0.02 && mean > 0.05, "{what}: {share} of the pixels, mean ΔE {mean}");
        let (share, mean) =
            difference(&by_shader(gpu, &changed, &pack, EXACT, FRAME), &by_cpu(&changed, &pack, EXACT, FRAME));
        assert!(share < 0.015 && mean < 0.05, "{what}, both changed: {share} of the pixels, mean ΔE {mean}");
    }
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:ward?kd=0.3,0.1,0.05");
    let scene = Builtin::Cloth.scene();
    let hardware = Decoding { slices: SliceFilter::Hardware, ..EXACT };
    let bits = |image: LinearImage| -> Vec<u32> { image.pixels.iter().flatten().map(|c| c.to_bits()).collect() };
    let first = bits(by_shader(gpu, &scene, &pack, hardware, FRAME));
    assert_eq!(first, bits(by_shader(gpu, &scene, &pack, hardware, FRAME)));
    let other = Gpu::open(&Default::default()).unwrap();
    assert_eq!(first, bits(by_shader(&other, &scene, &pack, hardware, FRAME)));
}

#[test]
fn any_number_of_lights() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:lambert?kd=0.5");
    let mut scene = Builtin::Sphere.scene();
    scene.lights.clear();
    assert!(by_shader(gpu, &scene, &pack, EXACT, FRAME).pixels.iter().all(|p| *p == [0.0; 3]));
    for k in 0..40 {
        let angle = f64::from(k) * 0.7;
        scene.lights.push(PointLight { position: [4.0 * angle.cos(), 0.1 * f64::from(k), 5.0], intensity: [1.0; 3] });
    }
    let (share, mean) = difference(&by_shader(gpu, &scene, &pack, EXACT, FRAME), &by_cpu(&scene, &pack, EXACT, FRAME));
    assert!(share < 0.015 && mean < 0.05, "{share} {mean}");
}

/// A white furnace has no point lights, but a matte ball still has a known radiance.
#[test]
fn a_matte_ball_has_the_radiance_of_equation_1() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:lambert?kd=0.6");
    let scene = Builtin::Sphere.scene();
    let frame = Frame { width: 65, height: 65, samples: 1 };
    let image = by_shader(gpu, &scene, &pack, EXACT, frame);
    // The middle pixel sees the point (0, 0, 1), its normal towards the camera.
    let l = scene.lights[0].position;
    let r = [l[0], l[1], l[2] - 1.0];
    let squared = r.iter().map(|c| c * c).sum::<f64>();
    let expected = 0.6 / std::f64::consts::PI * scene.lights[0].intensity[0] * r[2] / squared.powf(1.5);
    let found = f64::from(image.pixels[32 * 65 + 32][0]);
    assert!((found / expected - 1.0).abs() < 5e-3, "{found} {expected}");
}

/// An image whose size is not a multiple of the alignment of rows, in more than one band.
#[test]
fn odd_sizes_are_read_back_whole() {
    let Some(gpu) = crate::common::gpu() else { return };
    let pack = pack("synth:lambert?kd=0.5");
    let scene = Builtin::Sphere.scene();
    for frame in [Frame { width: 1, height: 1, samples: 1 }, Frame { width: 37, height: 501, samples: 1 }] {
        let (share, _) = difference(&by_shader(gpu, &scene, &pack, EXACT, frame), &by_cpu(&scene, &pack, EXACT, frame));
        assert!(share < 0.02, "{frame:?}: {share}");
    }
    let tall = Frame { width: 300, height: 8000, samples: 1 };
    let image = by_shader(gpu, &scene, &pack, EXACT, tall);
    assert_eq!(image.pixels.len(), 300 * 8000);
    assert!(image.coverage[4000 * 300 + 150] == 1.0 && image.coverage[0] == 0.0);
}

#[test]
fn views_separate_sources_of_error() {
    let Some(gpu) = crate::common::gpu() else { return };
    let source = parse_synth("synth:ward?kd=0.3,0.1,0.05&ks=0.1&ax=0.2&ay=0.5").unwrap();
    let recipe = Recipe { measure_off_grid: false, ..Recipe::default() };
    let coarse = BrdfPack::Wavelet(encode(source.as_ref(), &recipe, &()).unwrap().pack);
    let scene = Builtin::Sphere.scene();
    let material = Material { pack: &coarse, source: Some(source.as_ref()), table: None };
    let drawn = views(gpu, &scene, FRAME, &[material], EXACT).unwrap();
    let reference = drawn.source.as_ref().unwrap();
    let exposure = auto_exposure(reference);
    let shading = compare_images(&drawn.shader, &drawn.pack, exposure).delta_e.mean;
    let codec = compare_images(&drawn.pack, reference, exposure).delta_e.mean;
    assert!(shading < 0.02 && codec > 10.0 * shading, "{shading} {codec}");
    let alone = Material { source: None, ..material };
    let drawn = views(gpu, &scene, FRAME, &[alone], EXACT).unwrap();
    assert!(drawn.source.is_none() && std::ptr::eq(drawn.reference(), &drawn.pack));
}
