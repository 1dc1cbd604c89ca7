//! Flat BTFs on scenes: the shader compared with the CPU, and both with the displaced surface itself.

use crate::common::flat::{parts, structure, with_displacements};
use brdfc_core::address::parse_synth;
use brdfc_flat_btf::displacement::displacements;
use brdfc_flat_btf::factored::{FactoredRecipe, FactoredTarget, factor};
use brdfc_formats::direction::add_scaled;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::factored::{BasisMap, FactoredFlatBtf, FactoredHeader, ShadowMap, WeightMap};
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatHeader, FlatValues, FlatView, IndirectionHeader, NormalMap,
    VisibilityMask,
};
use brdfc_gpu::{GpuError, draw_flat_btf, draw_flat_btf_by, flat_scene_source};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_render::flat::{FlatForm, FlatMaterial, draw_on_cpu, reference_plane};
use brdfc_render::scene::{Frame, PointLight, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{SourceReflectance, shade};
use brdfc_render::trace::trace;
use std::convert::Infallible;
use std::f32::consts::FRAC_PI_2;
use std::sync::LazyLock;

const FRAME: Frame = Frame { width: 96, height: 72, samples: 2 };
const HEADER: IndirectionHeader =
    IndirectionHeader { size: 32, zenith_samples: 12, azimuth_samples: 16, largest_angle: FRAC_PI_2 };
const BUTTON: &str = "button?resolution=48&count=1";
const REPEAT: u32 = 2;

/// A stud, seen and lit from 25 directions.
static STUD: LazyLock<FlatBtfParts> = LazyLock::new(|| {
    let (model, appearance) = structure(BUTTON, None);
    let directions = DirectionSet::grid(4, 8, 75.0).unwrap();
    parts(&model, &appearance, 64, HEADER, [&directions; 2])
});

fn material(parts: &FlatBtfParts) -> FlatMaterial {
    FlatMaterial::new(FlatBtfDecoder::new(parts.clone()).unwrap(), REPEAT).unwrap()
}

/// Share of pixels that differ by more than a hundredth of white, and mean ΔE.
fn difference(a: &LinearImage, b: &LinearImage) -> (f64, f64) {
    let exposure = auto_exposure(b);
    let differs = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|k| f64::from((a[k] - b[k]).abs()) * exposure > 1e-2);
    let count = a.pixels.iter().zip(&b.pixels).filter(|pair| differs(*pair)).count();
    (count as f64 / a.pixels.len() as f64, compare_images(a, b, exposure).delta_e.mean)
}

/// Checks that images agree except at outlines, and at borders of unfiltered values, where a sample may fall on either
/// side.
fn same(a: &LinearImage, b: &LinearImage, what: &str) {
    alike(a, b, what, [0.01, 0.05]);
}

/// The same check with its own bounds: share of pixels, and mean ΔE.
fn alike(a: &LinearImage, b: &LinearImage, what: &str, [most_pixels, most_mean]: [f64; 2]) {
    let (share, mean) = difference(a, b);
    println!("{what}: {share} of the pixels, mean ΔE {mean}");
    assert!(share < most_pixels && mean < most_mean, "{what}: {share} of the pixels, mean ΔE {mean}");
    let covered = a.coverage.iter().zip(&b.coverage).filter(|(a, b)| a != b).count();
    assert!(covered < FRAME.width * FRAME.height / 100, "{what}: {covered} outlines");
}

/// The stud in fewer bytes: displacements, and factors with mipmaps.
static SMALLER: LazyLock<FlatBtfParts> = LazyLock::new(|| {
    let views = STUD.values.views();
    let size = STUD.diffuse.size();
    let seen = vec![255; (size * size) as usize * views.len()];
    let mask = VisibilityMask::new(size, views.len() as u32, seen).unwrap();
    let recipe = FactoredRecipe::new(FactoredTarget::Components { components: 24, shadowed: true });
    let made =
        factor(&recipe, &STUD.normal, &mask, |view| Ok::<_, Infallible>(views[view as usize].clone()), &()).unwrap();
    let map = STUD.indirection.samples().unwrap();
    let moved = |texel, k, a| map.displacement(texel, k, a);
    let (displacements, reference) = displacements(*map.header(), &STUD.reference, moved, 2).unwrap();
    FlatBtfParts {
        reference,
        indirection: displacements.into(),
        values: FlatValues::Factored(Box::new(made.asset)),
        ..STUD.clone()
    }
});

