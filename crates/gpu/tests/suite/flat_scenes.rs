//! Flat BTFs on scenes: the shader compared with the CPU, and both with the displaced surface itself.

use crate::common::flat::{appearance, flattened, with_heights, without_mipmaps};
use brdfc_core::address::parse_synth;
use brdfc_flat_btf::encode::Reflectance;
use brdfc_formats::PackKind;
use brdfc_formats::direction::add_scaled;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::factored::{FactoredFlatBtf, WeightMap, WeightRange};
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, MarchSteps};
use brdfc_gpu::{GpuError, draw_flat_btf, draw_flat_btf_by, flat_scene_source};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_render::flat::{FlatMaterial, Tiles, draw_on_cpu, draw_tiles, reference};
use brdfc_render::scene::{Frame, PointLight, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{SourceReflectance, shade};
use brdfc_render::trace::trace;
use brdfc_testing::codecs::flat_btf::{BASE, Factors, SMALL, Sizes, factored, layers, layers_of};
use brdfc_testing::codecs::flat_btf_trees::trees;
use std::sync::LazyLock;

const FRAME: Frame = Frame { width: 96, height: 72, samples: 2 };
const BUTTON: &str = "button?resolution=48&count=1";
const REPEAT: u32 = 2;

fn stud(reflectance: Reflectance, bounces: usize) -> FlatBtfParts {
    let directions = DirectionSet::grid(4, 8, 75.0).unwrap();
    flattened(BUTTON, &appearance(BUTTON, None), 64, &directions, (reflectance, bounces)).decoder.into_parts()
}

/// A stud whose cap overhangs its neck: its material, with rays of light.
static STUD: LazyLock<FlatBtfParts> = LazyLock::new(|| stud(Reflectance::Brdf, 0));
/// The same stud by components of 25 views and lights.
static COMPONENTS: LazyLock<FlatBtfParts> = LazyLock::new(|| stud(Reflectance::Factors, 0));
/// Light of one bounce in addition, which reaches shadows.
static BOUNCED: LazyLock<FlatBtfParts> = LazyLock::new(|| stud(Reflectance::Factors, 4));

fn material(parts: &FlatBtfParts) -> FlatMaterial {
    FlatMaterial::new(FlatBtfDecoder::new(parts.clone()), REPEAT).unwrap()
}

/// Share of pixels that differ by more than a hundredth of white, and mean ΔE.
fn difference(a: &LinearImage, b: &LinearImage) -> (f64, f64) {
    let exposure = auto_exposure(b);
    let differs = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|k| f64::from((a[k] - b[k]).abs()) * exposure > 1e-2);
    let count = a.pixels.iter().zip(&b.pixels).filter(|pair| differs(*pair)).count();
    (count as f64 / a.pixels.len() as f64, compare_images(a, b, exposure).delta_e.mean)
}

/// Checks that images agree except at outlines, and where a ray passes an edge on another side.
fn same(a: &LinearImage, b: &LinearImage, what: &str, most: (f64, f64)) {
    let (share, mean) = difference(a, b);
    println!("{what}: {share} of the pixels, mean ΔE {mean}");
    // The shader derives mipmap levels, curvature and stretch from neighbouring pixels, the CPU from the triangle.
    assert!(share < most.0 && mean < most.1, "{what}: {share} of the pixels, mean ΔE {mean}");
    let covered = a.coverage.iter().zip(&b.coverage).filter(|(a, b)| a != b).count();
    assert!(covered < FRAME.width * FRAME.height / 100, "{what}: {covered} outlines");
}

