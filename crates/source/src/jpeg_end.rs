//! Checks that a JPEG is complete: the decoder fills missing pixels with grey.

const END_OF_IMAGE: u8 = 0xd9;

/// Checks that the first image of a file has its end marker.
///
/// # Errors
/// Returns what is wrong with the file.
pub(crate) fn check_end(jpeg: &[u8]) -> Result<(), &'static str> {
    if has_end(jpeg) { Ok(()) } else { Err("no end-of-image marker (FF D9): the JPEG is truncated") }
}

/// Skips segments, because they can hold whole images.
fn has_end(jpeg: &[u8]) -> bool {
    let mut rest = jpeg.get(2..).unwrap_or_default();
    // Among pixels, 0 or the number of a restart follows 0xff; fill bytes repeat it.
    let is_marker = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7 | 0xff);
    while let Some(at) = rest.windows(2).position(is_marker) {
        let (marker, segment) = (rest[at + 1], &rest[at + 2..]);
        if marker == END_OF_IMAGE {
            return true;
        }
        // The length counts itself.
        let length = segment.first_chunk().map(|length| usize::from(u16::from_be_bytes(*length)));
        let Some(after) = length.and_then(|length| segment.get(length..)) else { return false };
        rest = after;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jpeg() -> Vec<u8> {
        let mut jpeg = std::io::Cursor::new(Vec::new());
        let noise =
            image::RgbImage::from_fn(40, 24, |x, y| image::Rgb([(x * 61) as u8, (y * 99) as u8, (x * y) as u8]));
        noise.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        jpeg.into_inner()
    }

    #[test]
    fn a_truncated_image_has_no_end() {
        let jpeg = jpeg();
        assert!(has_end(&jpeg));
        assert!((0..jpeg.len()).all(|length| !has_end(&jpeg[..length])));
        // The decoder accepts many of these.
        let decoded = (0..jpeg.len()).filter(|length| image::load_from_memory(&jpeg[..*length]).is_ok()).count();
        assert!(decoded > 100, "{decoded}");
    }

    /// The end of an embedded preview does not count; fill bytes, stray bytes and trailing bytes are ignored.
    #[test]
    fn previews_and_other_bytes_are_skipped() {
        let jpeg = jpeg();
        let segment = |marker: u8, contents: &[u8]| {
            [&[0xff, marker][..], &(contents.len() as u16 + 2).to_be_bytes(), contents].concat()
        };
        let [preview, comment] = [segment(0xe1, &jpeg), segment(0xfe, b"\xff\xd9")];
        for before in [preview.clone(), [&[0xff, 0xff], &comment[..]].concat(), [&preview[..], b"\0"].concat()] {
            let whole = [&jpeg[..2], &before, &jpeg[2..], b"more"].concat();
            assert!(image::load_from_memory(&whole).is_ok() && has_end(&whole));
            assert!(!has_end(&whole[..whole.len() - 6]));
        }
    }
}
