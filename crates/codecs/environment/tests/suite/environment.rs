//! Known answers of convolutions, errors, determinism.

use brdfc_core::progress::{Cancelled, Progress};
use brdfc_environment::training::{KINDS, TrainingEnvironment};
use brdfc_environment::{PrefilterError, default_side, prefilter};
use brdfc_formats::direction::{Vector, dot, normalize};
use brdfc_formats::environment::cube::FacePoint;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader, EnvironmentPack};
use std::f64::consts::TAU;

fn prefiltered(side: u32, samples: usize, radiance: impl Fn(Vector) -> Vector + Sync) -> EnvironmentPack {
    prefilter(&radiance, side, samples, &()).unwrap()
}

/// Unit vectors to the texels of a level, with their radiance.
fn texels(pack: &EnvironmentPack, level: u32) -> Vec<(Vector, [f32; 3])> {
    placed((pack.header().side >> level) as usize, pack.level(level))
}

/// Unit vectors to texels.
fn placed(side: usize, texels: impl Iterator<Item = [f32; 3]>) -> Vec<(Vector, [f32; 3])> {
    let with_direction = |(at, texel): (usize, [f32; 3])| {
        let centre = [at % side, at / side % side].map(|place| place as f64 + 0.5);
        (normalize(FacePoint::on_grid(at / (side * side), side, centre).direction()), texel)
    };
    texels.enumerate().map(with_direction).collect()
}

#[test]
fn constant_environments_stay_constant() {
    for side in [8, 64] {
        let decoder = EnvironmentDecoder::new(&prefiltered(side, 1, |_| [1.0, 0.5, 2.0]));
        for at in 0..1000 {
            let (y, turn) = (1.0 - 2.0 * (f64::from(at) + 0.5) / 1000.0, f64::from(at) * 2.4);
            let direction = [turn.cos(), y, turn.sin()].map(|c| c as f32);
            let found = decoder.radiance(direction, at as f32 * 0.007 - 1.0);
            assert!((0..3).all(|k| (found[k] - [1.0, 0.5, 2.0][k]).abs() < 1e-6), "{direction:?}: {found:?}");
        }
    }
}

/// A surface that is tilted by θ out of a uniformly bright half space receives (1 + cos θ) / 2 of its light.
#[test]
fn half_of_the_sphere_gives_its_known_irradiance() {
    let pack = prefiltered(64, 4, |[_, y, _]| [f64::from(y > 0.0), 1.0, f64::from(y < 0.0)]);
    let irradiance = placed(16, pack.irradiance());
    assert_eq!(irradiance.len(), 1536);
    for (direction, found) in irradiance {
        let expected = [0.5 + 0.5 * direction[1], 1.0, 0.5 - 0.5 * direction[1]];
        let most = (0..3).map(|k| (f64::from(found[k]) - expected[k]).abs()).fold(0.0, f64::max);
        assert!(most < 5e-3, "{direction:?}: {found:?} {expected:?}");
    }
}

/// A soft light becomes a light with the variances of both.
#[test]
fn a_soft_light_is_widened_by_the_kernel() {
    const OWN: f64 = 0.15 * 0.15;
    let towards = normalize([0.9, 0.35, -0.5]);
    let pack = prefiltered(64, 4, |direction| [((dot(normalize(direction), towards) - 1.0) / OWN).exp(); 3]);
    let flux = |variance: f64| TAU * variance * (1.0 - (-2.0 / variance).exp());
    for level in 1..pack.header().levels() {
        let deviation = EnvironmentHeader::deviation(f64::from(pack.header().sharpest() - level));
        let variance = deviation * deviation + OWN;
        let peak = flux(OWN) / flux(variance);
        let [mut largest, mut worst, mut wrong] = [0.0f64; 3];
        for (direction, found) in texels(&pack, level) {
            let cosine = dot(direction, towards);
            let expected = |variance: f64| peak * ((cosine - 1.0) / variance).exp();
            let found = f64::from(found[1]);
            largest = largest.max(found);
            worst = worst.max((found - expected(variance)).abs() / peak);
            wrong = wrong.max((found - expected(1.2 * variance)).abs() / peak);
        }
        println!("level {level}: largest {largest:.4}, peak {peak:.4}, error {worst:.4}, control {wrong:.4}");
        assert!(worst < 0.01 && wrong > 0.06, "level {level}: {worst} {wrong}");
    }
}