#[test]
fn shader_and_cpu_draw_the_same_renderings() {
    let Some(gpu) = crate::common::gpu() else { return };
    assert!(layers_of(&STUD).header().sheets == 3 && COMPONENTS.reflectance.factors().unwrap().residual().is_none());
    assert!(BOUNCED.reflectance.factors().unwrap().residual().is_some());
    for (name, parts) in [("material", &*STUD), ("components", &COMPONENTS), ("bounces", &BOUNCED)] {
        let material = material(parts);
        // The ball has stretched tiles; the table has bump maps, which apply only to BRDFs; the terrain shows texels far away.
        for builtin in [Builtin::Plane, Builtin::Vase, Builtin::Sphere, Builtin::Table, Builtin::Terrain] {
            let scene = builtin.scene();
            let shader = draw_flat_btf(gpu, &scene, FRAME, &material).unwrap();
            let cpu = draw_on_cpu(&scene, FRAME, &material);
            assert!(cpu.pixels.iter().filter(|p| p[0] > 0.01).count() > FRAME.width * FRAME.height / 8);
            // The terrain is seen almost from the side, where rays are longest: 1.1 to 2.0 % of its pixels differ.
            let most = if builtin == Builtin::Terrain { (0.022, 0.25) } else { (0.02, 0.05) };
            same(&shader, &cpu, &format!("{name}, {}", builtin.name()), most);
        }
    }
}

/// Trees with their own shadows, and with rays of light.
#[test]
fn shader_and_cpu_draw_the_same_trees() {
    let Some(gpu) = crate::common::gpu() else { return };
    for is_learned in [false, true] {
        let material = material(&FlatBtfParts::new(layers_of(&STUD).clone(), trees(is_learned)));
        for builtin in [Builtin::Plane, Builtin::Vase] {
            let scene = builtin.scene();
            let shader = draw_flat_btf(gpu, &scene, FRAME, &material).unwrap();
            let cpu = draw_on_cpu(&scene, FRAME, &material);
            assert!(cpu.pixels.iter().filter(|p| p[0] > 0.01).count() > FRAME.width * FRAME.height / 8);
            same(&shader, &cpu, &format!("trees, learned {is_learned}, {}", builtin.name()), (0.02, 0.2));
        }
    }
}

/// Components approximate the material, and bounces brighten shadows.
#[test]
fn all_reflectances_look_alike() {
    let scene = Builtin::Plane.scene();
    let drawn = [&*STUD, &COMPONENTS, &BOUNCED].map(|parts| draw_on_cpu(&scene, FRAME, &material(parts)));
    for (name, image) in [("components", &drawn[1]), ("bounces", &drawn[2])] {
        let (_, mean) = difference(image, &drawn[0]);
        println!("{name} against the material: mean ΔE {mean}");
        assert!((0.01..4.0).contains(&mean), "{name}: {mean}");
    }
    // The control: without relief.
    let (_, mean) = difference(&draw_on_cpu(&scene, FRAME, &material(&with_heights(&STUD, 1e-6))), &drawn[0]);
    println!("without relief: mean ΔE {mean}");
    assert!(mean > 18.0, "{mean}");
}

/// Far away a texel represents many.
#[test]
fn mipmaps_matter_far_away() {
    let scene = Builtin::Terrain.scene();
    let drawn = |parts: &FlatBtfParts| {
        let material = FlatMaterial::new(FlatBtfDecoder::new(parts.clone()), 32).unwrap();
        draw_on_cpu(&scene, FRAME, &material)
    };
    // Found 2.96 and 1.87.
    for (parts, least) in [(&*STUD, 2.0), (&COMPONENTS, 1.5)] {
        let (_, mean) = difference(&drawn(&without_mipmaps(parts)), &drawn(parts));
        println!("the finest level against mipmaps: mean ΔE {mean}");
        assert!(mean > least, "{mean}");
    }
}

type Change = fn(&mut Scene);

