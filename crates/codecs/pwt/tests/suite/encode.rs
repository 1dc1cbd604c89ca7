//! Tests whole encodes: errors, sizes and reports.

use super::stacks::{lambert, polynomial, shiny, spiral};
use brdfc_formats::pwt::{LightCoordinates, PwtDecoder, PwtPack};
use brdfc_pwt::measure::{image_errors, stack_errors};
use brdfc_pwt::ptm::{images_of, samples_of, spread_lights};
use brdfc_pwt::{DomainName, LightSamples, PwtEncoded, PwtRecipe, Target, Wavelet, encode};
use brdfc_readers::ptm::Ptm;
use brdfc_testing::packs::Numbers;

fn with(target: Target) -> PwtRecipe {
    PwtRecipe { target, ..PwtRecipe::default() }
}

fn made(samples: &LightSamples, recipe: PwtRecipe) -> PwtEncoded {
    let made = encode(samples, &recipe).unwrap_or_else(|error| panic!("{error}"));
    assert!(
        made.errors.psnr.is_finite() && made.errors.delta_e.is_finite() && made.condition.is_none_or(f64::is_finite)
    );
    let read = PwtPack::from_bytes(&made.pack.to_bytes(true)).unwrap();
    assert_eq!(read, made.pack);
    made
}

/// Known answer: a sum of terms is recovered up to the rounding of its texels, also under unseen lights.
#[test]
fn polynomials_are_recovered() {
    let recipe = PwtRecipe {
        coordinates: Some(LightCoordinates::Projected),
        degree: Some(1),
        ridge: Some(1e-8),
        domain: Some(DomainName::Linear),
        ..with(Target::Quality(45.0))
    };
    let unseen = polynomial([32, 16], spiral(11), true);
    for wavelet in Wavelet::ALL {
        let samples = polynomial([32, 16], spiral(24), true);
        let made = made(&samples, PwtRecipe { wavelet, ..recipe });
        assert!(made.met && made.errors.psnr >= 45.0, "{wavelet:?}: {:?}", made.errors);
        let errors = stack_errors(&PwtDecoder::new(made.pack), &unseen, 1);
        assert!(errors.psnr > 44.0, "{wavelet:?}: {errors:?}");
    }
    // The negative control: without the terms that depend on the light.
    let flat = made(&polynomial([32, 16], spiral(24), true), PwtRecipe { degree: Some(0), ..recipe });
    assert!(!flat.met && flat.errors.psnr < 30.0, "{:?}", flat.errors);
}

#[test]
fn the_default_follows_a_lambertian_relief() {
    let samples = lambert([32, 24], spiral(40), false);
    let made = made(&samples, PwtRecipe::default());
    assert!(made.errors.psnr > 30.0 && made.errors.delta_e < 3.0, "{:?}", made.errors);
    let header = made.pack.header().errors;
    assert_eq!((header.lights, f64::from(header.psnr)), (40, f64::from(made.errors.psnr as f32)));
    let best = made.candidates[0];
    assert!(made.candidates.iter().all(|candidate| candidate.held_out_psnr <= best.held_out_psnr));
    assert_eq!(header.held_out_psnr, best.held_out_psnr.unwrap() as f32);
}

fn learned() -> PwtRecipe {
    PwtRecipe { coordinates: Some(LightCoordinates::Learned), ..PwtRecipe::default() }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let samples = lambert([21, 17], spiral(18), false);
    for recipe in [PwtRecipe::default(), learned()] {
        let bytes = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| encode(&samples, &recipe).unwrap().pack.to_bytes(true))
        };
        assert_eq!(bytes(1), bytes(4));
    }
}

