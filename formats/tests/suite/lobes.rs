//! Lobes of BRDFs: look-ups, file round trips, rejected files.

use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::lobes::{Anchor, LOBES_ENTRY, Lobe, LobesHeader, LobesPack};
use brdfc_testing::codec::TestedCodec;
use brdfc_testing::codecs::lobes::Lobes;
use brdfc_testing::packs::{check_dump, rebind, sealed};

/// The header of the page.
fn header() -> LobesHeader {
    let lobe = |anchor, across, row| Lobe { anchor, tilt: [0.0, across], row };
    let lobes = vec![lobe(Anchor::Normal, 0.0, 0), lobe(Anchor::Mirror, 0.25, 1), lobe(Anchor::Mirror, -0.25, 1)];
    LobesHeader { nodes: 2, azimuths: 1, rows: 2, scale: 1.0, delta_e: [0.75, 2.5], lobes }
}

const WEIGHTS: [[f32; 4]; 4] =
    [[0.5, 0.5, 0.5, 0.0], [0.5, 0.5, 0.5, 0.0], [0.125, 0.125, 0.125, 3.0], [0.25, 0.25, 0.25, 3.0]];

/// Weights turn with the azimuth of the view, lobes do not.
#[test]
fn lobes_of_anisotropic_materials_stay_with_the_tangent() {
    let lobe = |tilt| Lobe { anchor: Anchor::Mirror, tilt, row: 0 };
    let lobes = vec![lobe([0.0, 0.0]), lobe([0.0, 0.2])];
    let header = LobesHeader { nodes: 2, azimuths: 4, rows: 1, scale: 1.0, delta_e: [0.0; 2], lobes };
    let weight = |azimuth: usize| [azimuth as f32, 1.0, 0.5, 2.0];
    let weights: Vec<[f32; 4]> = (0..4).flat_map(|azimuth| [weight(azimuth); 2]).collect();
    let pack = LobesPack::new(header, &weights).unwrap();
    let red = |x: f32, y: f32| pack.lookup([x, y, (1.0 - x * x - y * y).sqrt()], 0).weight[0];
    let expected = [(0.5, 0.0, 0.0), (0.5, 0.5, 0.5), (0.0, 0.5, 1.0), (-0.5, 0.0, 2.0), (0.0, -0.5, 3.0)];
    for (x, y, expected) in expected {
        assert!((red(x, y) - expected).abs() < 1e-6, "{x} {y}: {}", red(x, y));
    }
    // From the last azimuth to the first.
    assert!((red(0.3, -0.3) - 1.5).abs() < 1e-6);
    // The tilt is along the bitangent, for all views.
    let half = |outgoing: [f32; 3]| {
        let sum = [0, 1, 2].map(|k| pack.lookup(outgoing, 1).direction[k] + outgoing[k]);
        [sum[0] / sum[2], sum[1] / sum[2]]
    };
    for outgoing in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.48, 0.36, 0.8]] {
        let [along, across] = half(outgoing);
        assert!(along.abs() < 1e-6 && (across - 0.2).abs() < 1e-6, "{outgoing:?}: {along} {across}");
    }
}

/// The pack of the page.
fn example() -> LobesPack {
    LobesPack::new(header(), &WEIGHTS).unwrap()
}

fn texture() -> Texture {
    Texture::from_bytes(&example().to_bytes(false)).unwrap()
}

fn error(texture: &Texture) -> String {
    LobesPack::from_bytes(&sealed(texture.to_bytes(false))).unwrap_err().to_string()
}

#[test]
fn the_dump_on_the_page() {
    let bytes = example().to_bytes(false);
    assert_eq!(check_dump(include_str!("../../src/lobes/spec.md"), &bytes), 40);
    assert_eq!(LobesPack::from_bytes(&bytes).unwrap(), example());
}

#[test]
fn the_worked_value_of_the_page() {
    let near = |found: &[f32], expected: &[f32]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
    };
    // 60 degrees from the normal.
    let look = example().lookup([0.0, 0.75f32.sqrt(), 0.5], 1);
    near(&look.direction, &[-0.235_294, -0.866_025, 0.441_176]);
    near(&look.weight, &[0.213_388; 3]);
    near(&[look.sharpness], &[3.0]);
    // Its twin is on the other side of the plane of view, and both have one weight.
    let twin = example().lookup([0.0, 0.75f32.sqrt(), 0.5], 2);
    near(&twin.direction, &[0.235_294, -0.866_025, 0.441_176]);
    assert_eq!((twin.weight, twin.sharpness), (look.weight, look.sharpness));
    // At the normal and at the horizon weights are those of the nodes; below the horizon those of the horizon.
    assert_eq!(example().lookup([0.0, 0.0, 1.0], 1).weight, [0.125; 3]);
    assert_eq!(example().lookup([1.0, 0.0, 0.0], 1).weight, [0.25; 3]);
    assert_eq!(example().lookup([0.6, 0.0, -0.8], 1).weight, [0.25; 3]);
}