/// The terrain shows texels far away. The plane compares the small form with the large one.
#[test]
fn shader_and_cpu_draw_the_same_renderings_of_factors() {
    let Some(gpu) = crate::common::gpu() else { return };
    let (many, few) = (material(&STUD), material(&SMALLER));
    for builtin in [Builtin::Plane, Builtin::Vase, Builtin::Terrain] {
        let scene = builtin.scene();
        let shader = draw_flat_btf(gpu, &scene, FRAME, &few, FlatForm::Full).unwrap();
        let pack = draw_on_cpu(&scene, FRAME, &few, FlatForm::Full);
        // The shader derives mipmap levels from neighbouring pixels, the CPU from the triangle's plane.
        alike(&shader, &pack, builtin.name(), [0.02, 0.2]);
    }
    let scene = Builtin::Plane.scene();
    let [many, few] = [many, few].map(|material| draw_on_cpu(&scene, FRAME, &material, FlatForm::Full));
    let (_, mean) = difference(&few, &many);
    let errors = SMALLER.values.factored().unwrap().header().errors;
    println!("factors against views: mean ΔE {mean}, at sampled directions {errors:?}");
    // Between these few directions the views blend what the base separates.
    assert!((0.01..20.0).contains(&mean), "{mean}");
    // In the mask all texels are visible, including filled ones.
    assert!(errors.texels > 100 && errors.seen_mean < 4.0, "{errors:?}");
    // Far away a texel represents many.
    let finest = FlatBtfParts { values: without_mipmaps(&SMALLER.values), ..SMALLER.clone() };
    let scene = Builtin::Terrain.scene();
    let drawn = |parts: &FlatBtfParts| {
        let material = FlatMaterial::new(FlatBtfDecoder::new(parts.clone()).unwrap(), 32).unwrap();
        draw_on_cpu(&scene, FRAME, &material, FlatForm::Full)
    };
    let (_, mean) = difference(&drawn(&finest), &drawn(&SMALLER));
    println!("the finest level against mipmaps: mean ΔE {mean}");
    assert!(mean > 2.0, "{mean}");
}

/// The finest level alone.
fn without_mipmaps(values: &FlatValues) -> FlatValues {
    let asset = values.factored().unwrap();
    let header = FactoredHeader { levels: 1, ..asset.header().clone() };
    let texels = (header.size * header.size) as usize;
    let basis = BasisMap::new(header.clone(), asset.basis().words().to_vec()).unwrap();
    let layers = asset.weights().layers() as usize;
    let weights = asset.weights().texels()[..4 * layers * texels].to_vec();
    let weights = WeightMap::new(header.size, 1, asset.weights().ranges().to_vec(), weights).unwrap();
    let lights = header.lights.len();
    let shadow = asset
        .shadow()
        .map(|map| ShadowMap::new(header.size, 1, lights as u32, map.texels()[..lights * texels].to_vec()).unwrap());
    FlatValues::Factored(Box::new(FactoredFlatBtf::new(basis, weights, shadow).unwrap()))
}

#[test]
fn shader_and_cpu_draw_the_same_renderings() {
    let Some(gpu) = crate::common::gpu() else { return };
    let material = material(&STUD);
    // The table has bump maps, which apply only to BRDFs.
    for builtin in [Builtin::Plane, Builtin::Vase, Builtin::Table] {
        let scene = builtin.scene();
        for form in [FlatForm::Full, FlatForm::Light] {
            let shader = draw_flat_btf(gpu, &scene, FRAME, &material, form).unwrap();
            let cpu = draw_on_cpu(&scene, FRAME, &material, form);
            assert!(cpu.pixels.iter().filter(|p| p[0] > 0.01).count() > FRAME.width * FRAME.height / 8);
            same(&shader, &cpu, &format!("{}, {form:?}", builtin.name()));
        }
    }
}

type Change = fn(&mut Scene);

