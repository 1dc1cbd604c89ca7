//! References for packs: photographs, filtered in the same way as texels.

use brdfc_formats::tap::{Tap, bilinear};

/// A photograph with mipmaps: means of four pixels.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// Columns, rows and linear RGB, from the finest.
    levels: Vec<([usize; 2], Vec<[f32; 3]>)>,
    repeats: bool,
}

impl Photograph {
    /// Makes a photograph from linear RGB, row by row from the top.
    ///
    /// # Panics
    /// If a side is 0, or if the number of pixels does not match: a bug of the caller.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>, repeats: bool) -> Self {
        assert!(size[0] * size[1] > 0 && pixels.len() == size[0] * size[1], "{size:?} and {} pixels", pixels.len());
        let mut levels = vec![(size, pixels)];
        while let Some((size, pixels)) = levels.last().filter(|(size, _)| *size != [1, 1]) {
            levels.push(halved(*size, pixels));
        }
        Self { levels, repeats }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.levels[0].0
    }

    /// Linear RGB at a position, 0 to 1 across the photograph and down from its top, at a mipmap level.
    pub fn value(&self, uv: [f32; 2], level: f32) -> [f32; 3] {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f32);
        let (finer, blend) = (level.floor(), level.fract());
        let fine = self.bilinear(finer as usize, uv);
        if blend == 0.0 {
            return fine;
        }
        let coarse = self.bilinear(finer as usize + 1, uv);
        [0, 1, 2].map(|k| fine[k] + blend * (coarse[k] - fine[k]))
    }

    fn bilinear(&self, level: usize, uv: [f32; 2]) -> [f32; 3] {
        let ([width, height], pixels) = &self.levels[level];
        let axis = |at: f32, side: usize| {
            let within = if self.repeats { at - at.floor() } else { at.clamp(0.0, 1.0) };
            Tap::new(within * side as f32, side as u32, self.repeats)
        };
        bilinear([axis(uv[0], *width), axis(uv[1], *height)], |[column, row]| pixels[row * width + column])
    }
}

/// Halves each side, to at least 1. The last pixel of an odd side counts for two.
fn halved([width, height]: [usize; 2], pixels: &[[f32; 3]]) -> ([usize; 2], Vec<[f32; 3]>) {
    let half = [width.div_ceil(2), height.div_ceil(2)];
    let mean = |at: usize| {
        let (x, y) = (2 * (at % half[0]), 2 * (at / half[0]));
        let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let four = four.map(|(x, y)| pixels[y.min(height - 1) * width + x.min(width - 1)]);
        [0, 1, 2].map(|k| four.iter().map(|pixel| pixel[k]).sum::<f32>() / 4.0)
    };
    (half, (0..half[0] * half[1]).map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_their_means() {
        let pixels: Vec<[f32; 3]> = (0..6).map(|k| [k as f32, 0.0, 1.0]).collect();
        let photograph = Photograph::new([3, 2], pixels.clone(), false);
        let tile = Photograph::new([3, 2], pixels, true);
        // With thirds, positions are exact up to rounding.
        let expect = |photograph: &Photograph, uv, lod, first: f32| {
            let value = photograph.value(uv, lod);
            assert!(
                (value[0] - first).abs() < 1e-5 && value[1..] == [0.0, 1.0],
                "{uv:?} {lod}: {value:?}, not {first}"
            );
        };
        expect(&photograph, [0.5 / 3.0, 0.25], 0.0, 0.0);
        expect(&photograph, [2.5 / 3.0, 0.75], 0.0, 5.0);
        expect(&photograph, [1.0 / 3.0, 0.5], 0.0, 2.0);
        // 0, 1, 3, 4 and twice 2, 5; then both.
        expect(&photograph, [0.25, 0.5], 1.0, 2.0);
        expect(&photograph, [0.75, 0.5], 1.0, 3.5);
        expect(&photograph, [0.1, 0.9], 9.0, 2.75);
        expect(&tile, [1.0 + 0.5 / 3.0, -0.75], 0.0, 0.0);
        expect(&photograph, [0.0, 0.25], 0.0, 0.0);
        expect(&tile, [0.0, 0.25], 0.0, 1.0);
    }
}
