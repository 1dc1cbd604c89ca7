//! BTFs of the Bonn database of 2014, written by the tests and read by the crate.

mod write;

use brdfc_formats::FormatError;
use brdfc_formats::container::half;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::ubo_btf::{Channel, ColourModel, Description, Scalar, UboBtf};
use write::to_bytes;

const SIZE: [usize; 2] = [8, 4];
const TEXELS: usize = 32;

fn directions() -> [DirectionSet; 2] {
    let set = |angles: &[[f64; 2]]| DirectionSet::new("of the file", angles.to_vec()).unwrap();
    [set(&[[0.0, 0.0], [37.5, 7.5], [75.0, 345.0]]), set(&[[11.0, 15.0], [60.0, 270.0]])]
}

fn description(colour_model: ColourModel) -> Description {
    let [views, lights] = directions();
    Description {
        version: 4,
        devices: ["dome", "camera", "LED"].map(str::to_owned),
        texels_per_millimetre: 8.5,
        rgb_factors: [1.0, 1.25, 1.5],
        has_cosine: false,
        xml_bytes: 0,
        views,
        lights,
        size: SIZE,
        colour_model,
    }
}

/// The sign in a Hadamard matrix, whose rows are orthogonal.
fn sign(row: usize, column: usize) -> f32 {
    if (row & column).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Full-rank channel with known values: their Walsh transform along the texels, and its inverse.
fn factored(value: impl Fn(usize, usize) -> f32, pairs: usize, scalar: Scalar) -> Channel {
    let coefficient = |pair: usize, k: usize| {
        (0..TEXELS).map(|texel| value(pair, texel) * sign(k, texel)).sum::<f32>() / TEXELS as f32
    };
    let first: Vec<f32> = (0..pairs * TEXELS).map(|at| coefficient(at / TEXELS, at % TEXELS)).collect();
    let second: Vec<f32> = (0..TEXELS * TEXELS).map(|at| sign(at / TEXELS, at % TEXELS)).collect();
    Channel::new(TEXELS, &first, &second, scalar).unwrap()
}

/// RGB of a small relief, without equal values or mirror images.
fn truth(pair: usize, texel: usize) -> [f32; 3] {
    let (x, y) = ((texel % SIZE[0]) as f32, (texel / SIZE[0]) as f32);
    let shade = 0.3 + 0.05 * pair as f32 + 0.04 * (0.7 * x + pair as f32).sin();
    [shade, shade * (0.5 + 0.1 * y), 0.2 * shade + 0.01 * x]
}

/// Analogue YUV of RGB: the inverse of the decoder's constants, solved by Cramer's rule from matching luma weights.
fn yuv([r, g, b]: [f32; 3]) -> [f32; 3] {
    // r = y + p v, g = y - q u - s v, b = y + t u; q/t and s/p weigh blue and red in luma.
    let (p, q, s, t) = (1.13983, 0.39465, 0.5806, 2.03211);
    let (weight_r, weight_b) = (s / p, q / t);
    let y = (weight_r * r + g + weight_b * b) / (weight_r + 1.0 + weight_b);
    [y, (b - y) / t, (r - y) / p]
}

fn example(model: ColourModel, scalar: Scalar) -> UboBtf {
    let encode = |rgb: [f32; 3]| match model {
        ColourModel::LogYRatioUv => {
            let [y, u, v] = yuv(rgb);
            [(y + 1e-5).ln(), u / (y + 1e-5), v / (y + 1e-5)]
        }
        _ => rgb,
    };
    let channels = [0, 1, 2].map(|c| factored(|pair, texel| encode(truth(pair, texel))[c], 6, scalar));
    UboBtf::new(description(model), channels).unwrap()
}

fn error_of(bytes: &[u8]) -> FormatError {
    UboBtf::from_bytes(bytes).unwrap_err()
}

/// Offsets of the parts of a version 4 file up to the first channel.
mod at {
    pub const HEADER: usize = 10;
    pub const XML: usize = HEADER + 4 + 4 + 240 + 16 + 4;
    pub const CHANNELS: usize = XML + 4;
    pub const VIEWS: usize = CHANNELS + 4 + 3 * 5;
    pub const FIRST_LIGHTS: usize = VIEWS + 4 + 8;
    pub const SECOND_LIGHTS: usize = FIRST_LIGHTS + 4 + 16 + 8;
    pub const SIZE: usize = VIEWS + 4 + 3 * (8 + 4 + 16);
    pub const ROTATIONS: usize = SIZE + 8;
    pub const MODEL: usize = ROTATIONS + 8;
    pub const CHANNEL: usize = MODEL + 4 + 48;
}

#[test]
fn files_round_trip() {
    for model in [ColourModel::Rgb, ColourModel::LogYRatioUv] {
        for scalar in [Scalar::Half, Scalar::Single, Scalar::Double] {
            let btf = example(model, scalar);
            let read = UboBtf::from_bytes(&to_bytes(&btf, scalar)).unwrap();
            assert_eq!(read, btf, "{model:?} {scalar:?}");
        }
    }
    let pca =
        ColourModel::Pca { mean: [0.1, 0.2, 0.3], transform: [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5]] };
    let btf = example(pca, Scalar::Single);
    assert_eq!(UboBtf::from_bytes(&to_bytes(&btf, Scalar::Single)).unwrap(), btf);
    for version in 1..=3 {
        let btf = UboBtf::new(
            Description { version, has_cosine: version > 1, ..description(ColourModel::Rgb) },
            example(ColourModel::Rgb, Scalar::Half).channels().clone(),
        )
        .unwrap();
        assert_eq!(UboBtf::from_bytes(&to_bytes(&btf, Scalar::Half)).unwrap(), btf, "version {version}");
    }
}