/// On a shiny relief, learned terms are closer than polynomials at fitted and at unseen lights, with fewer fetches; the encoder
/// finds that out. Without highlights polynomials suffice, which is the negative control.
#[test]
fn highlights_are_learned() {
    // Between the fitted lights, not beyond them.
    let between = |light: &[f32; 3]| light[2] > 0.25;
    let (lights, unseen) = (spiral(60), spiral(23).into_iter().filter(between).collect::<Vec<_>>());
    let samples = shiny([160, 160], lights.clone());
    let errors_of =
        |made: &PwtEncoded, unseen: &LightSamples| stack_errors(&PwtDecoder::new(made.pack.clone()), unseen, 1).psnr;
    let default = made(&samples, PwtRecipe::default());
    assert_eq!(default.pack.header().basis.coordinates, LightCoordinates::Learned);
    let bytes = Target::Bytes(2 * default.pack.gpu_bytes());
    let best = made(&samples, with(bytes));
    let header = best.pack.header();
    assert_eq!(header.basis.coordinates, LightCoordinates::Learned);
    let harmonics = PwtRecipe { coordinates: Some(LightCoordinates::Hemisphere), ..with(bytes) };
    let harmonics = made(&samples, harmonics);
    assert!(harmonics.pack.header().fetches() > header.fetches());
    assert!(best.errors.psnr > harmonics.errors.psnr + 1.5, "{:?} {:?}", best.errors, harmonics.errors);
    let unseen_shiny = shiny([160, 160], unseen.clone());
    let [found, other] = [&best, &harmonics].map(|made| errors_of(made, &unseen_shiny));
    assert!(found > other + 0.5, "{found} {other}");
    // Terms that are not needed are not stored, and a requested number is.
    let few = made(&samples, PwtRecipe { degree: Some(5), ..learned() });
    assert_eq!(few.pack.header().basis.degree, 5);
    assert!(few.errors.psnr < best.errors.psnr);
    let plain = made(&polynomial([160, 160], lights, false), learned());
    assert!(plain.pack.header().basis.degree <= 4 && plain.errors.psnr > 40.0, "{:?}", plain.errors);
}

/// Lights that no light can be predicted from: the mean of a few photographs.
#[test]
fn learned_terms_of_poor_lights() {
    let unseen = lambert([24, 24], spiral(23), false);
    for lights in [spiral(1), spiral(2), spiral(3), vec![[0.0, 0.6, 0.8]; 6]] {
        let samples = lambert([24, 24], lights, false);
        let made = made(&samples, learned());
        assert!(made.errors.psnr > 25.0, "{:?}", made.errors);
        let errors = stack_errors(&PwtDecoder::new(made.pack), &unseen, 1);
        let mean = LightSamples { images: vec![samples.at_most(1).images[0].clone(); 23], ..unseen.clone() };
        let expected = image_errors(&mean, &unseen);
        assert!(errors.psnr > expected.psnr - 0.5, "{errors:?} {expected:?}");
    }
}

/// Photographs that have nothing in common but a chequered texture: `noise` per square of `side` texels, channel and light.
fn unpredictable(lights: Vec<[f32; 3]>, side: usize, noise: f32) -> LightSamples {
    const SIZE: usize = 64;
    let mut numbers = Numbers::new(5);
    let mut image = || {
        let squares: Vec<[f32; 3]> =
            (0..SIZE * SIZE).map(|_| [0, 1, 2].map(|_| numbers.between(0.0, 1.0) as f32)).collect();
        let pixel = |at: usize| {
            let (x, y) = (at % SIZE, at / SIZE);
            let texture = if (x + y) % 2 == 0 { 0.06 } else { 0.0 };
            squares[y / side * SIZE + x / side].map(|number| 0.2 + texture + noise * number)
        };
        (0..SIZE * SIZE).map(pixel).collect::<Vec<_>>()
    };
    let images: Vec<_> = lights.iter().map(|_| image()).collect();
    LightSamples::new([SIZE; 2], lights, images)
}

/// With few lights, errors at the lights count, and not those of predictions.
#[test]
fn few_lights_are_shown_as_they_are() {
    for lights in [spiral(2), spiral(3), spiral(4), spiral(5)] {
        let made = made(&lambert([160, 160], lights, false), PwtRecipe::default());
        assert!(made.errors.psnr > 40.0, "{:?}", made.errors);
    }
}

