use super::*;
use proptest::prelude::*;

const HEADER: &str = "PTM_1.2\nPTM_FORMAT_LRGB\n2\n2\n2 2 2 2 2 0.5\n160 160 160 127 127 0\n";

/// Coefficients, then colours, of four pixels; the bottom row comes first.
fn lrgb(header: &str) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    for pixel in 0..4u8 {
        bytes.extend([160, 160, 160, 127, 127, 100 + pixel]);
    }
    bytes.extend([10, 20, 30, 11, 21, 31, 12, 22, 32, 13, 23, 33]);
    bytes
}

/// Reads a file whose planes are not compressed.
fn read(bytes: &[u8]) -> Result<Ptm, FormatError> {
    Ptm::from_bytes(bytes, &|plane, _| Ok(plane.to_vec()))
}

fn message(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

#[test]
fn rows_run_from_the_bottom_and_colours_follow_all_coefficients() {
    let ptm = read(&lrgb(HEADER)).unwrap();
    assert_eq!((ptm.size(), ptm.scale()[5], ptm.bias()), ([2, 2], 0.5, [160, 160, 160, 127, 127, 0]));
    let PtmModel::Lrgb { luminance, colour } = ptm.model() else { panic!("{ptm:?}") };
    assert_eq!(luminance.iter().map(|bytes| bytes[5]).collect::<Vec<_>>(), [102, 103, 100, 101]);
    assert_eq!(colour, &[[12, 22, 32], [13, 23, 33], [10, 20, 30], [11, 21, 31]]);
    // 101 / 2 times the colour, under any light.
    assert_eq!(ptm.value(3, [0.3, -0.9]), [11.0, 21.0, 31.0].map(|code: f32| 50.5 * code / 255.0));
}

#[test]
fn older_files_have_the_colour_of_a_pixel_after_its_coefficients() {
    let bytes = lrgb(HEADER);
    let (header, pixels) = bytes.split_at(HEADER.len());
    let (luminance, colour) = pixels.split_at(4 * TERMS);
    let pairs = luminance.chunks(TERMS).zip(colour.chunks(3));
    let interleaved: Vec<u8> = pairs.flat_map(|(a, b)| [a, b].concat()).collect();
    let older =
        [header.to_vec(), interleaved].concat().strip_prefix(b"PTM_1.2").map(|rest| [b"PTM_1.1", rest].concat());
    assert_eq!(read(&older.clone().unwrap()), read(&bytes));
    // Control: the same bytes with the other version are another map.
    let other = [b"PTM_1.2", &older.unwrap()[7..]].concat();
    assert_ne!(read(&other), read(&bytes));
}

/// Each term alone, with its own byte.
#[test]
fn terms_are_in_the_order_of_the_paper() {
    let (scale, bias) = ([1.0, 10.0, 20.0, 40.0, 80.0, 30.0], [0, 1, 2, 3, 4, 5]);
    let value = |term: usize, light| {
        let mut bytes = [0, 1, 2, 3, 4, 5];
        bytes[term] += 2;
        let model = PtmModel::Rgb(vec![[bytes, [0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 255]]]);
        Ptm::new([1, 1], scale, bias, model).unwrap().value(0, light)
    };
    for (term, expected) in [0.5, 5.0, 10.0, 40.0, 80.0, 60.0].into_iter().enumerate() {
        // Green has no term, blue exceeds 255.
        assert_eq!(value(term, [0.5, 0.5]), [expected, 0.0, 255.0], "{term}");
    }
    assert_eq!(value(3, [-0.5, 0.5])[0], 0.0, "negative values are clamped");
    assert_eq!([value(0, [0.5, -0.25])[0], value(1, [0.5, -0.25])[0]], [0.5, 1.25]);
}

#[test]
fn the_luminance_is_not_clamped_before_it_meets_a_colour() {
    let model = PtmModel::Lrgb { luminance: vec![[0, 0, 0, 0, 0, 255]], colour: vec![[100, 0, 255]] };
    let ptm = Ptm::new([1, 1], [2.0; 6], [0; 6], model).unwrap();
    assert_eq!(ptm.value(0, [0.0, 0.0]), [200.0, 0.0, 255.0]);
}

#[test]
fn channels_are_in_blocks() {
    let mut bytes = b"PTM_1.2\nPTM_FORMAT_RGB\n2 1\n1 1 1 1 1 1 0 0 0 0 0 0\n".to_vec();
    bytes.extend(0..36);
    let ptm = read(&bytes).unwrap();
    let PtmModel::Rgb(pixels) = ptm.model() else { panic!("{ptm:?}") };
    assert_eq!(pixels[1], [[6, 7, 8, 9, 10, 11], [18, 19, 20, 21, 22, 23], [30, 31, 32, 33, 34, 35]]);
    assert_eq!(ptm.value(1, [0.0, 0.0]), [11.0, 23.0, 35.0]);
}

#[test]
fn headers_have_line_ends_where_they_like() {
    let expected = read(&lrgb(HEADER)).unwrap();
    for header in [
        "PTM_1.2\nPTM_FORMAT_LRGB\n2 2\n2 2 2 2 2 0.5 160 160 160 127 127 0\n",
        "PTM_1.2 \nPTM_FORMAT_LRGB \n2\n2\n2.0 2.0 2.0 2e0 2.0 0.5 \n160 160 160 127 127 0 \n",
        "PTM_1.2\r\nPTM_FORMAT_LRGB\r\n2\r\n2\r\n2 2 2 2 2 0.5\r\n160.0 160 160 127 127 -0\r\n",
    ] {
        assert_eq!(read(&lrgb(header)).as_ref(), Ok(&expected), "{header}");
    }
    // One line end belongs to the header, further ones are pixels.
    assert!(
        message(&lrgb(&format!("{HEADER}\n"))).starts_with("file length: found 37 bytes after the header, expected 36")
    );
    assert_eq!(expected.to_bytes(), lrgb(HEADER));
}

#[test]
fn headers_that_are_wrong() {
    let with = |old: &str, new: &str| message(&lrgb(&HEADER.replacen(old, new, 1)));
    for (old, new, expected) in [
        ("PTM_1.2", "PTM_1.0", "line 1, version: found \"PTM_1.0\", expected PTM_1.2 or PTM_1.1"),
        (
            "PTM_FORMAT_LRGB",
            "PTM_FORMAT_JPEGLS_LRGB",
            "line 2, format: found the unsupported \"PTM_FORMAT_JPEGLS_LRGB\", expected PTM_FORMAT_RGB, PTM_FORMAT_LRGB, \
             PTM_FORMAT_JPEG_RGB or PTM_FORMAT_JPEG_LRGB",
        ),
        ("PTM_FORMAT_LRGB", "RGB", "line 2, format: found \"RGB\", expected PTM_FORMAT_RGB"),
        ("\n2\n2\n", "\n0\n2\n", "line 3, width: found \"0\", expected 1 to 65536"),
        ("\n2\n2\n", "\n2\n-2\n", "line 4, height: found \"-2\""),
        ("\n2\n2\n", "\n+2\n2\n", "line 3, width: found \"+2\", expected 1 to 65536"),
        ("\n2\n2\n", "\n65537 2\n", "line 3, width: found \"65537\""),
        ("\n2\n2\n", "\n65536\n65536\n", "file length: found 36 bytes after the header, expected 38654705664"),
        ("\n2\n2\n", "\n2\n99999999999\n", "line 4, height: found \"99999999999\""),
        ("2 0.5", "2 0", "line 5, scale: found \"0\", expected a finite number that is not 0"),
        ("2 0.5", "2 1e-60", "line 5, scale: found \"1e-60\""),
        ("2 0.5", "2 nan", "line 5, scale: found \"nan\""),
        ("2 0.5", "2 1e99", "line 5, scale: found \"1e99\""),
        ("160 127", "160.5 127", "line 6, bias: found \"160.5\", expected a whole number of 32 bits"),
        ("160 127", "1e12 127", "line 6, bias: found \"1e12\""),
        ("160 127", "x 127", "line 6, bias: found \"x\", expected a finite number"),
        ("127 0\n", "127 0x\n", "line 6, bias: found \"0x\""),
    ] {
        assert!(with(old, new).starts_with(expected), "{new}: {}", with(old, new));
    }
    assert!(message(b"").starts_with("line 1, version: end of data"));
    assert!(message(b"PTM_1.2\n\xff\xfe").starts_with("line 2, format: no text"));
    assert!(message(&[b'P'; 1 << 16]).starts_with("line 1, version: no text"));
}

#[test]
fn files_that_are_cut_or_longer() {
    for bytes in [lrgb(HEADER), Ptm::from_coefficients_rgb([2, 1], &[[[0.5; 6]; 3]; 2]).unwrap().to_bytes()] {
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        assert!(read(&[&bytes[..], &[0]].concat()).is_err());
        assert!(read(&bytes).is_ok());
    }
}

/// Words of a compressed header, and planes of two pixels, the lower one first, which are not compressed.
fn compressed(change: impl Fn(&mut [Vec<i64>; 7])) -> Vec<u8> {
    let mut words = [vec![0; 9], vec![0; 9], vec![0; 9], (0..9).collect(), vec![-1; 9], vec![2; 9], vec![0; 9]];
    change(&mut words);
    let lines: String =
        words.iter().map(|words| words.iter().map(i64::to_string).collect::<Vec<_>>().join(" ") + "\n").collect();
    let header = format!("PTM_1.2\nPTM_FORMAT_JPEG_LRGB\n1\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n90\n{lines}");
    let mut bytes = header.into_bytes();
    for plane in 0..9u8 {
        bytes.extend([10 * plane, 10 * plane + 1]);
        // The upper pixel of the plane is 7.
        bytes.extend([0, 0, 0, 1, 7].repeat((words[6][usize::from(plane)] / 5).max(0) as usize));
    }
    bytes
}

fn planes(bytes: &[u8]) -> Vec<[u8; 9]> {
    let ptm = read(bytes).unwrap();
    let PtmModel::Lrgb { luminance, colour } = ptm.model() else { panic!("{ptm:?}") };
    let joined = luminance.iter().zip(colour).map(|(a, b)| [&a[..], b].concat().try_into().unwrap());
    joined.collect()
}

#[test]
fn planes_are_predicted_inverted_and_corrected() {
    let plain = planes(&compressed(|_| ()));
    assert_eq!(plain, [[1, 11, 21, 31, 41, 51, 61, 71, 81], [0, 10, 20, 30, 40, 50, 60, 70, 80]]);
    // Plane 1 is predicted from plane 8, which is decoded first, and plane 2 from the inverse of the corrected plane 1.
    let predicted = planes(&compressed(|words| {
        words[0][2] = 1;
        words[3] = vec![3, 1, 2, 0, 4, 5, 6, 7, 8];
        words[3].swap(8, 3);
        (words[4][1], words[4][2]) = (8, 1);
        words[6][1] = 5;
    }));
    let wrapped = |sample: u8, other: u8| sample.wrapping_add(other).wrapping_sub(128);
    assert_eq!(predicted[0][1..3], [7, wrapped(21, 255 - 7)]);
    assert_eq!(predicted[1][1..3], [wrapped(10, 80), wrapped(20, 255 - wrapped(10, 80))]);
    assert_eq!((predicted[0][0], predicted[0][8]), (1, 81), "others stay");
    let all = compressed(|_| ());
    assert!((0..all.len()).all(|length| read(&all[..length]).is_err()));
}

#[test]
fn planes_that_are_wrong() {
    let of = |change: &dyn Fn(&mut [Vec<i64>; 7])| message(&compressed(change));
    for (found, expected) in [
        (of(&|w| w[0][3] = 2), "line 8, transform: found 2 (motion compensation), expected 0 or 1 (inversion)"),
        (of(&|w| w[0][3] = 9), "line 8, transform: found \"9\""),
        (of(&|w| w[2][0] = 1), "line 10, motion vector: found \"1\", expected 0 to 0"),
        (of(&|w| w[3][1] = 0), "line 11, order: found 0, expected each number once"),
        (of(&|w| w[3][1] = 9), "line 11, order: found \"9\", expected 0 to 8"),
        (of(&|w| w[4][1] = 2), "line 12, reference plane: found 2, expected a plane decoded before, or -1"),
        (of(&|w| w[4][1] = 1), "line 12, reference plane: found 1"),
        (of(&|w| w[4][1] = -2), "line 12, reference plane: found -2"),
        (of(&|w| w[5][1] = -2), "line 13, compressed size: found \"-2\""),
        (of(&|w| w[5][1] = 3), "file length: found 18 bytes after the header, expected 19, the sizes of 9 planes"),
        (of(&|w| w[5][..2].copy_from_slice(&[1, 3])), "plane 0: 1 pixels; expected a grey JPEG of 1 x 2 pixels"),
        (of(&|w| w[6][1] = 4), "line 14, size of corrections: found 4, expected a multiple of 5"),
    ] {
        assert!(found.starts_with(expected), "{found}");
    }
    let mut outside = compressed(|words| words[6][8] = 5);
    let last = outside.len() - 2;
    outside[last] = 2;
    assert_eq!(message(&outside), "correction of plane 8: found pixel 2, expected less than 2");
    let large = String::from_utf8(compressed(|_| ())).unwrap().replacen("\n1\n2\n", "\n65536\n65536\n", 1);
    assert!(message(large.as_bytes()).starts_with("size: found 65536 x 65536, expected at most 134217728 pixels"));
}

#[test]
fn parts_that_do_not_fit() {
    let model = |count: usize| PtmModel::Lrgb { luminance: vec![[0; 6]; 4], colour: vec![[0; 3]; count] };
    let result = |size, scale, model| Ptm::new(size, [scale; 6], [0; 6], model).map(drop).map_err(|e| e.to_string());
    assert_eq!(result([2, 2], 1.0, model(4)), Ok(()));
    assert_eq!(result([2, 2], 1.0, model(3)), Err("pixels: found 3, expected 4 for 2 x 2".to_owned()));
    assert_eq!(result([2, 0], 1.0, model(4)), Err("height: found 0, expected 1 to 65536".to_owned()));
    assert!(result([2, 2], f32::NAN, model(4)).unwrap_err().starts_with("scale: found NaN"));
    let error = Ptm::from_coefficients_lrgb([1, 1], &[[0.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0]], &[[0; 3]]);
    assert_eq!(error.unwrap_err().to_string(), "coefficient: found inf, expected finite numbers");
    assert!(Ptm::from_coefficients_rgb([1, 1], &[]).is_err());
}

#[test]
fn terms_that_do_not_vary_are_exact() {
    let coefficients = [0.0, -0.0, 1.0 / 3.0, -123.456, 1e-40, -3e38];
    let ptm = Ptm::from_coefficients_lrgb([3, 1], &[coefficients; 3], &[[7, 8, 9]; 3]).unwrap();
    let PtmModel::Lrgb { luminance, colour } = ptm.model() else { panic!("{ptm:?}") };
    assert_eq!(ptm.coefficients(luminance[2]), coefficients.map(f64::from));
    assert_eq!(colour, &[[7, 8, 9]; 3]);
}

fn coefficient() -> impl Strategy<Value = f32> {
    prop_oneof![-300.0f32..300.0, -1e-3f32..1e-3, 1e6f32..1.000_01e6, Just(0.0), prop::num::f32::NORMAL]
}

fn coefficients() -> impl Strategy<Value = [f32; 6]> {
    prop::array::uniform6(coefficient())
}

/// Every coefficient is within half a step; a step is 1/255 of the range.
fn check(ptm: &Ptm, written: &[[f32; 6]], read: &[[u8; 6]]) -> Result<(), TestCaseError> {
    for term in 0..TERMS {
        let values = || written.iter().map(|c| f64::from(c[term]));
        let (low, high) = values().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        let step = f64::from(ptm.scale()[term]);
        let least = ((high - low) / 255.0).max(high.abs().max(low.abs()) / MAX_BIAS);
        prop_assert!(low == high || step <= least * (1.0 + 1e-6) + 2e-45, "{step} {least}");
        for (written, read) in values().zip(read) {
            let error = (ptm.coefficients(*read)[term] - written).abs();
            let half = if low == high { 0.0 } else { 0.5 * step * (1.0 + 1e-6) };
            prop_assert!(error <= half, "term {term}: {error} of {step}");
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn rgb_round_trips(pixels in prop::collection::vec(prop::array::uniform3(coefficients()), 6)) {
        let ptm = Ptm::from_coefficients_rgb([2, 3], &pixels).unwrap();
        let PtmModel::Rgb(bytes) = ptm.model() else { panic!("{ptm:?}") };
        check(&ptm, pixels.as_flattened(), bytes.as_flattened())?;
        prop_assert_eq!(read(&ptm.to_bytes()), Ok(ptm));
    }

    #[test]
    fn lrgb_round_trips(
        luminance in prop::collection::vec(coefficients(), 6),
        colour in prop::collection::vec(prop::array::uniform3(any::<u8>()), 6),
    ) {
        let ptm = Ptm::from_coefficients_lrgb([3, 2], &luminance, &colour).unwrap();
        let PtmModel::Lrgb { luminance: bytes, colour: colours } = ptm.model() else { panic!("{ptm:?}") };
        check(&ptm, &luminance, bytes)?;
        prop_assert_eq!(colours, &colour);
        prop_assert_eq!(read(&ptm.to_bytes()), Ok(ptm));
    }

    #[test]
    fn changed_bytes_do_not_panic(at in 0usize..300, to in any::<u8>(), light in prop::array::uniform2(-1f32..1.0)) {
        for mut bytes in [lrgb(HEADER), compressed(|words| words[6][4] = 5)] {
            let at = at % bytes.len();
            bytes[at] = to;
            if let Ok(ptm) = read(&bytes) {
                let value = ptm.value(0, light);
                prop_assert!(value.iter().all(|v| (0.0..=255.0).contains(v)), "{:?}", value);
            }
        }
    }
}

/// The example of the page.
#[test]
fn the_page_is_right() {
    let page = include_str!("../ptm.md");
    let rows = page.split("```text\n").last().unwrap().split("```").next().unwrap();
    let hex = rows.lines().flat_map(|row| row[10..58].split_whitespace());
    let bytes: Vec<u8> = hex.map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    let ptm = read(&bytes).unwrap();
    let close = |at, expected: [f32; 3]| {
        let value = ptm.value(at, [0.1, 0.2]);
        value.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 0.05)
    };
    assert!(close(1, [100.0, 50.2, 0.0]) && close(0, [100.4; 3]), "{ptm:?}");
    assert_eq!(ptm.to_bytes(), bytes);
}