#[test]
fn values_match_within_the_precision_of_halves() {
    for (model, scalar) in [
        (ColourModel::Rgb, Scalar::Half),
        (ColourModel::LogYRatioUv, Scalar::Half),
        (ColourModel::Rgb, Scalar::Single),
        (ColourModel::LogYRatioUv, Scalar::Single),
    ] {
        let btf = UboBtf::from_bytes(&to_bytes(&example(model, scalar), scalar)).unwrap();
        let mut worst = 0.0f32;
        for pair in 0..6 {
            // Each coefficient is off by half an ulp of its half or by 2^-25; signs are exact. A row adds them up.
            let bound = |c: usize| -> f32 {
                let row = btf.channels()[c].pairs().row(pair);
                match scalar {
                    Scalar::Half => row.iter().map(|v| v.abs() * 2f32.powi(-11) + 2f32.powi(-25)).sum(),
                    _ => row.iter().map(|v| v.abs() * TEXELS as f32 * f32::EPSILON).sum(),
                }
            };
            let image = btf.image(pair / 2, pair % 2).unwrap();
            for (texel, found) in image.iter().enumerate() {
                let expected = truth(pair, texel);
                let allowed = match model {
                    ColourModel::Rgb => [0, 1, 2].map(bound),
                    // Y has that relative error, in addition to the shares of U and V, at most 2.04 of them.
                    _ => [(2.1 * (bound(0) + bound(1) + bound(2)) + 2e-6) * expected.iter().sum::<f32>(); 3],
                };
                for c in 0..3 {
                    let difference = (found[c] - expected[c]).abs();
                    assert!(
                        difference <= allowed[c] + 1e-6,
                        "{model:?} {scalar:?} {pair} {texel}: {found:?} {expected:?}"
                    );
                    worst = worst.max(difference);
                }
            }
        }
        // Rounding to halves is visible; the lower bound shows that the check is not trivial.
        let least = if scalar == Scalar::Half { 1e-5 } else { 0.0 };
        assert!(worst >= least && worst < 2e-3, "{model:?} {scalar:?} {worst}");
    }
}

#[test]
fn texels_and_images_are_the_same_bits() {
    let btf = example(ColourModel::LogYRatioUv, Scalar::Half);
    for view in 0..3 {
        for light in 0..2 {
            let image = btf.image(view, light).unwrap();
            for texel in 0..TEXELS {
                assert_eq!(btf.texel(view, light, texel).unwrap(), image[texel]);
            }
        }
    }
    for wrong in [btf.image(3, 0).map(drop), btf.image(0, 2).map(drop), btf.texel(0, 0, TEXELS).map(drop)] {
        assert!(wrong.unwrap_err().to_string().contains("expected"));
    }
    assert!(btf.texel(0, 0, usize::MAX).is_err());
}

#[test]
fn exchanged_matrices_are_the_same_btf() {
    let btf = example(ColourModel::Rgb, Scalar::Single);
    let mut bytes = to_bytes(&btf, Scalar::Single);
    bytes.truncate(at::CHANNEL);
    for channel in btf.channels() {
        bytes.push(4);
        [TEXELS, TEXELS, 6].iter().for_each(|n| bytes.extend((*n as u32).to_le_bytes()));
        bytes.extend(vec![0; 4 * TEXELS]);
        for matrix in [channel.texels(), channel.pairs()] {
            (0..matrix.rows()).flat_map(|row| matrix.row(row)).for_each(|v| bytes.extend(v.to_le_bytes()));
        }
    }
    assert_eq!(UboBtf::from_bytes(&bytes).unwrap(), btf);
}

