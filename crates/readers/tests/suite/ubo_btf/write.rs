//! Writer of the layout for tests.

use brdfc_formats::container::half;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::ubo_btf::{ColourModel, Description, Matrix, SIGNATURE, Scalar, UboBtf};

/// Size of a name, bytes.
const NAME_BYTES: usize = 80;

/// Names of the channels, for versions that have them.
const CHANNEL_NAMES: [&str; 3] = ["R", "G", "B"];

/// Bytes of a file with matrices of one type of number, without XML. Names are truncated to 80 bytes.
///
/// [`UboBtf::from_bytes`] round-trips the BTF, except for rounding to halves and for truncated names.
pub fn to_bytes(btf: &UboBtf, scalar: Scalar) -> Vec<u8> {
    let mut bytes = SIGNATURE.to_vec();
    let d = btf.description();
    header(&mut bytes, d);
    let lights = angles(&d.lights);
    word(&mut bytes, d.views.len() as u32);
    for view in angles(&d.views) {
        single(&mut bytes, view);
        word(&mut bytes, d.lights.len() as u32);
        single(&mut bytes, lights.iter().copied().flatten());
    }
    d.size.iter().for_each(|side| word(&mut bytes, *side as u32));
    // No rotations of texels' frames.
    word(&mut bytes, 0);
    word(&mut bytes, btf.channels().iter().map(|channel| channel.components() as u32).max().unwrap_or(0));
    bytes.extend(d.colour_model.code().to_le_bytes());
    let (mean, transform) = match d.colour_model {
        ColourModel::Pca { mean, transform } => (mean, transform),
        _ => ([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    };
    single(&mut bytes, mean);
    single(&mut bytes, transform.into_iter().flatten());
    for channel in btf.channels() {
        bytes.push(scalar.size() as u8);
        word(&mut bytes, channel.components() as u32);
        word(&mut bytes, channel.pairs().rows() as u32);
        word(&mut bytes, channel.texels().rows() as u32);
        // The singular values are unused, because the second matrix includes them.
        numbers(&mut bytes, scalar, &vec![1.0; channel.components()]);
        for matrix in [channel.pairs(), channel.texels()] {
            rows(&mut bytes, scalar, matrix);
        }
    }
    bytes
}

fn header(bytes: &mut Vec<u8>, d: &Description) {
    let start = bytes.len();
    word(bytes, 0);
    word(bytes, d.version);
    for name in &d.devices {
        let name = cut(name);
        bytes.extend(name);
        bytes.extend(vec![0; NAME_BYTES - name.len()]);
    }
    single(bytes, [d.texels_per_millimetre]);
    single(bytes, d.rgb_factors);
    if d.version > 1 {
        word(bytes, d.has_cosine.into());
    }
    if d.version > 2 {
        word(bytes, 0);
    }
    if d.version > 3 {
        word(bytes, CHANNEL_NAMES.len() as u32);
        for name in CHANNEL_NAMES {
            word(bytes, name.len() as u32);
            bytes.extend(name.as_bytes());
        }
    }
    let size = (bytes.len() - start) as u32;
    bytes[start..start + 4].copy_from_slice(&size.to_le_bytes());
}

/// Longest start of at most [`NAME_BYTES`] that ends between characters.
fn cut(name: &str) -> &[u8] {
    let end = (0..=NAME_BYTES.min(name.len())).rev().find(|end| name.is_char_boundary(*end)).unwrap_or(0);
    &name.as_bytes()[..end]
}

/// Polar angle and azimuth, radians.
fn angles(set: &DirectionSet) -> Vec<[f32; 2]> {
    set.angles.iter().map(|angles| angles.map(|degrees| degrees.to_radians() as f32)).collect()
}

fn word(bytes: &mut Vec<u8>, value: u32) {
    bytes.extend(value.to_le_bytes());
}

fn single(bytes: &mut Vec<u8>, values: impl IntoIterator<Item = f32>) {
    values.into_iter().for_each(|value| bytes.extend(value.to_le_bytes()));
}

fn rows(bytes: &mut Vec<u8>, scalar: Scalar, matrix: &Matrix) {
    (0..matrix.rows()).for_each(|row| numbers(bytes, scalar, &matrix.row(row)));
}

fn numbers(bytes: &mut Vec<u8>, scalar: Scalar, values: &[f32]) {
    for value in values {
        match scalar {
            Scalar::Half => bytes.extend(half::encode(value.clamp(-half::MAX, half::MAX)).to_le_bytes()),
            Scalar::Single => bytes.extend(value.to_le_bytes()),
            Scalar::Double => bytes.extend(f64::from(*value).to_le_bytes()),
        }
    }
}
