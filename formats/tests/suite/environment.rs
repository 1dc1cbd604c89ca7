//! Prefiltered environments: look-ups, file round trips, rejected files.

use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::environment::cube::FacePoint;
use brdfc_formats::environment::{ENVIRONMENT_ENTRY, EnvironmentDecoder, EnvironmentHeader, EnvironmentPack};
use brdfc_testing::codecs::environment::noisy;
use brdfc_testing::packs::{Numbers, check_dump, read_texture, rebind, sealed};

/// The pack of the page.
fn example() -> EnvironmentPack {
    noisy(8, 0.0, |_| [1.0, 0.5, 0.25])
}

fn texture() -> Texture {
    read_texture(&example().to_bytes(false)).unwrap()
}

fn error(texture: &Texture) -> String {
    EnvironmentPack::from_bytes(&sealed(texture.to_bytes(false))).unwrap_err().to_string()
}

/// A direction of any length, all over the sphere.
fn direction(numbers: &mut Numbers) -> [f32; 3] {
    loop {
        let direction = [0; 3].map(|_| numbers.between(-2.0, 2.0) as f32);
        if direction.iter().map(|c| c * c).sum::<f32>() > 1e-3 {
            return direction;
        }
    }
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max)
}

#[test]
fn the_dump_on_the_page() {
    let bytes = example().to_bytes(false);
    assert_eq!(check_dump(include_str!("../../src/environment/spec.md"), &bytes), 65);
    assert_eq!(EnvironmentPack::from_bytes(&bytes).unwrap(), example());
}

#[test]
fn constant_environments_are_constant() {
    let mut numbers = Numbers::new(1);
    for (side, radiance) in [(8, [1.0, 0.5, 0.25]), (64, [3e5, 1e5, 0.0])] {
        let decoder = EnvironmentDecoder::new(&noisy(side, 0.0, |_| radiance.map(f64::from)));
        let expected = decoder.radiance([0.0, 1.0, 0.0], 0.0);
        assert!(distance(expected, radiance) <= radiance[0] / 512.0, "{expected:?}");
        for _ in 0..10_000 {
            let (direction, sharpness) = (direction(&mut numbers), numbers.between(-2.0, 9.0) as f32);
            let found = decoder.radiance(direction, sharpness);
            assert!(distance(found, expected) <= 1e-6 * expected[0], "{direction:?} {sharpness}: {found:?}");
        }
        for direction in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, 0.0], [0.0, 0.0, -1e-30], [0.0, 1e30, 0.0]] {
            assert!(distance(decoder.radiance(direction, 0.5), expected) <= 1e-6 * expected[0], "{direction:?}");
        }
    }
}

/// A random environment, whose neighbours differ by up to 2: the largest change over a step is the same across edges as
/// inside faces.
#[test]
fn look_ups_are_continuous_across_edges() {
    const STEP: f64 = 1e-4;
    let decoder = EnvironmentDecoder::new(&noisy(16, 1.0, |_| [1.0; 3]));
    let mut numbers = Numbers::new(2);
    let [mut inside, mut across, mut faces] = [0.0f32, 0.0, 0.0];
    for sharpness in [0.0, 1.0, 1.4, 2.0] {
        for _ in 0..5000 {
            let face = numbers.bits() as usize % 6;
            let [s, t] = [0; 2].map(|_| numbers.between(-0.999, 0.999));
            let is_along_columns = numbers.bits().is_multiple_of(2);
            let look = |s: f64| {
                let [a, b] = if is_along_columns { [s, t] } else { [t, s] };
                let direction = FacePoint { face, s: a, t: b }.direction().map(|c| c as f32);
                (decoder.radiance(direction, sharpness), FacePoint::of(direction.map(f64::from)).face)
            };
            let [(left, first), (right, second)] = [s, s + STEP].map(look);
            assert_eq!((first, second), (face, face));
            inside = inside.max(distance(left, right));
            let edge = 1f64.copysign(s);
            let [(left, first), (right, second)] = [edge * (1.0 - 0.5 * STEP), edge * (1.0 + 0.5 * STEP)].map(look);
            assert_ne!(first, second);
            across = across.max(distance(left, right));
            // The negative control: the same place on the opposite side of a face.
            let (other, _) = look(-edge * (1.0 - 0.5 * STEP));
            faces = faces.max(distance(left, other));
        }
    }
    println!("largest change inside {inside}, across {across}, to another face {faces}");
    // Neighbours differ by up to 2, over 1/8 of the coordinates of the finest level.
    assert!(inside < 5e-3 && across < 5e-3 && across > 1e-4 && faces > 0.5, "{inside} {across} {faces}");
}

