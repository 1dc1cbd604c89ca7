//! Whether a JPEG is complete: the decoder fills what is missing with grey.

/// The problem of files without an end.
pub(crate) const CUT_SHORT: &str = "the JPEG is cut short";
const START_OF_SCAN: u8 = 0xda;
const END_OF_IMAGE: u8 = 0xd9;

/// Whether the first image of a file has its end marker. Bytes after it, such as those of a second image, do not count.
///
/// Segments before the pixels are skipped, because they can hold whole images. Broken ones are the decoder's to report.
pub(crate) fn has_end(jpeg: &[u8]) -> bool {
    let mut rest = jpeg.get(2..).unwrap_or_default();
    while let [0xff, marker, segment @ ..] = rest {
        // Fill bytes may precede a marker.
        if *marker == 0xff {
            rest = &rest[1..];
            continue;
        }
        // The length counts itself.
        let length = segment.first_chunk().map(|length| usize::from(u16::from_be_bytes(*length)));
        let Some(after) = length.and_then(|length| segment.get(length..)) else { return false };
        if *marker == START_OF_SCAN {
            // Within pixels, 0 or the number of a restart follows 0xff.
            return after.windows(2).any(|pair| pair == [0xff, END_OF_IMAGE]);
        }
        rest = after;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_those_of_the_image() {
        let mut jpeg = std::io::Cursor::new(Vec::new());
        image::RgbImage::new(4, 4).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        let jpeg = jpeg.into_inner();
        assert!(has_end(&jpeg));
        for length in 4..jpeg.len() {
            // The markers at the beginning are complete at the ends of segments.
            assert!(!has_end(&jpeg[..length]) || image::load_from_memory(&jpeg[..length]).is_err(), "{length}");
        }
        // A preview in a segment does not stand for the image; fill bytes and what follows the end do no harm.
        let length = (jpeg.len() + 2) as u16;
        let preview = [&[0xff, 0xff, 0xe1][..], &length.to_be_bytes(), &jpeg].concat();
        let with_preview = [&jpeg[..2], &preview, &jpeg[2..], b"more"].concat();
        assert!(image::load_from_memory(&with_preview).is_ok());
        assert!(has_end(&with_preview));
        assert!(!has_end(&with_preview[..with_preview.len() - 6]));
    }
}
