//! Planes of compressed polynomial texture maps: grey JPEGs, some of them predicted from others.

use crate::words::Words;
use brdfc_formats::FormatError;

/// Decodes a grey JPEG that must have this width and height: its samples, row by row, or what is wrong.
pub type DecodeJpeg<'a> = &'a dyn Fn(&[u8], [u32; 2]) -> Result<Vec<u8>, String>;

/// Maximum number of pixels: a small JPEG can have any number.
pub(super) const MAX_PIXELS: u64 = 1 << 27;
/// Bytes of a correction: the index of a pixel, the most significant byte first, and its sample.
const CORRECTION: usize = 5;

/// Words about a plane.
struct Plane {
    inverted: bool,
    /// Position in the order of decoding.
    order: usize,
    /// Plane from which it is predicted.
    reference: Option<usize>,
    jpeg_bytes: u32,
    correction_bytes: u32,
}

/// Reads the rest of a header, and decodes `COUNT` planes; rows run from the bottom.
pub(super) fn planes<const COUNT: usize>(
    mut header: Words<'_>,
    size: [u32; 2],
    decode: DecodeJpeg<'_>,
) -> Result<Vec<Vec<u8>>, FormatError> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    if pixels > MAX_PIXELS {
        let found = format!("{} x {}", size[0], size[1]);
        return Err(FormatError::whole("size", found, format!("at most {MAX_PIXELS} pixels in a compressed map")));
    }
    header.whole = if COUNT == 9 { "a header of 80 words" } else { "a header of 143 words" };
    let plane = words::<COUNT>(&mut header)?;
    let mut rest = header.end("the sizes of corrections")?;
    let length = |plane: &Plane| u64::from(plane.jpeg_bytes) + u64::from(plane.correction_bytes);
    let stated: u64 = plane.iter().map(length).sum();
    if rest.len() as u64 != stated {
        let allowed = format!("{stated}, the sizes of {COUNT} planes");
        return Err(FormatError::whole("file length", format!("{} bytes after the header", rest.len()), allowed));
    }
    let mut parts = Vec::with_capacity(COUNT);
    for plane in &plane {
        let (jpeg, after) = rest.split_at(plane.jpeg_bytes as usize);
        let (corrections, after) = after.split_at(plane.correction_bytes as usize);
        parts.push((jpeg, corrections));
        rest = after;
    }
    let mut decoded: Vec<Vec<u8>> = vec![Vec::new(); COUNT];
    for step in 0..COUNT {
        let at = plane.iter().position(|plane| plane.order == step).expect("the order is a permutation");
        let (jpeg, corrections) = parts[at];
        let mut samples = decode(jpeg, size)
            .and_then(|samples| {
                let count = samples.len();
                if count as u64 == pixels { Ok(samples) } else { Err(format!("{count} pixels")) }
            })
            .map_err(|problem| {
                let allowed = format!("a grey JPEG of {} x {} pixels", size[0], size[1]);
                FormatError::whole(format!("plane {at}"), problem, allowed).problem()
            })?;
        if let Some(reference) = plane[at].reference {
            let invert = if plane[at].inverted { 0xff } else { 0 };
            for (sample, other) in samples.iter_mut().zip(&decoded[reference]) {
                *sample = sample.wrapping_add(other ^ invert).wrapping_sub(128);
            }
        }
        for correction in corrections.as_chunks::<CORRECTION>().0 {
            let [a, b, c, d, sample] = *correction;
            let pixel = u32::from_be_bytes([a, b, c, d]);
            let place = samples.get_mut(pixel as usize).ok_or_else(|| {
                let field = format!("correction of plane {at}");
                FormatError::whole(field, format!("pixel {pixel}"), format!("less than {pixels}"))
            })?;
            *place = sample;
        }
        decoded[at] = samples;
    }
    Ok(decoded)
}

/// Reads the words about all planes, and checks that each is predicted from a plane that is decoded before.
fn words<const COUNT: usize>(header: &mut Words<'_>) -> Result<[Plane; COUNT], FormatError> {
    header.word("compression parameter")?;
    let mut inverted = [false; COUNT];
    for inverted in &mut inverted {
        *inverted = match header.word("transform")? {
            "0" => false,
            "1" => true,
            "2" => return Err(header.wrong("transform", "2 (motion compensation)", "0 or 1 (inversion)")),
            other => return Err(header.wrong("transform", crate::scan::quoted(other), "0 or 1 (inversion)")),
        };
    }
    for _ in 0..2 * COUNT {
        header.digits("motion vector", 0..=0)?;
    }
    let mut order = [0; COUNT];
    for plane in 0..COUNT {
        let step = header.digits("order", 0..=COUNT as u32 - 1)? as usize;
        if order[..plane].contains(&step) {
            return Err(header.wrong("order", step.to_string(), "each number once"));
        }
        order[plane] = step;
    }
    let mut reference = [None; COUNT];
    for plane in 0..COUNT {
        let number = header.whole_number("reference plane")?;
        reference[plane] = match usize::try_from(number) {
            Ok(other) if other < COUNT && order[other] < order[plane] => Some(other),
            Err(_) if number == -1 => None,
            _ => return Err(header.wrong("reference plane", number.to_string(), "a plane decoded before, or -1")),
        };
    }
    let mut sizes = [[0; COUNT]; 2];
    for (sizes, field) in sizes.iter_mut().zip(["compressed size", "size of corrections"]) {
        for size in sizes {
            *size = header.digits(field, 0..=u32::MAX)?;
        }
    }
    if let Some(size) = sizes[1].iter().find(|size| !size.is_multiple_of(CORRECTION as u32)) {
        return Err(header.wrong("size of corrections", size.to_string(), format!("a multiple of {CORRECTION}")));
    }
    Ok(std::array::from_fn(|plane| Plane {
        inverted: inverted[plane],
        order: order[plane],
        reference: reference[plane],
        jpeg_bytes: sizes[0][plane],
        correction_bytes: sizes[1][plane],
    }))
}
