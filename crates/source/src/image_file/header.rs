//! Statements of a file about its pixels.

use super::colour::Colour;
use super::orientation::Orientation;
use super::raster::Depth;

/// Header of an image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Width and height of the upright image, in its display window.
    pub size: [usize; 2],
    pub channels: usize,
    pub depth: Depth,
    pub colour: Colour,
    pub orientation: Orientation,
    /// Other statements of the file that were applied.
    pub notes: Vec<String>,
}

impl Header {
    /// Bytes of a pixel of [`Colour::pixels`].
    pub(crate) fn pixel_bytes(&self) -> u64 {
        3 * match self.depth {
            Depth::U8 if self.colour.is_srgb() => 1,
            Depth::U8 | Depth::U16 => 2,
            Depth::F32 => 4,
        }
    }

    /// Statements of the file, and what was done; the first is the colour.
    pub(crate) fn conversions(&self) -> Vec<String> {
        let turned = (!self.orientation.is_upright()).then(|| format!("orientation {}", self.orientation));
        [self.colour.to_string()].into_iter().chain(turned).chain(self.notes.iter().cloned()).collect()
    }
}
