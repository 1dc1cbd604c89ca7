//! Importance-sample packs: rows and their directions, file round trips, rejected files.

use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::importance::{IMPORTANCE_ENTRY, ImportanceHeader, ImportancePack};
use brdfc_testing::packs::{Numbers, check_dump, sealed, unit_vector};

/// The pack of the page.
fn example() -> ImportancePack {
    let header = ImportanceHeader { polar: 1, azimuths: 1, samples: 2 };
    ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0], [0.6, 0.0, 0.8, 0.5]]).unwrap()
}

fn texture() -> Texture {
    Texture::from_bytes(&example().to_bytes(false)).unwrap()
}

#[test]
fn the_dump_on_the_page() {
    let bytes = example().to_bytes(false);
    assert_eq!(check_dump(include_str!("../../src/importance/spec.md"), &bytes), bytes.len().div_ceil(16));
}

#[test]
fn the_worked_value_of_the_page() {
    let (incoming, inverse) = example().sample([0.0, 0.0, 1.0], 3);
    for (found, expected) in incoming.into_iter().chain([inverse]).zip([0.96, 0.0, 0.28, 6.4]) {
        assert!((found - expected).abs() < 1e-6, "{incoming:?} {inverse}");
    }
    // Rotated to the bitangent the half vector equals the outgoing direction.
    let (incoming, inverse) = example().sample([0.0, 0.6, 0.8], 1);
    assert!((incoming[1] - 0.6).abs() < 1e-6 && (inverse - 8.0).abs() < 1e-5, "{incoming:?} {inverse}");
    // Directions below the horizon have an inverse density of 0.
    assert_eq!(example().sample([0.6, 0.0, -0.8], 0).1, 0.0);
    assert_eq!(example().sample([-0.96, 0.0, 0.28], 0).1, 4.0 * 0.28);
    assert!(example().sample([0.96, 0.0, 0.28], 1).1 > 0.0 && example().sample([0.0, 0.0, 1.0], 1).1 > 0.0);
}