/// Squared errors of huge values are infinite as 32-bit floats.
#[test]
fn huge_values_have_errors() {
    let mut samples = shiny([64, 64], spiral(12));
    samples.images[3].to_mut()[100] = [1e25; 3];
    for target in [Target::Bytes(1024), Target::Quality(30.0), Target::Loss(0.0)] {
        let made = encode(&samples, &PwtRecipe { domain: Some(DomainName::Linear), target, ..learned() }).unwrap();
        assert!(made.errors.psnr.is_finite());
        // Terms begin at the finest level if nothing may be lost.
        assert!(target != Target::Loss(0.0) || made.pack.header().textures[0].level == 0);
    }
}

/// Highlights that nothing predicts do not blur the rest: most of the finest detail is stored without a target.
#[test]
fn detail_remains_where_highlights_are_not_predicted() {
    let samples = unpredictable(spiral(40), 8, 0.7);
    let finest = |loss: f64| {
        let made = made(&samples, PwtRecipe { target: Target::Loss(loss), ..learned() });
        made.pack.header().textures[0].level
    };
    // A large loss is the negative control.
    assert_eq!((finest(0.3), finest(30.0) > 0), (0, true));
}

/// Learned terms of many lights are those of averaged photographs, and what is dropped is no more than requested.
#[test]
fn many_lights_are_averaged() {
    let samples = shiny([48, 48], spiral(1500));
    let [whole, less] = [0.0, 2.0].map(|loss| made(&samples, PwtRecipe { target: Target::Loss(loss), ..learned() }));
    assert_eq!(less.pack.header().errors.lights, 1500);
    let [least, left] = [&whole, &less].map(|made| 10f64.powf(-made.errors.psnr / 10.0));
    let unseen = 10f64.powf(-less.candidates[0].held_out_psnr.unwrap() / 10.0);
    assert!(left - least < 1.1 * (10f64.powf(0.2) - 1.0) * unseen, "{least} {left} {unseen}");
    assert!(less.pack.gpu_bytes() < whole.pack.gpu_bytes());
}

#[test]
fn byte_limits_hold_and_larger_ones_are_not_worse() {
    let samples = lambert([32, 32], spiral(30), true);
    let mut before = 0.0f64;
    let mut reached = Vec::new();
    for bytes in [1, 100, 400, 1000, 3000, 10_000, 100_000] {
        let made = made(&samples, with(Target::Bytes(bytes)));
        assert!(made.met && made.pack.gpu_bytes() <= bytes, "{bytes}: {}", made.pack.gpu_bytes());
        assert!(made.errors.psnr > before - 0.3, "{bytes}: {} after {before}", made.errors.psnr);
        before = made.errors.psnr;
        reached.push(before);
    }
    assert!(reached[6] > reached[1] + 5.0, "{reached:?}");
}

#[test]
fn measured_targets_are_met_or_reported() {
    let samples = lambert([32, 32], spiral(30), true);
    let small = made(&samples, with(Target::Quality(24.0)));
    let large = made(&samples, with(Target::Quality(28.0)));
    assert!(small.met && small.errors.psnr >= 24.0 && large.met && large.errors.psnr >= 28.0);
    assert!(small.pack.gpu_bytes() < large.pack.gpu_bytes());
    let seen = made(&samples, with(Target::DeltaE(4.0)));
    assert!(seen.met && seen.errors.delta_e <= 4.0, "{:?}", seen.errors);
    for target in [Target::Quality(200.0), Target::DeltaE(0.0)] {
        let missed = made(&samples, with(target));
        assert!(!missed.met && missed.errors.psnr > large.errors.psnr, "{target:?}: {:?}", missed.errors);
    }
    let [little, much] = [0.9, 0.999].map(|share| made(&samples, with(Target::Energy(share))));
    assert!(little.pack.gpu_bytes() < much.pack.gpu_bytes() && little.errors.psnr < much.errors.psnr);
    let [far, near] = [3.0, 0.05].map(|loss| made(&samples, with(Target::Loss(loss))));
    assert!(far.pack.gpu_bytes() < near.pack.gpu_bytes() && far.errors.psnr < near.errors.psnr);
}