#[test]
fn the_scale_multiplies_weights_alone() {
    let scaled = LobesPack::new(LobesHeader { scale: 4.0, ..header() }, &WEIGHTS).unwrap();
    let (look, other) = (example().lookup([0.0, 0.75f32.sqrt(), 0.5], 1), scaled.lookup([0.0, 0.75f32.sqrt(), 0.5], 1));
    assert_eq!(other.weight, look.weight.map(|c| 4.0 * c));
    assert_eq!((other.direction, other.sharpness), (look.direction, look.sharpness));
}

#[test]
fn files_round_trip() {
    for case in Lobes.cases() {
        let pack = LobesPack::from_bytes(&case.files[0]).unwrap();
        for supercompress in [false, true] {
            assert_eq!(LobesPack::from_bytes(&pack.to_bytes(supercompress)).unwrap(), pack);
        }
        let header = pack.header();
        assert_eq!(pack.gpu_bytes(), 8 * u64::from(header.nodes * header.azimuths * header.rows));
        assert_eq!(pack.fetches(), header.lobes.len());
        let anchors = |anchor| header.lobes.iter().filter(|lobe| lobe.anchor == anchor).count();
        assert!(pack.fetches() < 7 || Anchor::ALL.map(anchors).iter().all(|count| *count > 0));
        // New packs have the same rounded weights.
        assert_eq!(LobesPack::new(header.clone(), pack.weights()).unwrap(), pack);
    }
}

#[test]
fn truncated_and_corrupt_files_do_not_panic() {
    for supercompress in [false, true] {
        let bytes = example().to_bytes(supercompress);
        for length in 0..bytes.len() {
            let cut = sealed(bytes[..length].to_vec());
            assert!(LobesPack::from_bytes(&cut).is_err(), "{length} of {}", bytes.len());
        }
        let mut broken = bytes.clone();
        for offset in 0..bytes.len() {
            for pattern in [1, 4, 64, 128, 0x7f, 0xff] {
                broken[offset] = bytes[offset] ^ pattern;
                let Ok(pack) = LobesPack::from_bytes(&sealed(broken.clone())) else { continue };
                for lobe in 0..pack.fetches() {
                    let look = pack.lookup([0.3, -0.4, 0.866_025_4], lobe);
                    let length = look.direction.iter().map(|c| c * c).sum::<f32>();
                    assert!((length - 1.0).abs() < 1e-5 && (0.0..=9.0).contains(&look.sharpness), "{look:?}");
                    assert!(look.weight.iter().all(|c| c.is_finite() && *c >= 0.0), "{look:?}");
                }
            }
            broken[offset] = bytes[offset];
        }
    }
}

#[test]
fn errors_name_the_field() {
    let with_word = |at: usize, word: u32| {
        let mut texture = texture();
        texture.entries.get_mut(LOBES_ENTRY).unwrap()[4 * at..][..4].copy_from_slice(&word.to_le_bytes());
        error(&texture)
    };
    for (at, word, expected) in [
        (0, 3, "brdfc.lobes version: found 3, expected 2"),
        (1, 1, "brdfc.lobes nodes: found 1, expected 2 to 64"),
        (1, u32::MAX, "brdfc.lobes nodes: found 4294967295, expected 2 to 64"),
        (2, 0, "brdfc.lobes azimuths: found 0, expected 1 to 32"),
        (2, 33, "brdfc.lobes azimuths: found 33, expected 1 to 32"),
        (3, 0, "brdfc.lobes rows: found 0, expected 1 to 3"),
        (3, 4, "brdfc.lobes rows: found 4, expected 1 to 3"),
        (4, 0, "brdfc.lobes scale: found 0, expected 0.00000000000000000010842022 to 9223372000000000000"),
        (
            4,
            f32::NAN.to_bits(),
            "brdfc.lobes scale: found NaN, expected 0.00000000000000000010842022 to 9223372000000000000",
        ),
        (5, (-1f32).to_bits(), "brdfc.lobes ΔE: found -1, expected 0 to 340282350000000000000000000000000000000"),
        (6, f32::NAN.to_bits(), "brdfc.lobes ΔE: found NaN, expected 0 to 340282350000000000000000000000000000000"),
        (7, 17f32.to_bits(), "brdfc.lobes tilt of lobe 0: found 17, expected -16 to 16"),
        (12, f32::NAN.to_bits(), "brdfc.lobes tilt of lobe 1: found NaN, expected -16 to 16"),
        (12, f32::NEG_INFINITY.to_bits(), "brdfc.lobes tilt of lobe 1: found -inf, expected -16 to 16"),
        (17, 3, "brdfc.lobes anchor of lobe 2: found 3, expected 0 to 2"),
        (18, 2, "brdfc.lobes row of lobe 2: found 2, expected 0 to 1"),
    ] {
        assert_eq!(with_word(at, word), expected);
    }
    let text = with_word(1, 3);
    assert!(text.starts_with("texture: found 2 x 2 texels of Rgba16Float, expected 3 x 2"), "{text}");
    // The block of the shader no longer follows from the header.
    assert!(with_word(18, 0).contains("lobes_parameters"), "{}", with_word(18, 0));
    for (length, found) in [(0, 0), (28, 28), (43, 43), (77, 77), (28 + 16 * 33, 556)] {
        let mut other = texture();
        other.entries.get_mut(LOBES_ENTRY).unwrap().resize(length, 0);
        let allowed = "28 bytes and 16 for each of 1 to 32 lobes";
        assert_eq!(error(&other), format!("brdfc.lobes: found {found} bytes, expected {allowed}"));
    }
}