/// The controls: changes that one twin could ignore are detected.
#[test]
fn a_change_of_the_scene_or_of_the_shader_is_a_difference() {
    let Some(gpu) = crate::common::gpu() else { return };
    let whole = material(&COMPONENTS);
    let scene = Builtin::Plane.scene();
    let cpu = draw_on_cpu(&scene, FRAME, &whole);
    let changes: [(&str, Change); 4] = [
        ("light moved", |s| s.lights[0].position[0] += 1.0),
        ("light dimmed", |s| s.lights[0].intensity[1] *= 0.8),
        ("camera moved", |s| s.camera.eye[0] += 0.1),
        ("tiles mirrored", |s| s.parts[0].mesh.vertices.iter_mut().for_each(|v| v.uv[0] = 1.0 - v.uv[0])),
    ];
    for (what, change) in changes {
        let mut changed = scene.clone();
        change(&mut changed);
        let (share, mean) = difference(&draw_flat_btf(gpu, &changed, FRAME, &whole).unwrap(), &cpu);
        assert!(share > 0.1 && mean > 0.4, "{what}: {share} of the pixels, mean ΔE {mean}");
    }
    // Tiles follow the coordinates, not the tangents.
    let mut turned = scene.clone();
    turned.parts[0].mesh.vertices.iter_mut().for_each(|vertex| vertex.tangent = [0.0, 0.0, 1.0]);
    same(&draw_flat_btf(gpu, &turned, FRAME, &whole).unwrap(), &cpu, "tangents turned", (0.02, 0.2));
    let mut below = scene.clone();
    // Both below the sampled lights, and seen from below.
    below.lights[0].position = [-2.6, -0.3, -1.0];
    below.camera.eye[1] = -1.5;
    let drawn = |source: String, scene: &Scene| draw_flat_btf_by(gpu, source, scene, FRAME, &whole).unwrap();
    let from_below = draw_on_cpu(&below, FRAME, &whole);
    assert!(from_below.pixels.iter().any(|p| p[0] > 0.0), "lit from below");
    same(&drawn(flat_scene_source(PackKind::FlatBtf), &below), &from_below, "from below", (0.02, 0.2));
    let vase = Builtin::Vase.scene();
    let on_vase = draw_on_cpu(&vase, FRAME, &whole);
    let ball = Builtin::Sphere.scene();
    let on_ball = draw_on_cpu(&ball, FRAME, &whole);
    let edits = [
        (&scene, &cpu, "FLAT_BTF_RISE: f32 = ", "FLAT_BTF_RISE: f32 = 0.0 * "),
        (&scene, &cpu, "ray, detail, flat_btf_parameters.sight_steps", "ray, detail, 2u"),
        (&scene, &cpu, "if any(value != vec3<f32>(0.0)) &&", "if false &&"),
        (&below, &from_below, "select(vec2<f32>(in.uv.x, -in.uv.y), in.uv, front)", "in.uv"),
        (&below, &from_below, "select(-1.0, 1.0, front) * normalize", "normalize"),
        (&below, &from_below, "min(light.z / lowest_light, 1.0)", "1.0"),
        (&vase, &on_vase, "let sign = select(-1.0, 1.0, front);", "let sign = select(1.0, -1.0, front);"),
        (&vase, &on_vase, "sign * in.raised_by", "0.0 * in.raised_by"),
        (&vase, &on_vase, "return sqrt(abs(area)", "return 0.5 * sqrt(abs(area)"),
        (&vase, &on_vase, "along_v.y) * side", "along_v.y) * -side"),
        (&vase, &on_vase, "return sight.point.rise * vec3", "return 0.0 * vec3"),
        (&vase, &on_vase, "return surface.border.x", "return 0.0 * surface.border.x"),
        (&ball, &on_ball, "tiles_right * b.y - tiles_below * a.y", "tiles_right * b.y"),
        (&ball, &on_ball, "let along_b = (", "let along_b = -("),
    ];
    for (scene, expected, from, to) in edits {
        assert_eq!(flat_scene_source(PackKind::FlatBtf).matches(from).count(), 1, "{from}");
        let (share, mean) = difference(&drawn(flat_scene_source(PackKind::FlatBtf).replace(from, to), scene), expected);
        println!("{from} -> {to}: {share} of the pixels, mean ΔE {mean}");
        assert!(share > 0.03 && mean > 0.3, "{from} -> {to}: {share} of the pixels, mean ΔE {mean}");
    }
}

