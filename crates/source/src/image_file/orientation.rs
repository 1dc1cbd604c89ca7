//! Orders of pixels other than rows from the top, from left to right.

use super::raster::{Raster, Samples};
use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;
use std::fmt;

/// An orientation, numbered 1 to 8 as in TIFF and EXIF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Orientation(u8);

impl Orientation {
    pub(super) const UPRIGHT: Self = Self(1);

    /// Orientation of a number; upright for others, as the specifications recommend.
    pub(super) fn of(number: u16) -> Self {
        Self(u8::try_from(number).ok().filter(|number| (1..=8).contains(number)).unwrap_or(1))
    }

    pub(super) fn is_upright(self) -> bool {
        self.0 == 1
    }

    /// Size of the upright image.
    pub(super) fn size(self, [width, height]: [usize; 2]) -> [usize; 2] {
        if self.0 >= 5 { [height, width] } else { [width, height] }
    }

    /// Place in the stored image, whose size this is, of a pixel of the upright one.
    fn place(self, [width, height]: [usize; 2], [x, y]: [usize; 2]) -> [usize; 2] {
        let (right, bottom) = (width - 1, height - 1);
        match self.0 {
            2 => [right - x, y],
            3 => [right - x, bottom - y],
            4 => [x, bottom - y],
            5 => [y, x],
            6 => [y, bottom - x],
            7 => [right - y, bottom - x],
            8 => [right - y, x],
            _ => [x, y],
        }
    }

    /// Turns a raster upright.
    ///
    /// # Errors
    /// Returns an error if there is not enough memory.
    pub(super) fn upright(self, raster: Raster) -> Result<Raster, FormatError> {
        if self.is_upright() {
            return Ok(raster);
        }
        let Raster { size: stored, channels, samples } = raster;
        let size = self.size(stored);
        let samples = match samples {
            Samples::U8(samples) => Samples::U8(self.turned(&samples, channels, stored)?),
            Samples::U16(samples) => Samples::U16(self.turned(&samples, channels, stored)?),
            Samples::F32(samples) => Samples::F32(self.turned(&samples, channels, stored)?),
        };
        Ok(Raster { size, channels, samples })
    }

    fn turned<T: Copy>(self, samples: &[T], channels: usize, stored: [usize; 2]) -> Result<Vec<T>, FormatError> {
        let [width, height] = self.size(stored);
        let mut turned = reserved("pixels", samples.len())?;
        for y in 0..height {
            for x in 0..width {
                let [column, row] = self.place(stored, [x, y]);
                let at = channels * (row * stored[0] + column);
                turned.extend_from_slice(&samples[at..at + channels]);
            }
        }
        Ok(turned)
    }
}

impl fmt::Display for Orientation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let done = match self.0 {
            2 => "mirrored from left to right",
            3 => "turned by 180°",
            4 => "mirrored from top to bottom",
            5 => "mirrored along the diagonal",
            6 => "turned by 90° clockwise",
            7 => "mirrored along the other diagonal",
            8 => "turned by 90° anticlockwise",
            _ => "upright",
        };
        write!(f, "{} ({done})", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first pixel of the file is at the corner that the TIFF specification names.
    #[test]
    fn first_pixels_and_rows_are_where_they_belong() {
        // Of a file of 3 x 2 pixels: the corner of pixel 0, and the place of pixel 1.
        let expected = [
            (1, [0, 0], [1, 0]),
            (2, [2, 0], [1, 0]),
            (3, [2, 1], [1, 1]),
            (4, [0, 1], [1, 1]),
            (5, [0, 0], [0, 1]),
            (6, [1, 0], [1, 1]),
            (7, [1, 2], [1, 1]),
            (8, [0, 2], [0, 1]),
        ];
        for (number, first, second) in expected {
            let raster = Raster { size: [3, 2], channels: 1, samples: Samples::U8((0..6).collect()) };
            let upright = Orientation::of(number).upright(raster).unwrap();
            let Samples::U8(samples) = upright.samples else { panic!("{number}") };
            let find = |pixel: u8| {
                let at = samples.iter().position(|sample| *sample == pixel).unwrap();
                [at % upright.size[0], at / upright.size[0]]
            };
            assert_eq!((find(0), find(1)), (first, second), "{number}");
        }
        assert!([0, 9, 300].into_iter().all(|number| Orientation::of(number).is_upright()));
    }
}
