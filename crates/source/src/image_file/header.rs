//! Statements of a file about its pixels.

use super::colour::{Colour, triples};
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples, collected};
use brdfc_core::words::percent;
use brdfc_formats::FormatError;
use brdfc_readers::pixels::{LINEAR_8, Pixels};

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
    /// Bytes of a pixel of [`Self::pixels`].
    pub(crate) fn pixel_bytes(&self) -> u64 {
        3 * match self.depth {
            Depth::U8 if self.colour.is_srgb() => 1,
            Depth::U8 | Depth::U16 => 2,
            Depth::F32 => 4,
        }
    }

    /// Pixels of a raster. Integers outside the gamut of Rec. 709 are clipped, with a note; those that are not sRGB become
    /// sRGB levels of 16 bits.
    ///
    /// # Errors
    /// Returns an error if there is not enough memory.
    pub(crate) fn pixels(&mut self, raster: Raster) -> Result<Pixels, FormatError> {
        let (pixels, clipped) = self.colour.pixels(raster)?;
        self.note_clipped(clipped, pixels.len());
        Ok(pixels)
    }

    /// Same as [`Self::pixels`], as linear values.
    ///
    /// # Errors
    /// Same as [`Self::pixels`].
    pub(crate) fn linear_pixels(&mut self, raster: Raster) -> Result<Vec<[f32; 3]>, FormatError> {
        match &raster.samples {
            // Levels would be one more copy.
            Samples::U8(codes) if self.colour.is_srgb() => {
                let linear = |level: u8| LINEAR_8[usize::from(level)];
                collected(triples(codes, raster.channels).map(|codes| codes.map(linear)))
            }
            _ => Ok(self.pixels(raster)?.into_linear()),
        }
    }

    /// Adds a note about clipped pixels, if there are any.
    pub(crate) fn note_clipped(&mut self, count: usize, all: usize) {
        if count > 0 {
            let share = percent(count as f64 / all as f64);
            self.notes.push(format!("{share} of the pixels lie outside the gamut of Rec. 709 and were clipped"));
        }
    }

    /// Statements of the file, and what was done; the first is the colour.
    pub(crate) fn conversions(&self) -> Vec<String> {
        let turned = (!self.orientation.is_upright()).then(|| format!("orientation {}", self.orientation));
        [self.colour.to_string()].into_iter().chain(turned).chain(self.notes.iter().cloned()).collect()
    }
}