#[test]
fn errors_name_the_texel() {
    let with_half = |at: usize, half: u16| {
        let mut texture = texture();
        texture.texels[2 * at..][..2].copy_from_slice(&half.to_le_bytes());
        error(&texture)
    };
    const NAN: u16 = 0x7e00;
    const INFINITY: u16 = 0x7c00;
    const MINUS_ONE: u16 = 0xbc00;
    const TEN: u16 = 0x4900;
    let allowed = "expected weights of 0 to 65504, and a sharpness of 0 to 9";
    for (at, half, place, found) in [
        (0, NAN, "(0, 0)", "[NaN, 0.5, 0.5, 0]"),
        (1, INFINITY, "(0, 0)", "[0.5, inf, 0.5, 0]"),
        (6, MINUS_ONE, "(1, 0)", "[0.5, 0.5, -1, 0]"),
        (11, TEN, "(0, 1)", "[0.125, 0.125, 0.125, 10]"),
        (15, MINUS_ONE, "(1, 1)", "[0.25, 0.25, 0.25, -1]"),
        (15, NAN, "(1, 1)", "[0.25, 0.25, 0.25, NaN]"),
    ] {
        assert_eq!(with_half(at, half), format!("lobes texel {place}: found {found}, {allowed}"));
    }
    let mut other = texture();
    other.extent = Extent::D2Array([2, 2, 1]);
    rebind(&mut other, "texture file 2d ", "texture file 2d-array ");
    assert!(error(&other).starts_with("texture: found 1 layers of 2 x 2"), "{}", error(&other));
    other = texture();
    other.format = TexelFormat::Rgba16Unorm;
    rebind(&mut other, "rgba16float", "rgba16unorm");
    assert!(error(&other).starts_with("texture: found 2 x 2 texels of Rgba16Unorm"), "{}", error(&other));
}

#[test]
fn invalid_weights_are_rejected() {
    let error = |weights: &[[f32; 4]]| LobesPack::new(header(), weights).unwrap_err().to_string();
    assert_eq!(error(&WEIGHTS[..3]), "lobes texels: found 3, expected 4, as the header says");
    for (channel, value) in
        [(0, f32::NAN), (1, f32::INFINITY), (2, -1e-3), (0, 7e4), (3, 9.5), (3, -1.0), (3, f32::NAN)]
    {
        let mut weights = WEIGHTS;
        weights[2][channel] = value;
        assert!(error(&weights).starts_with("lobes texel (0, 1): found ["), "{}", error(&weights));
    }
    let with = |change: fn(&mut LobesHeader)| {
        let mut header = header();
        change(&mut header);
        LobesPack::new(header, &WEIGHTS).unwrap_err().to_string()
    };
    assert_eq!(with(|header| header.lobes.clear()), "brdfc.lobes lobes: found 0, expected 1 to 32");
    assert_eq!(
        with(|header| header.lobes = vec![header.lobes[0]; 33]),
        "brdfc.lobes lobes: found 33, expected 1 to 32"
    );
    assert_eq!(with(|header| header.nodes = 65), "brdfc.lobes nodes: found 65, expected 2 to 64");
}