#[test]
fn parallax_and_shadows_are_those_of_the_displaced_surface() {
    let appearance = appearance(BUTTON, None);
    let directions = DirectionSet::grid(2, 4, 60.0).unwrap();
    let made = flattened(BUTTON, &appearance, 128, &directions, (Reflectance::Brdf, 0));
    let mut scene = Builtin::Plane.scene();
    // Far away, so that light is parallel.
    let towards = DirectionSet::new("light", vec![[50.0, 135.0]]).unwrap().directions()[0];
    let position = add_scaled([0.0; 3], 100.0, [towards[0], towards[2], -towards[1]]);
    scene.lights = vec![PointLight { position, intensity: [1e4 * std::f64::consts::PI; 3] }];
    let reference = reference(&scene, FRAME, &made.model, &appearance, REPEAT);
    let parts = made.decoder.into_parts();
    let steps = MarchSteps { sight: 40, refine: 4, both: 80 };
    // The controls: no relief, and one twice as high.
    let materials = [1.0, 1e-6, 2.0].map(|factor| {
        let decoder = FlatBtfDecoder::new(with_heights(&parts, factor)).with_steps(steps);
        FlatMaterial::new(decoder, REPEAT).unwrap()
    });
    let check = |what: &str, draw: &dyn Fn(&FlatMaterial) -> LinearImage| {
        let [right, none, wrong] = materials.each_ref().map(|material| {
            let image = draw(material);
            let edge = image.coverage.iter().zip(&reference.coverage).filter(|(a, b)| a != b).count();
            assert!(edge < 30, "{what}: {edge} pixels of the edge");
            compare_images(&image, &reference, auto_exposure(&reference)).delta_e.mean
        });
        println!("{what}: mean ΔE {right}, {none} without relief, {wrong} twice as high");
        assert!(right < 4.0 && none > 4.0 * right && wrong > 4.0 * right, "{what}: {right} {none} {wrong}");
    };
    check("CPU", &|material| draw_on_cpu(&scene, FRAME, material));
    if let Some(gpu) = crate::common::gpu() {
        check("GPU", &|material| draw_flat_btf(gpu, &scene, FRAME, material).unwrap());
    }
}

/// Tiles per unit of uv of these objects: with fewer, the relief is high for their curvature.
const FINER: u32 = 4;

/// Outlines included. The controls: the surface below the relief, and no relief.
#[test]
fn objects_are_those_of_the_displaced_object() {
    let appearance = appearance(BUTTON, None);
    let directions = DirectionSet::grid(2, 4, 60.0).unwrap();
    let made = flattened(BUTTON, &appearance, 128, &directions, (Reflectance::Brdf, 0));
    let frame = Frame { width: 120, height: 120, samples: 2 };
    let whole = FlatMaterial::new(made.decoder.clone(), FINER).unwrap();
    let none = FlatMaterial::new(FlatBtfDecoder::new(with_heights(made.decoder.parts(), 1e-6)), FINER).unwrap();
    // Tiles of the ball are twice as wide as high at its equator, and narrow at its poles.
    for builtin in [Builtin::Vase, Builtin::Teapot, Builtin::Sphere] {
        let scene = builtin.scene();
        let reference = reference(&scene, frame, &made.model, &appearance, FINER);
        let against = |image: &LinearImage| {
            let outlines = image.coverage.iter().zip(&reference.coverage).filter(|(a, b)| a != b).count();
            (compare_images(image, &reference, auto_exposure(&reference)).delta_e.mean, outlines)
        };
        let tiles = Tiles { repeat: FINER, texels: 128 };
        let below = draw_tiles(&scene, frame, tiles, |at, level, view| {
            let whole = &whole;
            ([0.0; 3], move |light| whole.value(at, level, view, light))
        });
        let (below, no_relief) = (against(&below), against(&draw_on_cpu(&scene, frame, &none)));
        let mut drawn = vec![("CPU", draw_on_cpu(&scene, frame, &whole))];
        if let Some(gpu) = crate::common::gpu() {
            drawn.push(("GPU", draw_flat_btf(gpu, &scene, frame, &whole).unwrap()));
        }
        for (what, image) in drawn {
            let (error, outlines) = against(&image);
            println!("{what}, {}: mean ΔE {error}, {outlines} outlines", builtin.name());
            println!("on the surface below: {below:?}; without relief: {no_relief:?}");
            assert!(1.3 * error < below.0 && 2.0 * error < no_relief.0, "{what}: {error} {below:?} {no_relief:?}");
            assert!(4 * outlines < 3 * below.1 && 4 * outlines < 3 * no_relief.1, "{what}: {outlines} {below:?}");
        }
    }
}