#[test]
fn the_finest_level_is_not_filtered() {
    let pack = prefiltered(16, 2, |direction| normalize(direction).map(|c| 1.0 + c));
    for (direction, found) in texels(&pack, 0) {
        for k in 0..3 {
            assert!((f64::from(found[k]) - 1.0 - direction[k]).abs() < 0.01, "{direction:?}: {found:?}");
        }
    }
}

#[test]
fn training_environments_are_valid_and_differ() {
    let mut means = Vec::new();
    for seed in 0..2 * KINDS {
        let environment = TrainingEnvironment::new(seed);
        let again = TrainingEnvironment::new(seed);
        assert_eq!(environment.radiance([0.1, 0.2, -0.3]), again.radiance([0.1, 0.2, -0.3]));
        let pack = prefiltered(8, 4, |direction| environment.radiance(direction));
        let mean = pack.irradiance().map(|texel| texel[1]).sum::<f32>() / 1536.0;
        assert!(mean > 0.01 && mean < 100.0, "{seed}: {mean}");
        means.push(mean);
    }
    means.sort_by(f32::total_cmp);
    means.dedup();
    assert_eq!(means.len() as u64, 2 * KINDS);
}

#[test]
fn invalid_input_is_rejected() {
    let error = |side: u32, radiance: f64| {
        prefilter(&|[_, y, _]| [1.0, if y > 0.0 { radiance } else { 1.0 }, 1.0], side, 1, &()).unwrap_err().to_string()
    };
    for side in [0, 4, 12, 4096] {
        let expected = format!("brdfc.environment side: found {side}, expected a power of two, 8 to 2048");
        assert_eq!(error(side, 1.0), expected);
    }
    for radiance in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
        let text = error(8, radiance);
        assert!(text.starts_with("environment texel: found ["), "{text}");
        assert!(text.ends_with("expected finite values of 0 or more"), "{text}");
    }
    struct Stopped;
    impl Progress for Stopped {
        fn check(&self) -> Result<(), Cancelled> {
            Err(Cancelled)
        }
        fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
            Box::new(())
        }
    }
    assert!(matches!(prefilter(&|_| [1.0; 3], 8, 1, &Stopped), Err(PrefilterError::Cancelled(_))));
}

#[test]
fn default_sides_follow_the_width_of_images() {
    for (width, side) in
        [(1, 64), (100, 64), (129, 64), (130, 128), (512, 256), (1024, 512), (16384, 512), (usize::MAX / 4, 512)]
    {
        assert_eq!(default_side(width), side, "{width}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let environment = TrainingEnvironment::new(3);
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| prefiltered(32, 2, |direction| environment.radiance(direction)).to_bytes(true))
    };
    let one = bytes(1);
    assert_eq!(one, bytes(2));
    assert_eq!(EnvironmentPack::from_bytes(&one).unwrap().to_bytes(true), one);
}

/// A small sun in a room brings the same light at all levels.
#[test]
fn all_levels_have_the_same_mean() {
    let sun = normalize([0.3, 0.8, -0.4]);
    let pack =
        prefiltered(64, 4, |direction| [0.1 + if dot(normalize(direction), sun) > 0.9995 { 1e5 } else { 0.0 }; 3]);
    let mean = |texels: Vec<(Vector, [f32; 3])>| {
        let (mut sum, mut total) = (0.0, 0.0);
        for (direction, texel) in texels {
            // Texels near corners cover smaller solid angles.
            let weight = direction.map(f64::abs).into_iter().fold(0.0, f64::max).powi(3);
            sum += weight * f64::from(texel[0]);
            total += weight;
        }
        sum / total
    };
    // The finest level samples the border of the sun.
    let finest = mean(texels(&pack, 0));
    let expected = 0.1 + 1e5 * 0.5 * (1.0 - 0.9995);
    assert!((finest / expected - 1.0).abs() < 0.03, "{finest} {expected}");
    for level in 1..pack.header().levels() {
        let found = mean(texels(&pack, level));
        println!("level {level}: {found}, finest {finest}");
        assert!((found / finest - 1.0).abs() < 5e-3, "level {level}: {found} {finest}");
    }
    let irradiance = mean(placed(16, pack.irradiance()));
    println!("irradiance: {irradiance}");
    assert!((irradiance / finest - 1.0).abs() < 5e-3, "{irradiance} {finest}");
}
