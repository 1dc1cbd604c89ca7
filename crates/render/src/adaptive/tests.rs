//! Known answers of adaptive shading, and the samples that it saves.

use super::*;
use crate::mipmaps::Mipmaps;
use crate::scene::{Environment, Scene};
use crate::scenes::Builtin;
use crate::shade::SourceReflectance;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::{environment_map, texture_map};
use brdfc_bandwidth::texture::Placement;
use brdfc_core::Source;
use brdfc_core::address::parse_synth;
use brdfc_environment::prefilter;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_metrics::image::{luminance, signal_to_noise};
use std::f64::consts::{PI, TAU};

struct Prepared {
    source: Box<dyn Source>,
    lookups: Lookups,
    light: DistantLight,
    scene: Scene,
}

/// A scene of one material in an environment.
fn prepared(address: &str, builtin: Builtin, environment: Environment) -> Prepared {
    let source = parse_synth(address).unwrap();
    let lookups = Lookups::new(source.as_ref()).unwrap();
    let map = environment_map(&environment.pixels, environment.width, DEFAULT_EPSILON).unwrap();
    let light = DistantLight::new(&environment, map);
    Prepared { source, lookups, light, scene: Scene { environment, ..builtin.scene() } }
}

impl Prepared {
    fn with<T>(&self, run: impl FnOnce(&AdaptiveScene<'_>) -> T) -> T {
        let reflectance = SourceReflectance(self.source.as_ref());
        let material = self.lookups.material(&reflectance);
        let materials = vec![material; self.scene.parts.len()];
        run(&AdaptiveScene { scene: &self.scene, light: &self.light, materials: &materials })
    }

    fn buffer(&self, frame: Frame) -> GBuffer {
        GBuffer::new(&self.scene, frame)
    }

    fn truth(&self, scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, samples: usize) -> LinearImage {
        ground_truth(
            scene,
            frame,
            buffer,
            &vec![&self.lookups.distributions; self.scene.parts.len()],
            samples,
            Start::Scattered,
        )
        .image
    }
}

fn environment(radiance: impl Fn(f64, f64) -> f64) -> Environment {
    let (width, height) = (128, 64);
    let pixel = |index: usize| {
        let theta = PI * ((index / width) as f64 + 0.5) / height as f64;
        let phi = TAU * ((index % width) as f64 + 0.5) / width as f64;
        [radiance(theta, phi) as f32; 3]
    };
    Environment { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Bright windows on a grey wall.
fn windows() -> Environment {
    environment(|theta, phi| 0.4 + if theta.cos() > 0.2 && (5.0 * phi).sin() > 0.6 { 4.0 } else { 0.0 })
}

const FRAME: Frame = Frame { width: 96, height: 96, samples: 1 };

#[test]
fn in_a_furnace_nothing_varies_and_few_pixels_are_shaded() {
    let prepared = prepared("synth:lambert?kd=0.6", Builtin::Sphere, environment(|_, _| 1.0));
    let buffer = prepared.buffer(FRAME);
    prepared.with(|scene| {
        let rendering = draw(scene, FRAME, &buffer, &Settings::default());
        let surface: Vec<usize> = (0..buffer.part.len()).filter(|pixel| buffer.part_at(*pixel).is_some()).collect();
        assert!(surface.iter().all(|pixel| rendering.prediction.bandwidth[*pixel] == 0.0));
        assert!(rendering.shaded() < 8, "{:?}", rendering.levels);
        let furthest = surface.iter().map(|pixel| (rendering.image.pixels[*pixel][1] - 0.6).abs()).fold(0.0, f32::max);
        assert!(furthest < 0.06, "{furthest}");
        let background = (0..buffer.part.len()).find(|pixel| buffer.part_at(*pixel).is_none()).unwrap();
        assert_eq!(rendering.image.pixels[background], [0.0; 3]);
    });
}

#[test]
fn with_every_pixel_at_the_finest_level_it_is_the_forward_renderer() {
    let prepared = prepared("synth:ggx?alpha=0.3", Builtin::BumpyBall, windows());
    let buffer = prepared.buffer(FRAME);
    prepared.with(|scene| {
        let settings = Settings { caution: 1e6, fewest: 9, most: 9, ..Settings::default() };
        let rendering = draw(scene, FRAME, &buffer, &settings);
        assert_eq!(rendering.image, forward(scene, FRAME, &buffer, 9));
        let surface = buffer.part.iter().filter(|part| **part != u32::MAX).count() as u64;
        assert_eq!((rendering.shaded(), rendering.samples()), (surface, 9 * surface));
    });
}

/// The same error for a fraction of the samples, and a larger error if predictions are ignored.
#[test]
fn a_fraction_of_the_samples_gives_the_same_error() {
    let prepared = prepared("synth:ggx?alpha=0.3", Builtin::BumpyBall, windows());
    let buffer = prepared.buffer(FRAME);
    prepared.with(|scene| {
        let truth = prepared.truth(scene, FRAME, &buffer, 512);
        let psnr = |image: &LinearImage| signal_to_noise(image, &truth, 1.0).psnr.unwrap();
        let rendering = draw(scene, FRAME, &buffer, &Settings { samples: 64.0, ..Settings::default() });
        let surface = buffer.part.iter().filter(|part| **part != u32::MAX).count() as f64;
        let each = rendering.samples() as f64 / surface;
        let ours = psnr(&rendering.image);
        let forward = |count: f64| psnr(&forward(scene, FRAME, &buffer, count.ceil() as u32));
        assert!(ours > forward(2.0 * each), "{ours} dB with {each} samples, {} forward", forward(2.0 * each));
        // The control: levels far too coarse.
        let careless = draw(scene, FRAME, &buffer, &Settings { samples: 64.0, caution: 1e-3, ..Settings::default() });
        assert!(psnr(&careless.image) < ours - 1.0, "{} {ours}", psnr(&careless.image));
    });
}

/// A checkerboard of 8 x 8 squares of 16 texels.
fn checkerboard() -> Vec<[f32; 3]> {
    (0..128 * 128).map(|i| if (i / 16 + i / (128 * 16)) % 2 == 0 { [0.9, 0.8, 0.7] } else { [0.1, 0.2, 0.1] }).collect()
}

/// A matte ball: the texture alone decides where pixels are shaded. The control is the same texture with a bandwidth of 0.
#[test]
fn the_bandwidth_of_a_texture_keeps_its_edges() {
    let prepared = prepared("synth:lambert?kd=0.7", Builtin::Sphere, windows());
    let buffer = prepared.buffer(FRAME);
    let placement = Placement { metres: [0.5; 2], tiles: true };
    let map = texture_map(&checkerboard(), 128, placement, DEFAULT_EPSILON).unwrap();
    let none = BandwidthMap::new(*map.header(), map.size(), &vec![0.0; map.values().len()]).unwrap();
    let colours = Mipmaps::new(128, checkerboard());
    let repeats = repeats(&prepared.scene.parts[0].mesh, [4.0; 2]).unwrap();
    prepared.with(|scene| {
        let textured = |bandwidth| {
            let texture = Some(PartTexture { colours: &colours, bandwidth, repeats });
            let materials: Vec<_> =
                scene.materials.iter().map(|material| AdaptiveMaterial { texture, ..*material }).collect();
            let scene = AdaptiveScene { materials: &materials, ..*scene };
            let truth = prepared.truth(&scene, FRAME, &buffer, 256);
            let rendering = draw(&scene, FRAME, &buffer, &Settings { samples: 64.0, ..Settings::default() });
            (signal_to_noise(&rendering.image, &truth, 1.0).psnr.unwrap(), rendering.shaded())
        };
        let (with, without) = (textured(&map), textured(&none));
        assert!(with.0 > without.0 + 6.0 && with.1 > 2 * without.1, "{with:?} {without:?}");
    });
}

/// In constant light, a matte surface with a texture of one colour is that colour, without any bandwidth.
#[test]
fn a_texture_of_one_colour_multiplies_the_material() {
    let prepared = prepared("synth:lambert?kd=0.6", Builtin::Sphere, environment(|_, _| 1.0));
    let buffer = prepared.buffer(FRAME);
    let colour = [0.5f32, 0.25, 1.0];
    let placement = Placement { metres: [0.5; 2], tiles: true };
    let map = texture_map(&[colour; 12], 4, placement, DEFAULT_EPSILON).unwrap();
    let colours = Mipmaps::new(4, vec![colour; 12]);
    prepared.with(|scene| {
        let texture = Some(PartTexture { colours: &colours, bandwidth: &map, repeats: [3.0, 2.0] });
        let materials: Vec<_> =
            scene.materials.iter().map(|material| AdaptiveMaterial { texture, ..*material }).collect();
        let textured = AdaptiveScene { materials: &materials, ..*scene };
        let [plain, tinted] = [scene, &textured].map(|scene| draw(scene, FRAME, &buffer, &Settings::default()));
        assert_eq!(plain.prediction.level, tinted.prediction.level);
        let [plain, tinted] = [scene, &textured].map(|scene| forward(scene, FRAME, &buffer, 4));
        for (a, b) in plain.pixels.iter().zip(&tinted.pixels) {
            (0..3).for_each(|k| assert!((a[k] * colour[k] - b[k]).abs() < 1e-6, "{a:?} {b:?}"));
        }
    });
}

#[test]
fn antialiasing_shades_few_pixels_more_than_once() {
    let prepared = prepared("synth:lambert?kd=0.7", Builtin::BumpyBall, windows());
    let counts: Vec<(u64, usize)> = (0..2)
        .map(|levels| {
            let buffer = prepared.buffer(Frame { samples: 1 << levels, ..FRAME });
            prepared.with(|scene| {
                let settings = Settings { antialiasing_levels: levels, ..Settings::default() };
                let rendering = draw(scene, FRAME, &buffer, &settings);
                let partly = rendering.image.coverage.iter().filter(|c| **c > 0.0 && **c < 1.0).count();
                (rendering.shaded(), partly)
            })
        })
        .collect();
    assert!(counts[0].1 == 0 && counts[1].1 > 50, "{counts:?}");
    // Four times the points, shaded points to the power of 0.7 at most.
    assert!((counts[1].0 as f64) < 4f64.powf(0.7) * counts[0].0 as f64, "{counts:?}");
}

#[test]
fn threads_do_not_matter() {
    let prepared = prepared("synth:ggx?alpha=0.3", Builtin::BumpyBall, windows());
    let frame = Frame { width: 48, height: 48, samples: 1 };
    let buffer = prepared.buffer(frame);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| prepared.with(|scene| draw(scene, frame, &buffer, &Settings::default())))
    };
    assert_eq!(run(1), run(3));
}

/// Prefiltered light of an environment, on faces with twice its texels.
fn prefiltered(environment: &Environment) -> EnvironmentDecoder {
    EnvironmentDecoder::new(&prefilter(&|direction| environment.at(direction), 64, 2, &()).unwrap())
}

/// Mean squared difference of luminances on surfaces.
fn variance(image: &LinearImage, truth: &LinearImage) -> f64 {
    let differences = image.pixels.iter().zip(&truth.pixels).map(|(a, b)| (luminance(*a) - luminance(*b)).powi(2));
    differences.sum::<f64>() / image.coverage.iter().filter(|c| **c > 0.0).count() as f64
}

#[test]
fn filtered_samples_in_constant_light_are_samples() {
    let prepared = prepared("synth:ggx?alpha=0.3", Builtin::Sphere, environment(|_, _| 1.0));
    let buffer = prepared.buffer(FRAME);
    let decoder = prefiltered(&prepared.scene.environment);
    let light = FilteredLight { environment: &decoder, scattered: true };
    let shared = FilteredLight { scattered: false, ..light };
    prepared.with(|scene| {
        let surface = (0..buffer.part.len()).filter(|point| buffer.part_at(*point).is_some());
        let mut differ = 0;
        for point in surface.step_by(37) {
            let [samples, filtered, other] = [
                shade_point(scene, &buffer, point, 5),
                shade_point_filtered(scene, &light, &buffer, point, 5),
                shade_point_filtered(scene, &shared, &buffer, point, 5),
            ];
            assert!((samples[1] / filtered[1] - 1.0).abs() < 1e-3, "{samples:?} {filtered:?}");
            // The control: other samples have other weights.
            differ += usize::from((samples[1] / other[1] - 1.0).abs() > 1e-2);
        }
        assert!(differ > 20, "{differ}");
    });
}

/// Filtering replaces most of the noise of few samples by a bias, which many samples do not have.
#[test]
fn filtered_samples_have_less_noise() {
    let prepared = prepared("synth:ggx?alpha=0.3", Builtin::BumpyBall, windows());
    let buffer = prepared.buffer(FRAME);
    let decoder = prefiltered(&prepared.scene.environment);
    let light = FilteredLight { environment: &decoder, scattered: true };
    prepared.with(|scene| {
        let truth = prepared.truth(scene, FRAME, &buffer, 256);
        let filtered = |count: u32| {
            let shader = |point: usize, count: u32| shade_point_filtered(scene, &light, &buffer, point, count);
            let shaded = shade_with(&buffer, &Prediction::uniform(&buffer, 0, count), count, &shader);
            variance(&resolve(scene.scene, FRAME, &buffer, &shaded.radiance, 1), &truth)
        };
        let [few, many] =
            [4, 256].map(|count| [variance(&forward(scene, FRAME, &buffer, count), &truth), filtered(count)]);
        assert!(few[1] < 0.4 * few[0], "{few:?}");
        assert!(many[1] < 0.1 * few[1], "{many:?} {few:?}");
    });
}

#[test]
fn solid_angles_choose_the_sharpness() {
    let decoder = prefiltered(&environment(|_, _| 1.0));
    let light = FilteredLight { environment: &decoder, scattered: true };
    // Four times the solid angle is one level.
    let [fine, coarse] = [1e-3, 4e-3].map(|solid_angle| light.sharpness(solid_angle));
    assert!((fine - coarse - 1.0).abs() < 1e-4, "{fine} {coarse}");
    // The whole sphere has the widest Gaussian, not the irradiance.
    assert_eq!(light.sharpness(4.0 * PI as f32), 1.0);
}

#[test]
fn uniform_predictions_shade_a_quarter_and_a_sixteenth() {
    let prepared = prepared("synth:ggx?kd=0&f0=0.9&alpha=0.1", Builtin::BumpyBall, windows());
    let buffer = prepared.buffer(FRAME);
    let surface = buffer.part.iter().filter(|part| **part != u32::MAX).count() as f64;
    prepared.with(|scene| {
        let truth = prepared.truth(scene, FRAME, &buffer, 256);
        let psnrs = [0, 1, 2].map(|level| {
            let shader = |point: usize, count: u32| shade_point(scene, &buffer, point, count);
            let shaded = shade_with(&buffer, &Prediction::uniform(&buffer, level, 256), 256, &shader);
            let samples: u64 = shaded.levels.iter().map(|level| level.samples).sum();
            let share = samples as f64 / 256.0 / surface;
            // Pixels at the rim have no coarser neighbour on the surface, and are shaded themselves.
            let expected = 0.25f64.powi(level);
            assert!(share >= 0.98 * expected && share < 1.2 * expected + 0.03, "{level}: {share}");
            let image = resolve(scene.scene, FRAME, &buffer, &shaded.radiance, 1);
            signal_to_noise(&image, &truth, 1.0).psnr.unwrap()
        });
        assert!(psnrs[0] > psnrs[1] + 3.0 && psnrs[1] > psnrs[2] + 1.0 && psnrs[2] > 15.0, "{psnrs:?}");
    });
}