/// A matte material and a broad gloss, both without components.
#[test]
fn a_flat_structure_looks_like_its_brdf() {
    let address = "button?resolution=16&height=0&count=1";
    for (brdf, most) in [("synth:lambert?kd=0.6,0.3,0.1", 0.4), ("synth:lewis?kd=0.3,0.1,0.05&ks=0.2&n=3", 1.0)] {
        let directions = DirectionSet::grid(2, 4, 60.0).unwrap();
        let made = flattened(address, &appearance(address, Some(brdf)), 4, &directions, (Reflectance::Brdf, 0));
        let FlatBtfParts { relief, reflectance } = made.decoder.into_parts();
        // The structure's tints vary over the tile; this test needs one material everywhere.
        let parts = FlatBtfParts::new(relief, untinted(reflectance.factors().unwrap()));
        let material = material(&parts);
        let source = parse_synth(brdf).unwrap();
        for builtin in [Builtin::Plane, Builtin::Vase] {
            let scene = builtin.scene();
            let expected = shade(&scene, FRAME, &trace(&scene, FRAME), &[&SourceReflectance(source.as_ref())]);
            let drawn = draw_on_cpu(&scene, FRAME, &material);
            let exposure = auto_exposure(&expected);
            let found = compare_images(&drawn, &expected, exposure).delta_e;
            println!("{brdf}, {builtin:?}: {found:?}");
            assert!(found.mean < most, "{brdf}, {builtin:?}: {found:?}");
            let other = parse_synth("synth:lambert?kd=0.5,0.3,0.2").unwrap();
            let other = shade(&scene, FRAME, &trace(&scene, FRAME), &[&SourceReflectance(other.as_ref())]);
            assert!(compare_images(&drawn, &other, exposure).delta_e.mean > 4.0, "the control");
        }
    }
}

/// The first material without tint.
fn untinted(asset: &FactoredFlatBtf) -> FactoredFlatBtf {
    assert!(!asset.basis().materials().is_empty());
    let weights = asset.weights();
    let mut ranges = weights.ranges().to_vec();
    for (range, low) in ranges.iter_mut().zip([1.0, 1.0, 1.0, 0.0]) {
        *range = WeightRange { scale: 0.0, low };
    }
    let weights = WeightMap::new(weights.size(), weights.levels(), ranges, weights.texels().to_vec()).unwrap();
    FactoredFlatBtf::new(asset.basis().clone(), weights, None).unwrap()
}

/// The number of layers is the minimum that WebGPU guarantees.
#[test]
fn errors_of_large_assets_have_advice() {
    let Some(gpu) = crate::common::gpu() else { return };
    let sizes = Sizes { flat: 2, lights: 301, ..SMALL };
    let drawn = |residual: u32| {
        let factors = Factors { levels: 1, groups: 1, residual, ..BASE };
        let parts = FlatBtfParts::new(layers(sizes, 1), factored(sizes, factors, 2));
        draw_flat_btf(gpu, &Builtin::Plane.scene(), FRAME, &material(&parts))
    };
    let error = drawn(1).unwrap_err();
    let GpuError::TooLarge(text) = error else { panic!("{error}") };
    assert!(text.contains("301 lights") && text.contains("make the flat BTF with fewer lights"), "{text}");
    assert!(drawn(0).is_ok());
}

#[test]
fn materials_without_components_or_repetition() {
    let decoder = FlatBtfDecoder::new(STUD.clone());
    assert!(FlatMaterial::new(decoder, 0).unwrap_err().to_string().contains("repeat"));
    assert!(material(&STUD).directions().is_none() && material(&COMPONENTS).directions().is_some());
    // Lights at and below the horizon contribute nothing.
    let value = |light| material(&STUD).value([0.1, 0.2], 0.0, [0.0, 0.0, 1.0], light);
    assert_eq!([value([1.0, 0.0, 0.0]), value([0.6, 0.0, -0.8])], [[0.0; 3]; 2]);
    assert!(value([0.0, 0.0, 1.0])[0] > 0.0);
}
