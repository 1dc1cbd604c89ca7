//! A scene that needs only some directions of its materials looks the same with packs that contain only those.

use brdfc_core::Source;
use brdfc_core::address::parse_synth;
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{Crop, DirectionRange, Elevations};
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::{Material, PackReflectance, views};
use brdfc_gpu::{Decoding, Gpu, Renderer, SliceFilter};
use brdfc_metrics::image::LinearImage;
use brdfc_render::scene::{Camera, Frame, PointLight, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::shade;
use brdfc_render::trace::trace;
use brdfc_render::within::outside;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::recipe::Recipe;

const FRAME: Frame = Frame { width: 64, height: 48, samples: 2 };
const DIRECTIONS: DirectionRange =
    DirectionRange { light: Elevations { from: 30.0, to: 80.0 }, view: Elevations { from: 35.0, to: 90.0 } };
const ADDRESS: &str = "synth:ward?kd=0.3,0.1,0.05&ks=0.1&ax=0.2&ay=0.4";

/// A floor, seen from above by the light of a low lamp and a high one.
fn floor(eye: [f64; 3]) -> Scene {
    let lamp = |position| PointLight { position, intensity: [300.0, 250.0, 200.0] };
    let camera = Camera { eye, target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 10.0 };
    Scene { lights: vec![lamp([9.0, 8.0, 4.0]), lamp([-3.0, 11.0, 2.0])], camera, ..Builtin::Plane.scene() }
}

fn source() -> Box<dyn Source> {
    parse_synth(ADDRESS).expect("an address")
}

/// A complete pack and the same one cropped, for each codec.
fn packs() -> [(BrdfPack, BrdfPack); 3] {
    let source = source();
    let wavelet = |is_preserving: bool| {
        let recipe = Recipe {
            levels: 4,
            stored_levels: 4,
            energy_preserving: is_preserving,
            measure_off_grid: false,
            ..Recipe::default()
        };
        let whole = brdfc_wavelet::encode::encode(source.as_ref(), &recipe, &()).expect("a pack").pack;
        let cropped = brdfc_wavelet::crop::crop(whole.clone(), DIRECTIONS);
        (BrdfPack::Wavelet(whole), BrdfPack::Wavelet(cropped))
    };
    let recipe = TableRecipe { size: Size::Bytes(16 << 10), factored: true, measure: false, ..TableRecipe::default() };
    let whole = brdfc_table::encode::encode(source.as_ref(), &recipe, &()).expect("a pack").pack;
    let window = brdfc_table::crop::window(whole.header(), DIRECTIONS);
    let cropped = whole.cropped(Crop { directions: DIRECTIONS, window }).expect("within the texture");
    [wavelet(false), wavelet(true), (BrdfPack::Table(whole), BrdfPack::Table(cropped))]
}

fn decoding(slices: SliceFilter) -> Decoding {
    Decoding { filter: Filter::Bilinear, slices, level: None, distance_scale: DEFAULT_DISTANCE_SCALE }
}

fn by_shader(gpu: &Gpu, scene: &Scene, pack: &BrdfPack, slices: SliceFilter) -> LinearImage {
    let renderer = Renderer::new(gpu).expect("a renderer");
    let loaded = renderer.load(scene, &vec![pack; scene.parts.len()], decoding(slices)).expect("loaded");
    renderer.draw(&loaded, &scene.camera, FRAME).expect("drawn")
}

fn by_cpu(scene: &Scene, pack: &BrdfPack) -> LinearImage {
    let reflectance = PackReflectance::new(pack, decoding(SliceFilter::Exact));
    let materials: Vec<_> = scene.parts.iter().map(|_| &reflectance as _).collect();
    shade(scene, FRAME, &trace(scene, FRAME), &materials)
}

fn largest_difference(a: &LinearImage, b: &LinearImage) -> f64 {
    let brightest = b.pixels.iter().flatten().fold(0.0f32, |most, value| most.max(*value));
    assert!(brightest > 0.0, "a black rendering says nothing");
    let differences = a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs());
    f64::from(differences.fold(0.0, f32::max) / brightest)
}

#[test]
fn cropped_and_complete_packs_give_the_same_rendering() {
    let (scene, low) = (floor([0.0, 9.0, 5.0]), floor([0.0, 1.0, 9.0]));
    let ranges = vec![DIRECTIONS; scene.parts.len()];
    let asks_for_more =
        |scene: &Scene| outside(scene, FRAME, &trace(scene, FRAME), &ranges).into_iter().filter(|out| *out).count();
    assert_eq!(asks_for_more(&scene), 0, "the scene is within the range");
    assert!(asks_for_more(&low) > 50, "a low view is outside the range");
    let mut shown = 0;
    for (number, (whole, cropped)) in packs().iter().enumerate() {
        assert!(10 * cropped.gpu_bytes() < 9 * whole.gpu_bytes(), "{number}: the cropped pack is smaller");
        assert!(by_cpu(&scene, cropped) == by_cpu(&scene, whole), "{number}");
        // The control: left-out directions change this view, except for the table, whose ring contains it.
        shown += usize::from(by_cpu(&low, cropped) != by_cpu(&low, whole));
        let Some(gpu) = crate::common::gpu() else { continue };
        let exact = |pack: &BrdfPack| by_shader(gpu, &scene, pack, SliceFilter::Exact);
        assert!(exact(cropped) == exact(whole), "{number}");
        // A sampler rounds its weights differently at other texture coordinates.
        let filtered = |pack: &BrdfPack| by_shader(gpu, &scene, pack, SliceFilter::Hardware);
        let difference = largest_difference(&filtered(cropped), &filtered(whole));
        // Measured with Mesa's software driver: 1.8e-5, 0 and 6e-8. Others may round weights to 1/256 of a texel.
        let bound = if gpu.description().software { 1e-4 } else { 2e-2 };
        assert!(difference < bound, "{number}: {difference}");
    }
    assert!(shown >= 2, "{shown}");
}

#[test]
fn comparisons_leave_out_directions_outside_the_domain_of_packs() {
    let Some(gpu) = crate::common::gpu() else { return };
    let source = source();
    let (_, cropped) = &packs()[2];
    let draw = |scene: &Scene| {
        let material = Material { pack: cropped, source: Some(source.as_ref()), table: None };
        views(gpu, scene, FRAME, &vec![material; scene.parts.len()], decoding(SliceFilter::Exact)).expect("drawn")
    };
    assert_eq!(draw(&floor([0.0, 9.0, 5.0])).left_out, 0.0);
    let low = draw(&floor([0.0, 1.0, 9.0]));
    assert!(low.left_out > 0.9, "{}", low.left_out);
    let covered = |image: &LinearImage| image.coverage.iter().filter(|covered| **covered > 0.0).count();
    let source = low.source.as_ref().expect("there is one");
    assert_eq!([&low.shader, &low.pack].map(covered), [covered(source); 2]);
}
