//! Files that other programs read wrong, after public reports that name the right value: project and number stand above each
//! test. The files are made here.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::merl::{Dimensions, Merl, write};
use brdfc_readers::rti_capture::LightPositions;
use brdfc_readers::scan_csv;
use brdfc_source::MerlSource;
use brdfc_source::radiance_image::from_hdr;
use brdfc_source::rti_capture::RtiCapture;

/// A Radiance file without run-length encoding.
fn flat_hdr(head: &str, width: usize, height: usize, pixels: &[[u8; 4]]) -> Vec<u8> {
    let head = format!("{head}\n\n-Y {height} +X {width}\n").into_bytes();
    head.into_iter().chain(pixels.iter().flatten().copied()).collect()
}

/// filament 1937, hdrv 15: GIMP writes lines without run-length encoding.
#[test]
fn lines_of_radiance_files_may_be_flat() {
    let pixels: Vec<[u8; 4]> = (0..32).map(|k| [k, 2 * k, 3 * k, 136]).collect();
    let image = from_hdr(&flat_hdr("#?RADIANCE\nFORMAT=32-bit_rle_rgbe", 16, 2, &pixels)).unwrap();
    for (found, [r, g, b, _]) in image.pixels.iter().zip(&pixels) {
        assert_eq!(*found, [r, g, b].map(|c| f32::from(*c)));
    }
}