/// Fewer lights than terms, collinear, equal, and single lights: undetermined components are smooth, determined ones
/// are fitted.
#[test]
fn poor_lights() {
    let line = (1..10).map(|k| k as f32 / 10.0).map(|x| [x, 0.0, (1.0 - x * x).sqrt()]);
    for (lights, least) in
        [(spiral(4), 25.0), (line.collect(), 25.0), (vec![[0.0, 0.6, 0.8]; 6], 30.0), (vec![[0.0, 0.0, 1.0]], 30.0)]
    {
        let count = lights.len();
        for degree in [None, Some(5)] {
            let recipe = PwtRecipe { degree, ..with(Target::Quality(60.0)) };
            let made = made(&polynomial([16, 16], lights.clone(), false), recipe);
            assert!(made.errors.psnr > least, "{count} lights, {degree:?}: {:?}", made.errors);
            // Values under an unseen light stay in range.
            let value = PwtDecoder::new(made.pack).value([0.3, 0.6], 0.0, [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]);
            assert!(value.iter().all(|c| (0.0..4.0).contains(c)), "{count} lights, {degree:?}: {value:?}");
        }
    }
}

/// Few lights are not overfitted: at unseen lights the pack is about as good as a constant one, and it does not
/// overstate its quality.
#[test]
fn few_lights_are_not_overfitted() {
    let unseen = lambert([24, 24], spiral(23), false);
    for count in [1, 2, 3, 4, 6, 8] {
        let samples = lambert([24, 24], spiral(count), false);
        let of = |degree| {
            let made = made(&samples, PwtRecipe { degree, ..PwtRecipe::default() });
            let errors = stack_errors(&PwtDecoder::new(made.pack), &unseen, 1);
            (made.candidates[0], errors.psnr)
        };
        let (candidate, psnr) = of(None);
        let (_, constant) = of(Some(0));
        assert!(psnr > constant - 2.0, "{count} lights: {psnr} against {constant}, {candidate:?}");
        assert_eq!(candidate.held_out_psnr.is_none(), count == 1, "{candidate:?}");
        assert!(candidate.held_out_psnr.is_none_or(|p| p < psnr + 8.0), "{count} lights: {psnr}, {candidate:?}");
    }
}

/// The polynomials of a polynomial texture map are recovered, also where they are above white and below black.
#[test]
fn maps_that_clip() {
    let coefficients = [[-80.0, -80.0, 0.0, 400.0, 60.0, 60.0], [10.0, 0.0, 30.0, -200.0, 90.0, 120.0], [0.0; 6]];
    let map = Ptm::from_coefficients_rgb([16, 16], &[coefficients; 256]).unwrap();
    let samples = samples_of(&map, spread_lights(96));
    let recipe = PwtRecipe {
        coordinates: Some(LightCoordinates::Projected),
        degree: Some(2),
        domain: Some(DomainName::Display),
        ridge: Some(1e-9),
        ..PwtRecipe::default()
    };
    let decoder = PwtDecoder::new(made(&samples, recipe).pack);
    let clamped_renderings = images_of(&map, spiral(30));
    let errors = stack_errors(&decoder, &clamped_renderings, 1);
    assert!(errors.psnr > 38.0, "{errors:?}");
    let codes = clamped_renderings.images.iter().flat_map(|image| image.linear(0..image.len()).into_owned()).flatten();
    assert!(codes.clone().any(|c| c >= 1.0) && codes.clone().any(|c| c <= 0.0), "it clips at both ends");
    // The negative control: clamped values are no polynomial.
    let clamped = images_of(&map, spread_lights(96));
    let wrong = stack_errors(&PwtDecoder::new(made(&clamped, recipe).pack), &clamped_renderings, 1);
    assert!(wrong.psnr < errors.psnr - 10.0, "{wrong:?}");
}