/// Texel centres of each level return the texels, in the order of the page.
#[test]
fn texel_centres_return_their_texels() {
    let pack = noisy(16, 0.9, |[x, y, z]| [2.0 + x, 2.0 + y, 2.0 + z]);
    let decoder = EnvironmentDecoder::new(&pack);
    for level in 0..pack.header().levels() {
        let side = 16 >> level;
        for (at, texel) in pack.level(level).enumerate() {
            let centre = [at % side, at / side % side].map(|place| place as f64 + 0.5);
            let direction = FacePoint::on_grid(at / (side * side), side, centre).direction().map(|c| c as f32);
            let found = decoder.radiance(direction, (2 - level) as f32);
            assert!(distance(found, texel) < 1e-5, "level {level}, texel {at}: {found:?} {texel:?}");
        }
    }
    for (at, texel) in pack.irradiance().enumerate() {
        let centre = [at % 16, at / 16 % 16].map(|place| place as f64 + 0.5);
        let direction = FacePoint::on_grid(at / 256, 16, centre).direction().map(|c| c as f32);
        assert!(distance(decoder.radiance(direction, 0.0), texel) < 1e-5, "irradiance, texel {at}");
    }
    // Half a level is the mean of two; beyond the ends nothing changes.
    let at = |sharpness: f32| decoder.radiance([0.3, -0.7, 0.2], sharpness);
    for lower in [0.0, 1.0] {
        let [below, above] = [at(lower), at(lower + 1.0)];
        let mean = [0, 1, 2].map(|k| 0.5 * (below[k] + above[k]));
        assert!(distance(at(lower + 0.5), mean) < 1e-6 && distance(below, above) > 0.01);
    }
    assert_eq!([at(-3.0), at(7.5)], [at(0.0), at(2.0)]);
}

#[test]
fn files_round_trip() {
    for (side, brightness) in [(8, 1e-3), (32, 1.0), (16, 1e9)] {
        let pack = noisy(side, 0.9, |_| [brightness, 0.5 * brightness, 0.1 * brightness]);
        for supercompress in [false, true] {
            assert_eq!(EnvironmentPack::from_bytes(&pack.to_bytes(supercompress)).unwrap(), pack);
        }
        assert_eq!(pack.gpu_bytes(), 32 * u64::from(side * side) + 5632);
        let largest = pack.level(0).flatten().fold(0.0, f32::max);
        assert!((f64::from(largest) / brightness - 1.85).abs() < 0.1, "{largest}");
    }
    assert_eq!(example().header(), EnvironmentHeader { side: 8, scale: 2f32.powi(-15) });
    for (brightness, scale) in [(65408.0, 1.0), (65409.0, 2.0), (32704.0, 0.5), (1e-35, 2f32.powi(-100)), (0.0, 1.0)] {
        assert_eq!(noisy(8, 0.0, |_| [brightness; 3]).header().scale, scale, "{brightness}");
    }
    // Moonlight retains its digits.
    let dim = noisy(8, 0.0, |_| [3e-7, 2e-7, 1e-7]);
    let found = EnvironmentDecoder::new(&dim).radiance([0.0, 1.0, 0.0], 1.0);
    assert!(distance(found, [3e-7, 2e-7, 1e-7]) < 1e-9, "{found:?}");
}

#[test]
fn truncated_and_corrupt_files_do_not_panic() {
    let bytes = example().to_bytes(false);
    for length in (0..bytes.len()).step_by(7) {
        let cut = sealed(bytes[..length].to_vec());
        assert!(EnvironmentPack::from_bytes(&cut).is_err(), "{length} of {}", bytes.len());
    }
    let mut broken = bytes.clone();
    for offset in 0..bytes.len() {
        for pattern in [1, 64, 128, 0xff] {
            broken[offset] = bytes[offset] ^ pattern;
            if let Ok(pack) = EnvironmentPack::from_bytes(&sealed(broken.clone())) {
                let found = EnvironmentDecoder::new(&pack).radiance([0.3, -0.4, 0.866], 0.3);
                assert!(found.iter().all(|c| c.is_finite() && *c >= 0.0), "{offset} {pattern}: {found:?}");
            }
        }
        broken[offset] = bytes[offset];
    }
}

#[test]
fn errors_name_the_field() {
    let with_word = |at: usize, word: u32| {
        let mut texture = texture();
        texture.entries.get_mut(ENVIRONMENT_ENTRY).unwrap()[4 * at..][..4].copy_from_slice(&word.to_le_bytes());
        error(&texture)
    };
    let side = |found: u32| format!("brdfc.environment side: found {found}, expected a power of two, 8 to 2048");
    for found in [0, 4, 12, 4096, u32::MAX] {
        assert_eq!(with_word(1, found), side(found));
    }
    assert_eq!(with_word(0, 2), "brdfc.environment version: found 2, expected 1");
    for scale in [0.0, -1.0, 1e-40, f32::NAN, f32::INFINITY, 2f32.powi(113)] {
        let text = with_word(2, scale.to_bits());
        assert_eq!(
            text,
            format!("brdfc.environment scale: found {scale}, expected a positive normal number up to 2^112")
        );
    }
    let text = with_word(1, 16);
    assert!(
        text.starts_with("texture: found 6 faces of 8 x 8 texels of Rgb9E5, expected 6 faces of 16 x 16"),
        "{text}"
    );
    // The block of the shader no longer follows from the header.
    assert!(with_word(2, 2f32.to_bits()).contains("environment_parameters"), "{}", with_word(2, 2f32.to_bits()));
    let mut other = texture();
    other.entries.get_mut(ENVIRONMENT_ENTRY).unwrap().push(0);
    assert_eq!(error(&other), "brdfc.environment: found 13 bytes, expected 12 bytes");
    other.entries.clear();
    assert!(error(&other).contains("brdfc.bindings"), "{}", error(&other));
}