/// The controls: changes that one twin could ignore are detected.
#[test]
fn a_change_of_the_scene_or_of_the_shader_is_a_difference() {
    let Some(gpu) = crate::common::gpu() else { return };
    let whole = material(&STUD);
    let scene = Builtin::Plane.scene();
    let cpu = draw_on_cpu(&scene, FRAME, &whole, FlatForm::Full);
    let changes: [(&str, Change); 4] = [
        ("light moved", |s| s.lights[0].position[0] += 1.0),
        ("light dimmed", |s| s.lights[0].intensity[1] *= 0.8),
        ("camera moved", |s| s.camera.eye[0] += 0.1),
        ("tangents turned", |s| s.parts[0].mesh.vertices.iter_mut().for_each(|v| v.tangent = [0.0, 0.0, 1.0])),
    ];
    for (what, change) in changes {
        let mut changed = scene.clone();
        change(&mut changed);
        let (share, mean) = difference(&draw_flat_btf(gpu, &changed, FRAME, &whole, FlatForm::Full).unwrap(), &cpu);
        assert!(share > 0.1 && mean > 0.4, "{what}: {share} of the pixels, mean ΔE {mean}");
    }
    let mut below = scene.clone();
    // Both below the sampled lights, and seen from below.
    below.lights[0].position = [-2.6, -0.3, -1.0];
    below.camera.eye[1] = -1.5;
    let from_below = draw_on_cpu(&below, FRAME, &whole, FlatForm::Full);
    assert!(from_below.pixels.iter().any(|p| p[0] > 0.0), "lit from below");
    let drawn =
        |source: String, scene: &Scene| draw_flat_btf_by(gpu, source, scene, FRAME, &whole, FlatForm::Full).unwrap();
    same(&drawn(flat_scene_source(), &below), &from_below, "from below");
    let edits = [
        ("select(vec2<f32>(in.uv.x, -in.uv.y), in.uv, front)", "in.uv"),
        ("select(-n, n, front)", "n"),
        ("min(light.z / lowest_light, 1.0)", "1.0"),
    ];
    for (from, to) in edits {
        assert_eq!(flat_scene_source().matches(from).count(), 1, "{from}");
        let (share, mean) = difference(&drawn(flat_scene_source().replace(from, to), &below), &from_below);
        assert!(share > 0.05 && mean > 0.4, "{from} -> {to}: {share} of the pixels, mean ΔE {mean}");
    }
}

#[test]
fn parallax_is_that_of_the_displaced_surface() {
    let (model, appearance) = structure(BUTTON, None);
    let mut scene = Builtin::Plane.scene();
    // At the one sampled direction, far away, so that only views are blended.
    let light = DirectionSet::new("light", vec![[50.0, 135.0]]).unwrap();
    let towards = light.directions()[0];
    let position = add_scaled([0.0; 3], 100.0, [towards[0], towards[2], -towards[1]]);
    scene.lights = vec![PointLight { position, intensity: [1e4 * std::f64::consts::PI; 3] }];
    let reference = reference_plane(&scene, FRAME, &model, &appearance, REPEAT);
    let header = IndirectionHeader { size: 48, ..HEADER };
    let made = parts(&model, &appearance, 128, header, [&DirectionSet::ubo2003(), &light]);
    // The controls: no parallax, and inverted parallax.
    let materials = [1.0, 0.0, -1.0].map(|factor| material(&with_displacements(&made, factor)));
    let check = |what: &str, draw: &dyn Fn(&FlatMaterial) -> LinearImage| {
        let [right, none, wrong] = materials.each_ref().map(|material| {
            let image = draw(material);
            let edge = image.coverage.iter().zip(&reference.coverage).filter(|(a, b)| a != b).count();
            assert!(edge < 30, "{what}: {edge} pixels of the edge");
            compare_images(&image, &reference, auto_exposure(&reference)).delta_e.mean
        });
        println!("{what}: mean ΔE {right}, {none} without parallax, {wrong} inverted");
        assert!(right < 4.0 && none > 4.0 * right && wrong > 4.0 * right, "{what}: {right} {none} {wrong}");
    };
    check("CPU", &|material| draw_on_cpu(&scene, FRAME, material, FlatForm::Full));
    if let Some(gpu) = crate::common::gpu() {
        check("GPU", &|material| draw_flat_btf(gpu, &scene, FRAME, material, FlatForm::Full).unwrap());
    }
}