#[test]
fn known_colours() {
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 2e-6), "{found:?} {expected:?}");
    };
    near(ColourModel::Rgb.to_rgb([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
    near(ColourModel::Yuv.to_rgb([0.5, 0.0, 0.0]), [0.5; 3]);
    near(ColourModel::Yuv.to_rgb([0.5, 0.1, -0.2]), [0.272_034, 0.576_655, 0.703_211]);
    near(ColourModel::YCoCg.to_rgb([0.5, 0.1, 0.2]), [0.4, 0.7, 0.2]);
    let log = |y: f32| (y + 1e-5).ln();
    near(ColourModel::LogYuv.to_rgb([log(0.5), 0.1, -0.2]), [0.272_034, 0.576_655, 0.703_211]);
    let signed = |v: f32| v.signum() * (v.abs() / 1e-5).ln();
    near(ColourModel::LogLogYuv.to_rgb([log(0.5), signed(0.1), signed(-0.2)]), [0.272_034, 0.576_655, 0.703_211]);
    near(ColourModel::LogLogYuv.to_rgb([log(0.5), 0.0, 0.0]), [0.5; 3]);
    let share = |v: f32| v / (0.5 + 1e-5);
    near(ColourModel::LogYRatioUv.to_rgb([log(0.5), share(0.1), share(-0.2)]), [0.272_034, 0.576_655, 0.703_211]);
    near(ColourModel::LogRgb.to_rgb([log(0.0), log(0.25), log(1.0)]), [0.0, 0.25, 1.0]);
    let transform = [[1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
    near(ColourModel::Pca { mean: [0.1, 0.2, 0.3], transform }.to_rgb([0.1, 0.2, 0.3]), [0.2, 0.6, 1.2]);
}

#[test]
fn truncated_files_report_the_place() {
    let bytes = to_bytes(&example(ColourModel::LogYRatioUv, Scalar::Half), Scalar::Half);
    assert!(UboBtf::from_bytes(&bytes).is_ok());
    for length in 0..bytes.len() {
        let error = error_of(&bytes[..length]);
        let brdfc_formats::Place::Byte(place) = error.place else { panic!("{error}") };
        assert!(place <= length as u64, "{length}: {error}");
    }
    let longer = [&bytes[..], b"x"].concat();
    assert_eq!(
        error_of(&longer).to_string(),
        format!("byte {}, end: found 1 more bytes, expected the end of the file", bytes.len())
    );
}

#[test]
fn wrong_words_are_reported_with_their_place() {
    let good = to_bytes(&example(ColourModel::LogYRatioUv, Scalar::Half), Scalar::Half);
    let message = |place: usize, word: u32| {
        let mut bytes = good.clone();
        bytes[place..place + 4].copy_from_slice(&word.to_le_bytes());
        error_of(&bytes).to_string()
    };
    for (place, word, expected) in [
        (at::HEADER, 1, "header size: found 1, expected 291"),
        (at::HEADER + 4, 0, "version: found 0, expected 1 to 4"),
        (at::HEADER + 4, 5, "version: found 5, expected 1 to 4"),
        (at::CHANNELS, 4, "channels: found 4, expected 3"),
        (at::VIEWS, 0, "views: found 0, expected 1 to 2048"),
        (at::VIEWS, u32::MAX, "views: found 4294967295"),
        (at::FIRST_LIGHTS, u32::MAX, "lights of a view: found 4294967295"),
        (at::SECOND_LIGHTS, 1, "lights of a view: found 1, expected 2, as for the first view"),
        (at::SIZE, 0, "width: found 0, expected 1 to 4096"),
        (at::SIZE + 4, u32::MAX, "height: found 4294967295"),
        (at::ROTATIONS, 32, "rotations: found 32, expected 0"),
        (at::MODEL, 2, "colour model: found 2 (L*a*b*)"),
        (at::MODEL, 6, "colour model: found 6 (spectral)"),
        (at::MODEL, u32::MAX, "colour model: found -1"),
        (at::CHANNEL + 1, 0, "components of a channel: found 0"),
        (at::CHANNEL + 1, u32::MAX, "components of a channel: found 4294967295"),
        (at::CHANNEL + 5, 7, "rows of the first matrix: found 7, expected 6 (32 if they are exchanged)"),
        (at::CHANNEL + 5, u32::MAX, "rows of the first matrix: found 4294967295"),
        (at::CHANNEL + 9, 33, "rows of the second matrix: found 33, expected 32"),
    ] {
        let text = message(place, word);
        assert!(text.starts_with(&format!("byte {place}, {expected}")), "{text}");
    }
    // A truncated part is reported at its beginning.
    assert!(message(at::XML, u32::MAX).starts_with(&format!("byte {}, XML: end of data", at::XML + 4)));
    let text = message(at::CHANNELS + 4, u32::MAX);
    assert!(text.starts_with(&format!("byte {}, name of a channel: end of data", at::CHANNELS + 8)), "{text}");
    let many = message(at::VIEWS, 2048);
    assert!(many.contains("lights of a view") || many.contains("views"), "{many}");

    let mut bytes = good.clone();
    bytes[at::CHANNEL] = 3;
    assert_eq!(
        error_of(&bytes).to_string(),
        format!("byte {}, bytes of a number: found 3, expected 2, 4 or 8", at::CHANNEL)
    );
    let second_light = at::SECOND_LIGHTS + 4;
    assert!(message(second_light, 0.5f32.to_bits()).contains("as for the first view"));
    assert!(
        message(second_light, f32::NAN.to_bits()).starts_with(&format!("byte {second_light}, theta_deg: found NaN"))
    );
    assert!(message(at::FIRST_LIGHTS + 4, f32::NAN.to_bits()).contains("theta_deg: found NaN"));
    assert!(message(at::VIEWS + 4, 2f32.to_bits()).contains("theta_deg: found 114.59"));
    // The first number of the first matrix, after the singular values.
    let place = at::CHANNEL + 13 + 2 * TEXELS;
    bytes = good.clone();
    bytes[place..place + 2].copy_from_slice(&0x7c00u16.to_le_bytes());
    assert_eq!(error_of(&bytes).to_string(), format!("byte {place}, first matrix: found inf, expected finite numbers"));
}

#[test]
fn other_layouts_are_named() {
    for (start, expected) in [
        (&b"!FMF06FCR"[..], "FMF (the codec without"),
        (b"!FMF12FCER", "FMF (the codec without"),
        (b"!PVF06FC..", "PVF"),
        (b"!BDIF06R2!", "BDI"),
        (b"!DFMF09FCR", "another version of DFMF"),
        (b"\x89PNG\r\n\x1a\n\0\0", "\"\\x89PNG"),
        (b"", "\"\""),
    ] {
        let text = error_of(start).to_string();
        assert!(text.starts_with(&format!("byte 0, signature: found {expected}")), "{text}");
    }
}

#[test]
fn xml_and_long_names_are_skipped() {
    let btf = example(ColourModel::Rgb, Scalar::Half);
    let mut bytes = to_bytes(&btf, Scalar::Half);
    let xml = b"<measurement/>";
    bytes.splice(at::XML + 4..at::XML + 4, xml.iter().copied());
    bytes[at::XML] = xml.len() as u8;
    let size = u32::from_le_bytes(bytes[at::HEADER..at::HEADER + 4].try_into().unwrap()) + xml.len() as u32;
    bytes[at::HEADER..at::HEADER + 4].copy_from_slice(&size.to_le_bytes());
    let read = UboBtf::from_bytes(&bytes).unwrap();
    assert_eq!(read.description().xml_bytes, 14);
    assert_eq!(read.channels(), btf.channels());
    let long = Description { devices: ["é".repeat(60), String::new(), "x".into()], ..description(ColourModel::Rgb) };
    let long = UboBtf::new(long, btf.channels().clone()).unwrap();
    assert_eq!(UboBtf::from_bytes(&to_bytes(&long, Scalar::Half)).unwrap().description().devices[0], "é".repeat(40));
}

#[test]
fn contradictions_are_rejected() {
    let btf = example(ColourModel::Rgb, Scalar::Half);
    let wrong = |change: &dyn Fn(&mut Description)| {
        let mut description = btf.description().clone();
        change(&mut description);
        UboBtf::new(description, btf.channels().clone()).unwrap_err().to_string()
    };
    assert!(wrong(&|d| d.size = [8, 5]).contains("rows of texels: found 32, expected 40"));
    assert!(wrong(&|d| d.size = [0, 5]).contains("found 0"));
    assert!(wrong(&|d| d.views = DirectionSet::ubo2003()).contains("expected 162"));
    assert!(wrong(&|d| d.version = 5).contains("found 5"));
    assert!(wrong(&|d| (d.version, d.has_cosine) = (1, true)).contains("cosine flag"));
    assert!(Channel::new(2, &[1.0; 3], &[1.0; 2], Scalar::Half).is_err());
    assert!(Channel::new(0, &[], &[], Scalar::Half).is_err());
    assert!(Channel::new(1, &[half::MAX * 2.0], &[1.0], Scalar::Half).is_err());
    assert!(Channel::new(1, &[half::MAX * 2.0], &[1.0], Scalar::Single).is_ok());
}