/// Other textures, with bindings that agree with them.
#[test]
fn errors_name_the_texture() {
    let with = |change: fn(&mut Texture), [old, new]: [&str; 2]| {
        let mut texture = texture();
        change(&mut texture);
        rebind(&mut texture, old, new);
        error(&texture)
    };
    let more = |texture: &mut Texture| {
        texture.levels = 2;
        texture.texels.resize(4 * 6 * (64 + 16), 0);
    };
    assert_eq!(with(more, ["8 8 6 1", "8 8 6 2"]), "levelCount: found 2, expected 1, as brdfc.environment says");
    let mut finest = read_texture(&noisy(16, 0.0, |_| [1.0; 3]).to_bytes(false)).unwrap();
    finest.levels = 1;
    finest.texels.truncate(4 * 6 * 256);
    rebind(&mut finest, "16 16 6 2", "16 16 6 1");
    assert_eq!(error(&finest), "levelCount: found 1, expected 2, as brdfc.environment says");
    let layers = |texture: &mut Texture| texture.extent = Extent::D2Array([8, 8, 6]);
    let text = with(layers, ["texture file cube", "texture file 2d-array"]);
    assert!(text.starts_with("texture: found 6 layers of 8 x 8 texels of Rgb9E5, expected 6 faces"), "{text}");
    let format = |texture: &mut Texture| texture.format = TexelFormat::Rgb10A2Unorm;
    let text = with(format, ["file cube rgb9e5ufloat", "file cube rgb10a2unorm"]);
    assert!(text.starts_with("texture: found 6 faces of 8 x 8 texels of Rgb10A2Unorm"), "{text}");
    let mut other = texture();
    rebind(&mut other, "environment_irradiance", "environment_other");
    let image = other.entries.remove("brdfc.image.environment_irradiance").unwrap();
    other.entries.insert("brdfc.image.environment_other".to_owned(), image);
    assert_eq!(error(&other), "environment_irradiance: no texels; expected texels of a cube map");
}

#[test]
fn invalid_radiance_is_rejected() {
    let irradiance = vec![[1.0f32; 3]; 6 * 256];
    let levels = || [16usize, 8].map(|side| vec![[1.0f32; 3]; 6 * side * side]).to_vec();
    let error =
        |side: u32, levels: &[Vec<[f32; 3]>]| EnvironmentPack::new(side, levels, &irradiance).unwrap_err().to_string();
    assert!(EnvironmentPack::new(16, &levels(), &irradiance).is_ok());
    for (value, text) in [(f32::NAN, "NaN"), (-0.5, "-0.5"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        let mut broken = levels();
        broken[1][383][2] = value;
        let expected = format!("environment texel: found [1.0, 1.0, {text}], expected finite values of 0 or more");
        assert_eq!(error(16, &broken), expected);
    }
    let counts = |found: &str, expected: &str| format!("environment texels: found [{found}], expected [{expected}]");
    assert_eq!(error(16, &levels()[..1]), counts("1536, 1536", "1536, 384, 1536"));
    assert_eq!(error(8, &levels()), counts("1536, 384, 1536", "384, 1536"));
    let text = EnvironmentPack::new(16, &levels(), &irradiance[1..]).unwrap_err().to_string();
    assert_eq!(text, counts("1536, 384, 1535", "1536, 384, 1536"));
    let text = EnvironmentPack::new(16, &levels(), &[[f32::NAN; 3]; 1536]).unwrap_err().to_string();
    assert!(text.contains("[NaN, NaN, NaN]"), "{text}");
    let mut short = levels();
    short[0].pop();
    assert_eq!(error(16, &short), counts("1535, 384, 1536", "1536, 384, 1536"));
    assert_eq!(error(9, &[]), "brdfc.environment side: found 9, expected a power of two, 8 to 2048");
    // The largest number fits.
    let mut bright = levels();
    bright[0][0] = [f32::MAX; 3];
    assert!(EnvironmentPack::new(16, &bright, &irradiance).unwrap().level(0).flatten().all(f32::is_finite));
}
