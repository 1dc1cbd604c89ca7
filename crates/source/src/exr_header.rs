//! Checks of EXR headers, which bound allocations before decoding.

use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use brdfc_formats::memory::summary;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::MetaData;
use std::io::{BufRead, Seek};

/// Maximum size of a block (a tile or a few lines with all channels) before compression, bytes: the decoder holds whole
/// blocks in memory.
const MAX_BLOCK_BYTES: u64 = 128 << 20;

/// Reads the headers of an EXR.
///
/// # Errors
/// Returns an error for files that are not EXR and for blocks of more than 128 MiB.
pub(crate) fn exr_headers(bytes: impl BufRead + Seek, allowed: &'static str) -> Result<Vec<Header>, FormatError> {
    let meta = MetaData::read_from_buffered(bytes, false)
        .map_err(|error| FormatError::whole("EXR", one_line(&error), allowed).problem())?;
    for header in &meta.headers {
        let [width, height] = match header.blocks {
            BlockDescription::ScanLines => [header.layer_size.x(), header.compression.scan_lines_per_block()],
            BlockDescription::Tiles(tiles) => [tiles.tile_size.x(), tiles.tile_size.y()],
        };
        let sides = [width, height, header.channels.bytes_per_pixel].map(|side| side as u64);
        let size = sides.into_iter().fold(1, u64::saturating_mul);
        if size > MAX_BLOCK_BYTES {
            let channels = header.channels.list.len();
            let found = format!("{} in a block of {width} x {height} pixels of {channels} channels", summary(size));
            return Err(FormatError::whole("EXR", found, format!("at most {}", summary(MAX_BLOCK_BYTES))));
        }
    }
    Ok(meta.headers.into_iter().collect())
}

#[cfg(test)]
pub(crate) mod testing {
    /// A file with `channels` channels whose only block is too short.
    pub fn exr_of_channels(width: u32, height: u32, channels: usize) -> Vec<u8> {
        let mut bytes = Vec::from(20_000_630u32.to_le_bytes());
        bytes.extend(2u32.to_le_bytes());
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend(format!("{name}\0{kind}\0").bytes());
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        };
        let list = (0..channels).flat_map(|k| {
            let name = ["B", "G", "R", "Y"].get(k).map_or(format!("Z{k:06}"), |name| (*name).to_owned());
            let mut entry = format!("{name}\0").into_bytes();
            entry.extend([2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
            entry
        });
        attribute("channels", "chlist", &list.chain([0]).collect::<Vec<u8>>());
        attribute("compression", "compression", &[3]);
        let window = [0, 0, width - 1, height - 1].map(u32::to_le_bytes).concat();
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        bytes.push(0);
        let blocks = height.div_ceil(16) as usize;
        let data = bytes.len() + 8 * blocks;
        (0..blocks).for_each(|_| bytes.extend((data as u64).to_le_bytes()));
        // Deflate stream without data.
        bytes.extend([&[0; 4][..], &8u32.to_le_bytes(), &[0x78, 0x9c, 3, 0, 0, 0, 0, 1]].concat());
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::testing::exr_of_channels;
    use super::*;
    use crate::meso::heights_from_exr;
    use crate::radiance_image::from_exr;
    use std::io::Cursor;

    #[test]
    fn blocks_are_of_a_size() {
        let few = exr_of_channels(1024, 16, 4);
        assert_eq!(exr_headers(Cursor::new(&few), "an EXR").unwrap()[0].channels.list.len(), 4);
        let many = exr_of_channels(1024, 16, 200_000);
        let expected =
            "EXR: found 12.21 GiB in a block of 1024 x 16 pixels of 200000 channels, expected at most 128.00 MiB";
        assert_eq!(heights_from_exr(&many).unwrap_err().to_string(), expected);
        assert_eq!(from_exr(&many).unwrap_err().to_string(), expected);
        // The contents of the block do not matter: with fewer channels the pixels are the error.
        assert!(from_exr(&few).unwrap_err().to_string().ends_with("expected channels R, G and B"));
    }
}
