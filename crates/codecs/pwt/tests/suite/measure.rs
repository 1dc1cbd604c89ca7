//! Tests measurements against known errors.

use super::stacks::{lambert, polynomial, spiral};
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, PwtDecoder, PwtHeader, PwtPack};
use brdfc_pwt::measure::stack_errors;
use brdfc_pwt::{LightSamples, PwtRecipe, encode};
use brdfc_testing::codecs::pwt::{plain, single};

/// A grey pack of one value, given by its sRGB encoding, 0 to 1.
fn grey(code: f32) -> PwtDecoder {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 0 };
    let header = PwtHeader {
        domain: Domain::Display,
        textures: vec![single(0, 0, 0.0, code)],
        ..plain([4, 3], [4, 3], 0, basis)
    };
    PwtDecoder::new(PwtPack::new(header, vec![vec![0; 12]]).unwrap())
}

fn stack(code: f32) -> LightSamples {
    let mut samples = polynomial([4, 3], spiral(5), false);
    let value = Domain::Display.decode(code);
    samples.images.iter_mut().for_each(|image| image.to_mut().fill([value; 3]));
    samples
}

#[test]
fn errors_of_known_renderings() {
    let same = stack_errors(&grey(0.5), &stack(0.5), 1);
    assert_eq!((same.lights, same.texels), (5, 12));
    assert!(same.psnr > 90.0 && same.delta_e < 1e-3, "{same:?}");
    // An error of a tenth in all values: 20 dB.
    let off = stack_errors(&grey(0.6), &stack(0.5), 1);
    assert!((off.psnr - 20.0).abs() < 1e-3 && off.delta_e > 5.0, "{off:?}");
    // One of 60 pixels alone: 10 log10(60) better.
    let mut samples = stack(0.5);
    samples.images[3].to_mut()[3] = [Domain::Display.decode(0.6); 3];
    let one = stack_errors(&grey(0.5), &samples, 1);
    assert!((one.psnr - 20.0 - 10.0 * 60f64.log10()).abs() < 1e-2, "{one:?}");
    // The pixel is in row 0; every second row begins with row 1, and larger strides with the middle.
    let rows = stack_errors(&grey(0.5), &samples, 2);
    assert_eq!(rows.texels, 4);
    assert!(rows.psnr > 90.0 && stack_errors(&grey(0.5), &samples, 100).texels == 4, "{rows:?}");
}

/// Undefined texels affect neither errors nor choices: garbage there changes neither the choice nor the report, while
/// it does without the mask.
#[test]
fn undefined_texels_count_nothing() {
    let clean = lambert([32, 32], spiral(24), true);
    let hole = |texel: usize| texel % 32 < 8 && texel / 32 < 16;
    let mut masked = clean.clone();
    for (light, image) in masked.images.iter_mut().enumerate() {
        let garbage = |texel: usize| ((texel * 7919 + light * 104_729) % 1009) as f32 / 1009.0;
        let texels = image.to_mut().iter_mut().enumerate().filter(|(texel, _)| hole(*texel));
        texels.for_each(|(texel, value)| *value = [garbage(texel); 3]);
    }
    let unmasked = masked.clone();
    masked.defined = Some((0..32 * 32).map(|texel| !hole(texel)).collect());
    assert_eq!((masked.defined_texels(), masked.cropped(64).defined_texels()), (32 * 32 - 8 * 16, 32 * 32 - 8 * 16));
    let made = |samples: &LightSamples| encode(samples, &PwtRecipe::default()).unwrap();
    let [clean, masked_made, unmasked_made] = [made(&clean), made(&masked), made(&unmasked)];
    assert_eq!(masked_made.errors.texels, 32 * 32 - 8 * 16);
    let unseen = [&clean, &masked_made, &unmasked_made].map(|made| made.candidates[0].held_out_psnr.unwrap());
    assert!((unseen[1] - unseen[0]).abs() < 0.5 && unseen[2] < unseen[0] - 2.0, "{unseen:?}");
    let reported = [&masked_made, &unmasked_made].map(|made| made.errors.delta_e);
    assert!(reported[0] < reported[1] - 0.5, "{reported:?}");
    // Errors of a pack that is exact at defined texels are measured as such.
    let all = stack_errors(&PwtDecoder::new(clean.pack.clone()), &unmasked, 1);
    let seen = stack_errors(&PwtDecoder::new(clean.pack), &masked, 1);
    assert!(seen.delta_e < 0.7 * all.delta_e && seen.texels < all.texels, "{seen:?} {all:?}");
    masked.defined = Some(vec![false; 32 * 32]);
    assert!(masked.check().unwrap_err().to_string().contains("one or more"));
    masked.defined = Some(vec![true; 5]);
    assert!(masked.check().unwrap_err().to_string().contains("mask of defined texels"));
}