/// loaders.gl 3327: the first pixel of a flat file looks like the start of an encoded line.
#[test]
fn flat_lines_may_start_like_encoded_ones() {
    let mut pixels = vec![[40, 50, 60, 136]; 32];
    // The marker of a line of 16 pixels.
    pixels[0] = [2, 2, 0, 16];
    let image = from_hdr(&flat_hdr("#?RADIANCE\nFORMAT=32-bit_rle_rgbe", 16, 2, &pixels));
    match image {
        Ok(image) => assert_eq!(image.pixels[1], [40.0, 50.0, 60.0]),
        // The format does not tell them apart; an error is honest, other pixels are not.
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// opencv 4885: other variables may follow FORMAT.
#[test]
fn variables_may_follow_the_format() {
    let head = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\nSOFTWARE=test\nVIEW= -vtv -vh 45";
    let image = from_hdr(&flat_hdr(head, 2, 1, &[[8, 4, 2, 136]; 2])).unwrap();
    assert_eq!(image.pixels, [[8.0, 4.0, 2.0]; 2]);
}

/// xarray-spatial 1500: floats with a predictor, most significant byte first in the file.
#[test]
fn floats_with_a_predictor_may_be_big_endian() {
    let levels = [0.1f32, 0.2, 0.3, 0.4];
    for big in [false, true] {
        // One plane per byte, the most significant first, in both orders of the file; then differences.
        let planes: Vec<u8> = (0..4).flat_map(|byte| levels.map(|value| value.to_be_bytes()[byte])).collect();
        let differences = |at: usize| if at == 0 { planes[0] } else { planes[at].wrapping_sub(planes[at - 1]) };
        let strip = stored_zlib(&(0..planes.len()).map(differences).collect::<Vec<u8>>());
        let two = |value: u16| if big { value.to_be_bytes() } else { value.to_le_bytes() };
        let four = |value: u32| if big { value.to_be_bytes() } else { value.to_le_bytes() };
        let mut bytes = if big { b"MM".to_vec() } else { b"II".to_vec() };
        bytes.extend(two(42));
        bytes.extend(four(8 + strip.len() as u32));
        bytes.extend(&strip);
        let fields: [(u16, u32); 11] = [
            (256, 4),
            (257, 1),
            (258, 32),
            (259, 8),
            (262, 1),
            (273, 8),
            (277, 1),
            (278, 1),
            (279, strip.len() as u32),
            (317, 3),
            (339, 3),
        ];
        bytes.extend(two(fields.len() as u16));
        for (tag, value) in fields {
            bytes.extend([two(tag), two(4)].concat().into_iter().chain([four(1), four(value)].concat()));
        }
        bytes.extend(four(0));
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.tif"), bytes).unwrap();
        std::fs::write(folder.path().join("a.lp"), "1\na.tif 0 0 1\n").unwrap();
        let image = RtiCapture::open(folder.path()).unwrap().image(0).unwrap();
        let found: Vec<f32> = image.pixels.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(found, levels, "big-endian: {big}");
    }
}

/// A stored block of zlib.
pub fn stored_zlib(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u16;
    let (mut a, mut b) = (1u32, 0u32);
    for byte in bytes {
        a = (a + u32::from(*byte)) % 65521;
        b = (b + a) % 65521;
    }
    let head = [0x78, 0x01, 0x01].into_iter().chain(length.to_le_bytes()).chain((!length).to_le_bytes());
    head.chain(bytes.iter().copied()).chain(((b << 16) | a).to_be_bytes()).collect()
}

fn values(csv: &str) -> Vec<[f64; 3]> {
    scan_csv::from_bytes(csv.as_bytes())
        .unwrap_or_else(|error| panic!("{error}"))
        .rows
        .iter()
        .map(|row| row.value)
        .collect()
}

/// JASP 3608 and SheetJS 2239: semicolons between values with decimal commas, also where the comma follows a zero.
#[test]
fn commas_are_decimal_where_semicolons_separate() {
    let text = "theta_i;phi_i;theta_o;phi_o;r;g;b\n0,5;0;0,7;3,1;0,435;1,286;0,118\n";
    assert_eq!(values(text), [[0.435, 1.286, 0.118]]);
}

/// SasView 344: a thousand with a separator in quotes is not 1.
#[test]
fn separators_of_thousands_do_not_change_values() {
    let text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n0.5,0,0.7,3.1,\"1,234.5\",2,3\n";
    let error = scan_csv::from_bytes(text.as_bytes()).map(drop).unwrap_err().to_string();
    assert!(error.contains("1,234.5"), "{error}");
    // Where commas may be decimal marks, a decimal point tells them from separators.
    for (row, expected) in [
        ("0.5;0;0.7;3;1,134;2;3", "\"1,134\" after numbers with decimal points"),
        ("0,5;0;0,7;3;1.134;2;3", "\"1.134\" after numbers with decimal commas"),
        ("1.234,5;0;1;3;1;2;3", "\"1.234,5\" with a point and a comma"),
    ] {
        let text = format!("theta_i;phi_i;theta_o;phi_o;r;g;b\n{row}\n");
        let error = scan_csv::from_bytes(text.as_bytes()).map(drop).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// meta-sampling 1: a cell counts as invalid if any of its channels is negative, not only the red one.
#[test]
fn a_cell_is_invalid_in_any_channel() {
    let dimensions = Dimensions { theta_half: 8, theta_difference: 8, phi_difference: 8 };
    let mut bytes = Vec::new();
    write(&mut bytes, dimensions, |_| Some([0.5; 3])).unwrap();
    // Green, in a cell near the normal.
    let cell = (2 * 8 + 2) * 8 + 3;
    bytes[12 + 8 * (dimensions.cells() + cell)..][..8].copy_from_slice(&(-1f64).to_le_bytes());
    let source = MerlSource::new(Merl::from_bytes(&bytes).unwrap());
    for k in 0..2000 {
        let angle = |step: f64, most: f64| most * (f64::from(k) * step).fract();
        let pair = DirectionPair::from_angles(angle(0.618, 1.5), 0.0, angle(0.755, 1.5), angle(0.57, 6.2));
        let found = source.eval(pair, &mut Tally::default());
        assert!(found.iter().all(|c| (c - 0.5).abs() < 1e-6), "{found:?}");
    }
}

/// relight 19: a list without the number of lights in its first line is complete.
#[test]
fn lists_of_lights_need_no_number() {
    let list = LightPositions::parse("a.jpg 0 0 1\nb.jpg 0.6 0 0.8\n").unwrap();
    assert_eq!((list.names.len(), list.stated), (2, None));
}