#[test]
fn rows_hold_their_directions() {
    for (polar, azimuths) in [(1, 1), (64, 1), (7, 4), (32, 16), (5, 12)] {
        let header = ImportanceHeader { polar, azimuths, samples: 1 };
        for row in 0..header.rows() {
            for shift in [-0.499, 0.0, 0.499] {
                let outgoing = header.outgoing(row, shift);
                assert!((outgoing.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
                assert_eq!(header.row(outgoing.map(|c| c as f32)), row, "{header:?} {shift}");
            }
        }
        // Every direction has a row, and is less than a row's width from its centre.
        let mut numbers = Numbers::new(3);
        for _ in 0..1000 {
            let outgoing = unit_vector(&mut numbers);
            let row = header.row(outgoing);
            assert!(row < header.rows());
            if outgoing[2] > 0.0 && polar > 1 {
                let angle = header.outgoing(row, 0.0)[2].acos();
                assert!((f64::from(outgoing[2]).acos() - angle).abs() < 1.1 / f64::from(polar), "{outgoing:?}");
            }
        }
    }
    let header = ImportanceHeader { polar: 4, azimuths: 8, samples: 1 };
    let azimuth = |x: f32, y: f32| header.row([x, y, 0.9]) % 8;
    assert_eq!([(0.4, 0.1), (0.1, 0.4), (-0.1, 0.4), (-0.4, 0.1)].map(|(x, y)| azimuth(x, y)), [0, 1, 2, 3]);
    assert_eq!([(-0.4, -0.1), (-0.1, -0.4), (0.1, -0.4), (0.4, -0.1)].map(|(x, y)| azimuth(x, y)), [4, 5, 6, 7]);
}

#[test]
fn files_round_trip() {
    for (polar, azimuths, samples) in [(1, 1, 1), (3, 1, 7), (2, 8, 5)] {
        let header = ImportanceHeader { polar, azimuths, samples };
        let mut numbers = Numbers::new(9);
        let texel = |_| {
            let [x, y, z] = unit_vector(&mut numbers);
            [x, y, z.abs(), 0.5]
        };
        let pack = ImportancePack::new(header, (0..header.rows() * samples).map(texel).collect()).unwrap();
        for supercompress in [false, true] {
            assert_eq!(ImportancePack::from_bytes(&pack.to_bytes(supercompress)).unwrap(), pack);
        }
        assert_eq!(pack.gpu_bytes(), 16 * u64::from(header.rows() * samples));
    }
}

#[test]
fn truncated_and_corrupt_files_do_not_panic() {
    for supercompress in [false, true] {
        let bytes = example().to_bytes(supercompress);
        for length in 0..bytes.len() {
            let cut = sealed(bytes[..length].to_vec());
            assert!(ImportancePack::from_bytes(&cut).is_err(), "{length} of {}", bytes.len());
        }
        let mut broken = bytes.clone();
        for offset in 0..bytes.len() {
            for pattern in [1, 4, 64, 128, 0x7f, 0xff] {
                broken[offset] = bytes[offset] ^ pattern;
                if let Ok(pack) = ImportancePack::from_bytes(&sealed(broken.clone())) {
                    let (incoming, inverse) = pack.sample([0.3, -0.4, 0.866_025_4], 1);
                    assert!(incoming.iter().all(|c| c.is_finite()) && inverse >= 0.0);
                }
            }
            broken[offset] = bytes[offset];
        }
    }
}

#[test]
fn errors_name_the_field() {
    let error = |texture: &Texture| ImportancePack::from_texture(texture).unwrap_err().to_string();
    let with_word = |at: usize, word: u32| {
        let mut texture = texture();
        texture.entries.get_mut(IMPORTANCE_ENTRY).unwrap()[4 * at..][..4].copy_from_slice(&word.to_le_bytes());
        error(&texture)
    };
    for (at, word, expected) in [
        (0, 2, "brdfc.importance version: found 2, expected 1"),
        (1, 0, "brdfc.importance polar rows: found 0, expected 1 to 1024"),
        (2, 3, "brdfc.importance azimuth columns: found 3, expected 1, or a multiple of 4"),
        (2, 300, "brdfc.importance azimuth columns: found 300, expected 1 to 256"),
        (3, 0, "brdfc.importance samples: found 0, expected 1 to 8192"),
        (3, u32::MAX, "brdfc.importance samples: found 4294967295, expected 1 to 8192"),
        (4, 0, "brdfc.importance isotropic: found 0, expected 1"),
    ] {
        assert_eq!(with_word(at, word), expected);
    }
    assert!(with_word(3, 3).starts_with("texture: found 2 x 1 texels of Rgba32Float, expected 3 x 1"));
    let rows = ImportanceHeader { polar: 1024, azimuths: 16, samples: 1 }.check().unwrap_err().to_string();
    assert_eq!(rows, "brdfc.importance rows: found 16384, expected 1 to 8192");
    let with_texel = |at: usize, value: f32| {
        let mut texture = texture();
        texture.texels[4 * at..][..4].copy_from_slice(&value.to_le_bytes());
        error(&texture)
    };
    for (at, value) in [(2, -1.0), (0, 0.01), (3, 0.0), (3, -1.0), (3, f32::NAN), (3, f32::INFINITY), (1, f32::NAN)] {
        let text = with_texel(at, value);
        assert!(text.starts_with("importance texel (0, 0): found ["), "{text}");
    }
    assert!(with_texel(4, f32::NAN).starts_with("importance texel (1, 0)"));
    let mut other = texture();
    other.format = TexelFormat::Rgba16Float;
    other.texels.truncate(16);
    assert!(error(&other).contains("Rgba16Float"));
    other = texture();
    other.entries.clear();
    assert!(error(&other).starts_with("brdfc.importance: no brdfc keys"), "{}", error(&other));
    other = texture();
    other.extent = Extent::D2Array([2, 1, 1]);
    assert!(error(&other).starts_with("texture: found 1 layers of 2 x 1"), "{}", error(&other));
    assert!(ImportancePack::new(example().header(), vec![[0.0, 0.0, 1.0, 1.0]]).is_err());
}
