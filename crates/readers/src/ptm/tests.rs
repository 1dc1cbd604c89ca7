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

fn message(bytes: &[u8]) -> String {
    Ptm::from_bytes(bytes).unwrap_err().to_string()
}

#[test]
fn rows_run_from_the_bottom_and_colours_follow_all_coefficients() {
    let ptm = Ptm::from_bytes(&lrgb(HEADER)).unwrap();
    assert_eq!((ptm.size(), ptm.scale()[5], ptm.bias()), ([2, 2], 0.5, [160, 160, 160, 127, 127, 0]));
    let PtmModel::Lrgb { luminance, colour } = ptm.model() else { panic!("{ptm:?}") };
    assert_eq!(luminance.iter().map(|bytes| bytes[5]).collect::<Vec<_>>(), [102, 103, 100, 101]);
    assert_eq!(colour, &[[12, 22, 32], [13, 23, 33], [10, 20, 30], [11, 21, 31]]);
    // 101 / 2 times the colour, under any light.
    assert_eq!(ptm.value(3, [0.3, -0.9]), [11.0, 21.0, 31.0].map(|code: f32| 50.5 * code / 255.0));
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
    let ptm = Ptm::from_bytes(&bytes).unwrap();
    let PtmModel::Rgb(pixels) = ptm.model() else { panic!("{ptm:?}") };
    assert_eq!(pixels[1], [[6, 7, 8, 9, 10, 11], [18, 19, 20, 21, 22, 23], [30, 31, 32, 33, 34, 35]]);
    assert_eq!(ptm.value(1, [0.0, 0.0]), [11.0, 23.0, 35.0]);
}

#[test]
fn headers_have_line_ends_where_they_like() {
    let expected = Ptm::from_bytes(&lrgb(HEADER)).unwrap();
    for header in [
        "PTM_1.2\nPTM_FORMAT_LRGB\n2 2\n2 2 2 2 2 0.5 160 160 160 127 127 0\n",
        "PTM_1.2 \nPTM_FORMAT_LRGB \n2\n2\n2.0 2.0 2.0 2e0 2.0 0.5 \n160 160 160 127 127 0 \n",
        "PTM_1.2\r\nPTM_FORMAT_LRGB\r\n2\r\n2\r\n2 2 2 2 2 0.5\r\n160.0 160 160 127 127 -0\r\n",
    ] {
        assert_eq!(Ptm::from_bytes(&lrgb(header)).as_ref(), Ok(&expected), "{header}");
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
        ("PTM_1.2", "PTM_1.1", "line 1, version: found \"PTM_1.1\", expected PTM_1.2"),
        (
            "PTM_FORMAT_LRGB",
            "PTM_FORMAT_JPEG_RGB",
            "line 2, format: found the unsupported \"PTM_FORMAT_JPEG_RGB\", expected PTM_FORMAT_RGB or PTM_FORMAT_LRGB",
        ),
        ("PTM_FORMAT_LRGB", "RGB", "line 2, format: found \"RGB\", expected PTM_FORMAT_RGB"),
        ("\n2\n2\n", "\n0\n2\n", "line 3, width: found \"0\", expected 1 to 65536"),
        ("\n2\n2\n", "\n2\n-2\n", "line 4, height: found \"-2\""),
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
            assert!(Ptm::from_bytes(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
        }
        assert!(Ptm::from_bytes(&[&bytes[..], &[0]].concat()).is_err());
        assert!(Ptm::from_bytes(&bytes).is_ok());
    }
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
        prop_assert_eq!(Ptm::from_bytes(&ptm.to_bytes()), Ok(ptm));
    }

    #[test]
    fn lrgb_round_trips(
        luminance in prop::collection::vec(coefficients(), 6),
        colour in prop::collection::vec(prop::array::uniform3(any::<u8>()), 6),
    ) {
        let ptm = Ptm::from_coefficients_lrgb([3, 2], &luminance, &colour).unwrap();
        let PtmModel::Lrgb { luminance: bytes, colour: read } = ptm.model() else { panic!("{ptm:?}") };
        check(&ptm, &luminance, bytes)?;
        prop_assert_eq!(read, &colour);
        prop_assert_eq!(Ptm::from_bytes(&ptm.to_bytes()), Ok(ptm));
    }

    #[test]
    fn changed_bytes_do_not_panic(at in 0usize..100, to in any::<u8>(), light in prop::array::uniform2(-1f32..1.0)) {
        let mut bytes = lrgb(HEADER);
        let at = at % bytes.len();
        bytes[at] = to;
        if let Ok(ptm) = Ptm::from_bytes(&bytes) {
            let value = ptm.value(0, light);
            prop_assert!(value.iter().all(|v| (0.0..=255.0).contains(v)), "{:?}", value);
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
    let ptm = Ptm::from_bytes(&bytes).unwrap();
    let close = |at, expected: [f32; 3]| {
        let value = ptm.value(at, [0.1, 0.2]);
        value.iter().zip(expected).all(|(value, expected)| (value - expected).abs() < 0.05)
    };
    assert!(close(1, [100.0, 50.2, 0.0]) && close(0, [100.4; 3]), "{ptm:?}");
    assert_eq!(ptm.to_bytes(), bytes);
}
