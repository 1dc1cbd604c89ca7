//! Errors of packs that are known.

use super::stacks::{polynomial, spiral};
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, PwtDecoder, PwtHeader, PwtPack};
use brdfc_pwt::LightSamples;
use brdfc_pwt::measure::stack_errors;
use brdfc_testing::pwt::{plain, single};

/// A grey pack of one value, its sRGB code as a share.
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
    samples.pictures.iter_mut().flatten().for_each(|pixel| *pixel = [value; 3]);
    samples
}

#[test]
fn errors_of_known_pictures() {
    let same = stack_errors(&grey(0.5), &stack(0.5), 1);
    assert_eq!((same.lights, same.texels), (5, 12));
    assert!(same.psnr > 90.0 && same.delta_e < 1e-3, "{same:?}");
    // A tenth of all codes: 20 dB.
    let off = stack_errors(&grey(0.6), &stack(0.5), 1);
    assert!((off.psnr - 20.0).abs() < 1e-3 && off.delta_e > 5.0, "{off:?}");
    // One of 60 pixels alone: 10 log10(60) better.
    let mut samples = stack(0.5);
    samples.pictures[3][7] = [Domain::Display.decode(0.6); 3];
    let one = stack_errors(&grey(0.5), &samples, 1);
    assert!((one.psnr - 20.0 - 10.0 * 60f64.log10()).abs() < 1e-2, "{one:?}");
    // It stands in row 1, which every second row leaves out.
    let rows = stack_errors(&grey(0.5), &samples, 2);
    assert_eq!(rows.texels, 8);
    assert!(rows.psnr > 90.0 && stack_errors(&grey(0.5), &samples, 100).texels == 4, "{rows:?}");
}