#[test]
fn sizes_of_all_kinds() {
    for (size, repeats, levels, extent) in [
        ([1, 1], false, 0, [1, 1]),
        ([1, 1], true, 0, [1, 1]),
        ([1, 9], false, 0, [1, 9]),
        ([7, 5], false, 2, [8, 8]),
        ([7, 5], true, 0, [7, 5]),
        ([12, 8], true, 2, [12, 8]),
        ([33, 40], false, 5, [64, 64]),
    ] {
        let samples = polynomial(size, spiral(12), repeats);
        let made = made(&samples, with(Target::Quality(35.0)));
        let header = made.pack.header();
        assert_eq!((header.levels, header.extent, header.repeats), (levels, extent, repeats), "{size:?}");
        assert!(made.met, "{size:?}: {:?}", made.errors);
    }
}

/// A black RTI capture, and one of a single colour.
#[test]
fn stacks_without_detail() {
    for value in [0.0, 0.25] {
        let mut samples = polynomial([8, 8], spiral(9), false);
        samples.images.iter_mut().for_each(|image| image.to_mut().fill([value; 3]));
        let made = made(&samples, with(Target::Quality(40.0)));
        assert!(made.met && made.pack.gpu_bytes() <= 8 * 64, "{value}: {:?}", made.errors);
    }
    // Values out of range do not cause a panic.
    let mut samples = polynomial([4, 4], spiral(9), false);
    samples.images[2].to_mut()[5] = [3e38, -3e38, 0.0];
    for domain in DomainName::ALL {
        let recipe = PwtRecipe { domain: Some(domain), ..PwtRecipe::default() };
        match encode(&samples, &recipe) {
            Ok(made) => assert!(made.errors.psnr.is_finite()),
            Err(error) => assert!(error.field.starts_with("brdfc.pwt"), "{error}"),
        }
    }
}

#[test]
fn values_out_of_range_are_named() {
    let good = polynomial([4, 4], spiral(3), true);
    let said = |samples: &LightSamples, recipe: PwtRecipe| encode(samples, &recipe).unwrap_err().to_string();
    let default = PwtRecipe::default();
    for (recipe, expected) in [
        (PwtRecipe { degree: Some(6), ..default }, "degree: found 6, expected 0 to 5"),
        (PwtRecipe { ridge: Some(f64::NAN), ..default }, "ridge: found NaN, expected 0 to 1000000"),
        (PwtRecipe { depth: Some(9), ..default }, "levels: found 9, expected 0 to 8"),
        (
            PwtRecipe { depth: Some(3), ..default },
            "levels: found 3, expected 0 to 2 for 4 x 4, because the sides of a tile are halved exactly",
        ),
        (PwtRecipe { packets: 5, ..default }, "packets: found 5, expected 0 to 4"),
        (with(Target::Bytes(0)), "bytes: found 0, expected 1 to 1000000000000"),
        (with(Target::Energy(1.5)), "energy: found 1.5, expected 0 to 1"),
        (with(Target::Quality(f64::NAN)), "quality: found NaN, expected 0 to 200"),
    ] {
        assert_eq!(said(&good, recipe), expected);
    }
    let changed = |change: fn(&mut LightSamples)| {
        let mut samples = good.clone();
        change(&mut samples);
        said(&samples, default)
    };
    assert_eq!(changed(|s| (s.lights, s.images) = Default::default()), "lights: found 0, expected 1 to 4096");
    assert_eq!(changed(|s| s.lights[1][2] = -0.5).split(':').next(), Some("light 1"));
    assert_eq!(changed(|s| s.images.truncate(2)), "images: found 2, expected 3, one per light");
    assert_eq!(changed(|s| s.images[2].to_mut().truncate(15)), "image 2: found 15 pixels, expected 4 x 4");
    assert!(changed(|s| s.images[0].to_mut()[6][1] = f32::NAN).starts_with("image 0: found ["));
    assert!(changed(|s| s.size = [0, 4]).starts_with("size: found 0 x 4"));
}
