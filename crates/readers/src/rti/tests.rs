use super::*;
use proptest::prelude::*;

const HEADER: &str = "#HSH1.2\r\n3\r\n2 1 3\r\n4 2 1\r\n";

/// Two pixels of 4 terms: bytes 0 to 23, scales 255, 510, 765, 1020 and biases 1 to 4.
fn file(header: &str) -> Vec<u8> {
    let numbers = (1..=4).map(|k| 255.0 * k as f32).chain((1..=4).map(|k| k as f32));
    let numbers = numbers.flat_map(f32::to_le_bytes);
    header.bytes().chain(numbers).chain(0..24).collect()
}

fn message(bytes: &[u8]) -> String {
    Rti::from_bytes(bytes).unwrap_err().to_string()
}

/// Known answer: the formulas of RTIViewer at cos θ = 0.64, where sqrt(cos θ - cos² θ) = 0.48, cos φ = 0.6 and
/// sin φ = 0.8, computed by hand.
#[test]
fn harmonics_are_those_of_viewers() {
    let expected = [
        // 1/√2π; √(6/π) 0.48 cos φ, √(3/2π) (2 cos θ - 1), √(6/π) 0.48 sin φ.
        0.398942, 0.398009, 0.193477, 0.530679,
        // √(30/π) cos 2φ (-0.2304), √(30/π) cos φ 0.28 0.48, √(5/2π) (1 - 6 0.2304), …
        0.199355, 0.249193, -0.341125, 0.332258, -0.683501,
        // 2 √(35/π) cos 3φ 0.2304^1.5, √(210/π) cos 2φ 0.28 (-0.2304), …
        -0.691017, 0.147684, -0.226361, -0.385385, -0.301814, -0.506345, 0.259870,
    ];
    let sine = (1.0f32 - 0.64 * 0.64).sqrt();
    let light = [0.6 * sine, 0.8 * sine, 0.64];
    for (degree, terms) in [(1, 4), (2, 9), (3, 16)] {
        let found = harmonics(degree, light);
        assert_eq!(found.len(), terms);
        for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() < 2e-6, "{k}: {found} {expected}");
        }
    }
    // Negative control: without the factor of each term they differ.
    let plain = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 1 }.evaluate(light);
    assert!((f64::from(plain[0]) - expected[0]).abs() > 0.5);
}

#[test]
fn channels_follow_each_other_in_a_pixel() {
    let rti = Rti::from_bytes(&file(HEADER)).unwrap();
    assert_eq!((ViewerFile::size(&rti), rti.degree(), rti.bias()), ([2, 1], 1, &[1.0, 2.0, 3.0, 4.0][..]));
    let light = [0.3, -0.4, 0.75f32.sqrt()];
    let harmonics = harmonics(1, light);
    for (pixel, channel) in [(0, 0), (0, 2), (1, 1)] {
        let first = 4 * (3 * pixel + channel);
        let value = |k: usize| ((first + k) as f64 * (k + 1) as f64 + (k + 1) as f64) * harmonics[k];
        let expected = 255.0 * (0..4).map(value).sum::<f64>();
        let found = rti.under(light)(pixel)[channel];
        assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
    }
}

#[test]
fn headers_as_programs_write_them() {
    let expected = Rti::from_bytes(&file(HEADER)).unwrap();
    for header in [
        "#HSH1.2\n3\n2 1 3\n4 2 1\n",
        "3\n2 1 3\n4 2 1\n",
        "#HSH1.2\n# made by hand\n3\n2 1 3\n4 2 1 \n",
        "#HSH1.2\r\n3\r\n2 1 3\r\n1 2 1\r\n",
    ] {
        assert_eq!(Rti::from_bytes(&file(header)).as_ref(), Ok(&expected), "{header}");
    }
}

#[test]
fn headers_that_are_wrong() {
    for (old, new, expected) in [
        ("\n3", "\n4", "line 2, type: found 4 (adaptive basis functions), expected 3 (hemispherical harmonics)"),
        ("\n3", "\n1", "line 2, type: found 1 (polynomials), expected 3"),
        ("\n3", "\n77", "line 2, type: found \"77\", expected 3"),
        ("2 1 3", "0 1 3", "line 3, width: found \"0\", expected 1 to 65536"),
        ("2 1 3", "2 +1 3", "line 3, height: found \"+1\", expected 1 to 65536"),
        ("2 1 3", "2 65537 3", "line 3, height: found \"65537\""),
        ("2 1 3", "2 1 1", "line 3, colours: found \"1\", expected 3"),
        ("4 2 1", "5 2 1", "line 4, terms: found \"5\", expected 4, 9 or 16, or 1 or 2 for 4 or 9"),
        ("4 2 1", "4 1 1", "line 4, basis type: found 1 (LRGB), expected 2 (RGB)"),
        ("4 2 1", "4 2 4", "line 4, element size: found 4 (floats), expected 1 byte"),
        ("4 2 1", "4 2 1 x", "line 4, header: found byte 0x78, expected a line end after the element size"),
        (
            "4 2 1",
            "9 2 1",
            "file length: found 56 bytes after the header, expected 126: 9 scales and biases, then 2 x 1",
        ),
        ("2 1 3", "65536 65536 3", "file length: found 56 bytes after the header, expected 51539607584"),
    ] {
        let found = message(&file(&HEADER.replacen(old, new, 1)));
        assert!(found.starts_with(expected), "{new}: {found}");
    }
    let mut bytes = file(HEADER);
    bytes[HEADER.len() + 16..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(message(&bytes), "byte 42, bias: found NaN, expected a finite number");
    assert!(message(b"").starts_with("line 1, type: end of data; expected a header of 7 numbers"));
    assert!(message(b"#HSH1.2").starts_with("line 2, type: end of data"));
}

#[test]
fn files_that_are_cut_or_longer() {
    let whole = file(HEADER);
    assert!((0..whole.len()).all(|length| Rti::from_bytes(&whole[..length]).is_err()));
    assert!(Rti::from_bytes(&[&whole[..], &[0]].concat()).is_err());
}

proptest! {
    #[test]
    fn changed_bytes_do_not_panic(at in 0usize..100, to in any::<u8>(), x in -0.7f32..0.7, y in -0.7f32..0.7) {
        let mut bytes = file(HEADER);
        let at = at % bytes.len();
        bytes[at] = to;
        if let Ok(rti) = Rti::from_bytes(&bytes) {
            let levels = rti.under([x, y, (1.0 - x * x - y * y).max(0.0).sqrt()])(0);
            prop_assert!(levels.iter().all(|level| level.is_finite()), "{:?}", levels);
        }
    }
}

/// The example of the page.
#[test]
fn the_page_is_right() {
    let page = include_str!("../rti.md");
    let rows = page.split("```text\n").last().unwrap().split("```").next().unwrap();
    let hex = rows.lines().flat_map(|row| row[10..58].split_whitespace());
    let bytes: Vec<u8> = hex.map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    let rti = Rti::from_bytes(&bytes).unwrap();
    let levels = rti.under([0.0, 0.0, 1.0])(0);
    for (found, expected) in levels.into_iter().zip([203.5, 102.1, 0.0]) {
        assert!((found - expected).abs() < 0.05, "{levels:?}");
    }
}
