//! Pixels of photographs, as compact as their files hold them.

use crate::colour::decode_srgb;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, LazyLock};

/// Linear value of each 8-bit sRGB level.
pub static LINEAR_8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| decode_srgb(code as f64 / 255.0) as f32));
/// Linear value of each 16-bit sRGB level.
static LINEAR_16: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|code| decode_srgb(f64::from(code) / 65535.0) as f32).collect());

/// RGB of each pixel (Rec. 709 primaries), row by row from the top. 1 is the full scale of integer formats. Clones share memory.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// sRGB levels of 8 bits.
    Levels8(Arc<Vec<[u8; 3]>>),
    /// sRGB levels of 16 bits.
    Levels16(Arc<Vec<[u16; 3]>>),
    /// Linear values.
    Linear(Arc<Vec<[f32; 3]>>),
}

impl From<Vec<[f32; 3]>> for Pixels {
    fn from(linear: Vec<[f32; 3]>) -> Self {
        Self::Linear(Arc::new(linear))
    }
}

impl Pixels {
    /// Bytes of a pixel of linear values.
    pub const BYTES_OF_LINEAR: u64 = 12;

    /// Number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Self::Levels8(pixels) => pixels.len(),
            Self::Levels16(pixels) => pixels.len(),
            Self::Linear(pixels) => pixels.len(),
        }
    }

    /// Returns true without pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Linear value of a pixel.
    ///
    /// # Panics
    /// Panics if the pixel does not exist.
    pub fn pixel(&self, at: usize) -> [f32; 3] {
        match self {
            Self::Levels8(pixels) => pixels[at].map(of_8),
            Self::Levels16(pixels) => pixels[at].map(of_16),
            Self::Linear(pixels) => pixels[at],
        }
    }

    /// Linear values of some pixels.
    ///
    /// # Panics
    /// Panics if a pixel does not exist.
    pub fn linear(&self, range: Range<usize>) -> Cow<'_, [[f32; 3]]> {
        match self {
            Self::Levels8(pixels) => pixels[range].iter().map(|pixel| pixel.map(of_8)).collect(),
            Self::Levels16(pixels) => pixels[range].iter().map(|pixel| pixel.map(of_16)).collect(),
            Self::Linear(pixels) => Cow::Borrowed(&pixels[range]),
        }
    }

    /// Linear values of all pixels.
    pub fn into_linear(self) -> Vec<[f32; 3]> {
        match self {
            Self::Linear(pixels) => Arc::unwrap_or_clone(pixels),
            levels => levels.linear(0..levels.len()).into_owned(),
        }
    }

    /// Linear values of all pixels, to be changed.
    pub fn to_mut(&mut self) -> &mut Vec<[f32; 3]> {
        if !matches!(self, Self::Linear(_)) {
            *self = self.clone().into_linear().into();
        }
        let Self::Linear(pixels) = self else { unreachable!("just made linear") };
        Arc::make_mut(pixels)
    }

    /// Some of the pixels, range by range.
    ///
    /// # Panics
    /// Panics if a pixel does not exist.
    pub fn parts(&self, ranges: impl Iterator<Item = Range<usize>>) -> Self {
        match self {
            Self::Levels8(pixels) => {
                Self::Levels8(Arc::new(ranges.flat_map(|range| &pixels[range]).copied().collect()))
            }
            Self::Levels16(pixels) => {
                Self::Levels16(Arc::new(ranges.flat_map(|range| &pixels[range]).copied().collect()))
            }
            Self::Linear(pixels) => Self::Linear(Arc::new(ranges.flat_map(|range| &pixels[range]).copied().collect())),
        }
    }
}

fn of_8(level: u8) -> f32 {
    LINEAR_8[usize::from(level)]
}

fn of_16(level: u16) -> f32 {
    LINEAR_16[usize::from(level)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers of the sRGB curve, and all views of the same pixels.
    #[test]
    fn levels_are_srgb() {
        let levels = Pixels::Levels8(Arc::new(vec![[0, 10, 188], [255, 1, 2], [3, 4, 5]]));
        for (found, expected) in levels.pixel(0).into_iter().zip([0.0, 0.003_035_27, 0.502_886_5]) {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
        assert_eq!(levels.pixel(1)[0], 1.0);
        let sixteen = Pixels::Levels16(Arc::new(vec![[0, 10 * 257, 188 * 257], [65535, 257, 514], [771, 1028, 1285]]));
        let linear: Pixels = (0..3).map(|at| levels.pixel(at)).collect::<Vec<_>>().into();
        for mut pixels in [levels, sixteen, linear] {
            assert_eq!(pixels.len(), 3);
            assert_eq!(pixels.linear(1..3)[1], pixels.pixel(2));
            let parts = pixels.parts([2..3, 0..1].into_iter());
            assert_eq!([parts.pixel(0), parts.pixel(1)], [pixels.pixel(2), pixels.pixel(0)]);
            let before = pixels.pixel(0);
            pixels.to_mut()[1] = [7.0; 3];
            assert_eq!((pixels.pixel(0), pixels.pixel(1)), (before, [7.0; 3]));
        }
    }
}
