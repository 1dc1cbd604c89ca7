//! Images that cover the tile and repeat with it.

use brdfc_formats::tap::{Tap, bilinear};

/// An image of `N` channels over the tile: row 0 is the top, `y = 1`; pixel (column, row) has its centre at
/// `((column + ½) / width, 1 - (row + ½) / height)`.
#[derive(Debug, Clone, PartialEq)]
pub struct TileImage<const N: usize> {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels, row by row from the top.
    pub pixels: Vec<[f32; N]>,
}

impl<const N: usize> TileImage<N> {
    /// Bilinear value at a point, in tiles.
    pub fn at(&self, x: f64, y: f64) -> [f32; N] {
        let axis = |c: f64, size: usize| Tap::around_f64(c * size as f64 - 0.5, size as u32, true);
        let taps = [axis(x, self.width), axis(1.0 - y, self.height)];
        bilinear(taps, |[column, row]| self.pixels[row * self.width + column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_are_pixels_and_borders_repeat() {
        let image = TileImage { width: 2, height: 2, pixels: vec![[1.0f32], [2.0], [3.0], [4.0]] };
        // Row 0 is the top.
        assert_eq!(image.at(0.25, 0.75), [1.0]);
        assert_eq!(image.at(0.75, 0.25), [4.0]);
        assert_eq!(image.at(5.75, -2.25), [2.0]);
        assert_eq!(image.at(0.0, 0.75), [1.5]);
        assert_eq!(image.at(0.5, 0.5), [2.5]);
    }
}
