//! Images in memory, the results of renderers and the input of comparisons.

mod difference;
mod flip;
mod psnr;

pub use difference::{ImageDifference, Spread, auto_exposure, compare_images, delta_e_map, luminance};
pub(crate) use difference::{colour_difference, shown_colour, spread};
pub use flip::{Flip, PIXELS_PER_DEGREE, flip};
pub use psnr::{SignalToNoise, signal_to_noise};

/// A rectangle of linear radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows of pixels.
    pub height: usize,
    /// Linear RGB (the primaries of sRGB), not negative, 0 where no surface is; row by row from the top, left to right.
    pub pixels: Vec<[f32; 3]>,
    /// Share of a pixel's samples that hit a surface, 0 to 1. Same order as `pixels`.
    pub coverage: Vec<f32>,
    /// Displayed colour where no surface is: linear RGB of the display, 0 to 1, independent of the exposure.
    pub background: [f32; 3],
}

impl LinearImage {
    /// A black image without surfaces.
    pub fn black(width: usize, height: usize) -> Self {
        let (pixels, coverage) = (vec![[0.0; 3]; width * height], vec![0.0; width * height]);
        Self { width, height, pixels, coverage, background: [0.0; 3] }
    }

    /// Adds the light of another rendering of the same surfaces. Pixels without a surface remain black.
    ///
    /// # Panics
    /// If the images differ in size.
    pub fn add_light(&mut self, other: &Self) {
        assert_eq!((self.width, self.height), (other.width, other.height), "renderings of the same size");
        for ((pixel, coverage), added) in self.pixels.iter_mut().zip(&self.coverage).zip(&other.pixels) {
            if *coverage > 0.0 {
                (0..3).for_each(|channel| pixel[channel] += added[channel]);
            }
        }
    }
}