/// Two materials: a matte one, which both forms represent exactly, and a broad gloss, which sampled directions
/// represent approximately.
#[test]
fn a_flat_structure_looks_like_its_brdf() {
    let directions = DirectionSet::grid(9, 24, 80.0).unwrap();
    let header = IndirectionHeader { size: 4, zenith_samples: 4, azimuth_samples: 4, largest_angle: FRAC_PI_2 };
    for (address, forms) in [
        ("synth:lambert?kd=0.6,0.3,0.1", &[FlatForm::Full, FlatForm::Light][..]),
        ("synth:lewis?kd=0.3,0.1,0.05&ks=0.2&n=3", &[FlatForm::Full][..]),
    ] {
        let (model, appearance) = structure("button?resolution=16&height=0&count=1", Some(address));
        let mut made = parts(&model, &appearance, 4, header, [&directions; 2]);
        // The structure's tints vary over the tile; this test needs one material everywhere.
        untint(&mut made, &appearance, &directions);
        let material = material(&made);
        let source = parse_synth(address).unwrap();
        for builtin in [Builtin::Plane, Builtin::Vase] {
            let scene = builtin.scene();
            let expected = shade(&scene, FRAME, &trace(&scene, FRAME), &[&SourceReflectance(source.as_ref())]);
            for form in forms {
                let drawn = draw_on_cpu(&scene, FRAME, &material, *form);
                let exposure = auto_exposure(&expected);
                let found = compare_images(&drawn, &expected, exposure).delta_e;
                println!("{address}, {builtin:?}, {form:?}: {found:?}");
                // Colours of 9 bits are off by up to half a percent.
                let most = if *form == FlatForm::Light { 0.4 } else { 1.0 };
                assert!(found.mean < most, "{address}, {builtin:?}, {form:?}: {found:?}");
                let other = parse_synth("synth:lambert?kd=0.5,0.3,0.2").unwrap();
                let other = shade(&scene, FRAME, &trace(&scene, FRAME), &[&SourceReflectance(other.as_ref())]);
                assert!(compare_images(&drawn, &other, exposure).delta_e.mean > 4.0, "the control");
            }
        }
    }
}

/// Gives every texel the values of the material itself.
fn untint(parts: &mut FlatBtfParts, appearance: &brdfc_flat_btf::surface::Appearance, directions: &DirectionSet) {
    use brdfc_formats::container::rgb9e5;
    use brdfc_formats::direction::DirectionPair;
    let all = directions.directions();
    let texels = (parts.diffuse.size() * parts.diffuse.size()) as usize;
    let value = |view, light: [f64; 3]| {
        let f_r = appearance.sources[0].eval(DirectionPair::new(light, view), &mut Default::default());
        f_r.map(|f| (f * std::f64::consts::PI * light[2]) as f32)
    };
    let FlatValues::Views(views) = &mut parts.values else { panic!("{:?}", parts.values) };
    for (view, flat) in views.iter_mut().enumerate() {
        let values = all.iter().flat_map(|light| vec![rgb9e5::encode(value(all[view], *light)); texels]);
        *flat = FlatView::new(flat.header().clone(), values.collect()).unwrap();
    }
    let up = [0.0, 0.0, 1.0];
    parts.diffuse = DiffuseMap::from_colours(parts.diffuse.size(), &vec![value(up, up); texels]).unwrap();
    parts.normal = NormalMap::new(parts.normal.size(), vec![[0.0, 0.0, 1.0]; texels]).unwrap();
}

/// Sides are tested in the unit tests of the textures. Here the number of layers is the minimum that WebGPU guarantees.
#[test]
fn errors_of_large_assets_have_advice() {
    let Some(gpu) = crate::common::gpu() else { return };
    let mut large = STUD.clone();
    let directions = DirectionSet::grid(4, 100, 60.0).unwrap();
    let views: Vec<[f32; 2]> = directions.angles.iter().map(|a| a.map(|degrees| degrees.to_radians() as f32)).collect();
    let texels = large.diffuse.texels();
    let flat = |view| {
        let header = FlatHeader { size: 64, view, views: views.clone(), lights: vec![[0.0; 2]] };
        FlatView::new(header, texels.to_vec()).unwrap()
    };
    large.values = FlatValues::Views((0..views.len() as u32).map(flat).collect());
    let (material, scene) = (material(&large), Builtin::Plane.scene());
    let error = draw_flat_btf(gpu, &scene, FRAME, &material, FlatForm::Full).unwrap_err();
    let GpuError::TooLarge(text) = error else { panic!("{error}") };
    assert!(text.contains("301 views") && text.contains("draw the light form"), "{text}");
    assert!(draw_flat_btf(gpu, &scene, FRAME, &material, FlatForm::Light).is_ok());
}

#[test]
fn materials_without_views_or_repetition() {
    let alone = FlatBtfParts { values: FlatValues::None, ..STUD.clone() };
    let decoder = FlatBtfDecoder::new(alone).unwrap();
    assert!(FlatMaterial::new(decoder.clone(), 0).unwrap_err().to_string().contains("repeat"));
    let material = FlatMaterial::new(decoder, 1).unwrap();
    assert!(!material.has_views() && self::material(&STUD).has_views());
    let scene = Builtin::Plane.scene();
    let drawn = draw_on_cpu(&scene, FRAME, &material, FlatForm::Light);
    let whole = FlatMaterial::new(FlatBtfDecoder::new(STUD.clone()).unwrap(), 1).unwrap();
    assert_eq!(drawn, draw_on_cpu(&scene, FRAME, &whole, FlatForm::Light));
}
