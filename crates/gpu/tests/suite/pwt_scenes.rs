//! Polynomial wavelet trees on scenes: the shader compared with the CPU, and the CPU with the encoded photographs.

use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_gpu::{draw_pwt, draw_pwt_by, pwt_scene_source};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_pwt::{LightSamples, PwtRecipe, encode};
use brdfc_render::pwt::{Photograph, PwtMaterial, distant_light, draw_on_cpu, draw_photographs, image_scene};
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::scenes::Builtin;
use std::sync::LazyLock;

const FRAME: Frame = Frame { width: 96, height: 64, samples: 2 };
const SIZE: [usize; 2] = [96, 64];

/// A matte relief of two colours under lights all around.
static SAMPLES: LazyLock<LightSamples> = LazyLock::new(|| {
    let ring = |z: f32, count: usize| {
        (0..count).map(move |k| {
            let (sine, cosine) = (std::f32::consts::TAU * k as f32 / count as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * cosine, r * sine, z]
        })
    };
    let lights: Vec<[f32; 3]> = ring(0.95, 6).chain(ring(0.7, 12)).chain(ring(0.35, 14)).collect();
    let rendering = |light: &[f32; 3]| {
        let pixel = |at: usize| {
            let [x, y] = [at % SIZE[0], at / SIZE[0]].map(|k| k as f32 / 16.0 * std::f32::consts::TAU);
            let slope = [0.4 * x.cos() * y.sin(), 0.4 * x.sin() * y.cos()];
            let cosine = (light[2] - slope[0] * light[0] - slope[1] * light[1]).max(0.0);
            let cosine = cosine / (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
            let colour = if (at % SIZE[0]) < 48 { [0.8, 0.3, 0.2] } else { [0.2, 0.4, 0.7] };
            colour.map(|c| c * cosine)
        };
        (0..SIZE[0] * SIZE[1]).map(pixel).collect()
    };
    let images: Vec<Vec<[f32; 3]>> = lights.iter().map(rendering).collect();
    LightSamples::new(SIZE, lights, images)
});

static PACK: LazyLock<PwtPack> = LazyLock::new(|| encode(&SAMPLES, &PwtRecipe::default()).unwrap().pack);

fn material() -> PwtMaterial {
    PwtMaterial::new(PwtDecoder::new(PACK.clone()), 1).unwrap()
}

fn scenes() -> [Scene; 3] {
    let above = image_scene(SIZE, [FRAME.width, FRAME.height]);
    let mut oblique = above.clone();
    oblique.camera = Builtin::Plane.scene().camera;
    oblique.lights.push(distant_light([0.6, -0.3, 0.74]));
    [above, oblique, Builtin::Sphere.scene()]
}

fn mean_delta_e(a: &LinearImage, b: &LinearImage) -> f64 {
    compare_images(a, b, auto_exposure(b)).delta_e.mean
}

#[test]
fn shader_and_cpu_draw_the_same_renderings() {
    let Some(gpu) = crate::common::gpu() else { return };
    let material = material();
    for (number, scene) in scenes().iter().enumerate() {
        let cpu = draw_on_cpu(scene, FRAME, &material);
        let lit = cpu.pixels.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit > FRAME.width * FRAME.height / 5, "{number}: {lit} are lit");
        for (filter, limit) in [(FrameBlock::exact(), 0.15), (FrameBlock::default(), 0.3)] {
            let shader = draw_pwt(gpu, scene, FRAME, &material, filter).unwrap();
            let mean = mean_delta_e(&shader, &cpu);
            println!("scene {number}, {filter:?}: mean ΔE {mean}");
            assert!(mean < limit, "scene {number}, {filter:?}: {mean}");
        }
    }
}

/// Known answer: under the light of a photograph, the pack looks like it.
#[test]
fn a_pack_looks_like_the_photograph_of_its_light() {
    let mut scene = image_scene(SIZE, [FRAME.width, FRAME.height]);
    let material = material();
    let drawn = |light: usize, photograph: usize, scene: &mut Scene| {
        scene.lights = vec![distant_light(SAMPLES.lights[light].map(f64::from))];
        let reference = Photograph::new(SIZE, SAMPLES.images[photograph].clone().into_linear(), false);
        let reference = draw_photographs(scene, FRAME, &[reference], 1);
        mean_delta_e(&draw_on_cpu(scene, FRAME, &material), &reference)
    };
    for light in [0, 8, 20] {
        let [own, other] = [light, (light + 5) % 18].map(|photograph| drawn(light, photograph, &mut scene));
        println!("light {light}: own {own}, other {other}");
        assert!(own < 2.0 && other > 2.0 * own, "light {light}: own {own}, other {other}");
    }
}

/// The negative control: a level that is off by one is detected.
#[test]
fn another_level_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let (material, [_, scene, _]) = (material(), scenes());
    let source = pwt_scene_source();
    let broken = source.replace(
        "let level = pwt_mipmap_level(dpdx(uv), dpdy(uv));",
        "let level = pwt_mipmap_level(dpdx(uv), dpdy(uv)) + 1.0;",
    );
    assert_ne!(source, broken);
    let cpu = draw_on_cpu(&scene, FRAME, &material);
    let off = [source, broken].map(|source| {
        let image = draw_pwt_by(gpu, source, &scene, FRAME, &material, FrameBlock::exact()).unwrap();
        mean_delta_e(&image, &cpu)
    });
    assert!(off[1] > 3.0 * off[0], "{off:?}");
}

#[test]
fn only_tiles_repeat() {
    let wrong = PwtMaterial::new(PwtDecoder::new(PACK.clone()), 2).unwrap_err().to_string();
    assert!(wrong.contains("repeat") && wrong.contains('2') && wrong.contains("no tile"), "{wrong}");
    assert!(PwtMaterial::new(PwtDecoder::new(PACK.clone()), 0).is_err());
}
