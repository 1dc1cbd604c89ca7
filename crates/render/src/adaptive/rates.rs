//! Rates of variable rate shading, a feature of graphics hardware, from the levels of a prediction.
//!
//! The hardware shades a coarse pixel of 1 x 1, 2 x 2 or 4 x 4 pixels once and repeats its value. A rate image has the rate
//! of each tile of pixels.

use super::predict::ANY_LEVEL;
use brdfc_metrics::image::LinearImage;
use schemars::JsonSchema;
use serde::Serialize;

/// Logarithm of the side of the largest coarse pixel: 4 x 4 pixels.
const COARSEST: u32 = 2;

/// Sides of tiles that hardware has, in pixels.
pub const RATE_TILES: [u32; 3] = [8, 16, 32];

/// A rate image, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RateImage {
    /// Pixels per side of a tile.
    pub tile: u32,
    /// Tiles per row.
    pub width: usize,
    /// Rows of tiles.
    pub height: usize,
    /// One byte per tile, `(log2 x << 2) | log2 y` for coarse pixels of `x` x `y` pixels: `D3D12_SHADING_RATE`, and the
    /// texels of Vulkan's `VK_KHR_fragment_shading_rate`. 0 is 1 x 1, 5 is 2 x 2, 10 is 4 x 4.
    pub texels: Vec<u8>,
    /// Counts of the rates 1 x 1, 2 x 2 and 4 x 4.
    pub counts: [RateCount; 3],
}

/// Counts of one rate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RateCount {
    /// Texel of the rate image: 0, 5 or 10.
    pub texel: u8,
    /// Pixels per side of a coarse pixel: 1, 2 or 4.
    pub side: u32,
    /// Tiles with this rate.
    pub tiles: u64,
    /// Their pixels that show a surface.
    pub pixels: u64,
    /// Their coarse pixels that show a surface: invocations of the pixel shader if no triangle ends inside a coarse pixel.
    pub shaded: u64,
}

impl RateImage {
    /// Makes the rate image of a rendering of `width` x `height` pixels from the levels of its points, of which each pixel
    /// has `1 << antialiasing_levels` along each axis. A tile has the coarsest rate that its finest pixel allows. Predicted
    /// bandwidth has no direction, so coarse pixels are squares. Tiles without a surface have the coarsest rate.
    ///
    /// # Panics
    /// If the number of levels is wrong, or if `tile` is no multiple of 4.
    pub fn new(levels: &[i32], [width, height]: [usize; 2], antialiasing_levels: u32, tile: u32) -> Self {
        let (sub, side) = (1usize << antialiasing_levels, tile as usize);
        assert_eq!(levels.len(), width * height * sub * sub, "a level for each point");
        assert!(tile > 0 && tile.is_multiple_of(1 << COARSEST), "tiles of whole coarse pixels");
        let finest_of = |x: usize, y: usize| {
            let points = (0..sub * sub).map(|k| levels[(y * sub + k / sub) * width * sub + x * sub + k % sub]);
            points.min().unwrap_or(ANY_LEVEL)
        };
        let finest: Vec<i32> = (0..width * height).map(|pixel| finest_of(pixel % width, pixel / width)).collect();
        // Pixels of a square with a surface, and their finest level.
        let square = |left: usize, top: usize, side: usize| {
            let rows = finest.chunks(width.max(1)).skip(top).take(side);
            let pixels = rows.flat_map(|row| row.iter().skip(left).take(side)).copied();
            pixels
                .filter(|level| *level != ANY_LEVEL)
                .fold((0, ANY_LEVEL), |(n, least), level| (n + 1, least.min(level)))
        };
        let of_rate =
            |doublings: u32| RateCount { texel: texel(doublings), side: 1 << doublings, ..RateCount::default() };
        let mut counts = [0, 1, 2].map(of_rate);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let mut texels = Vec::with_capacity(columns * rows);
        for at in 0..columns * rows {
            let (left, top) = (at % columns * side, at / columns * side);
            let (pixels, level) = square(left, top, side);
            // Levels count from the points, rates from the pixels.
            let doublings = level.saturating_sub(antialiasing_levels as i32).clamp(0, COARSEST as i32) as u32;
            let coarse = 1usize << doublings;
            let is_shaded = |k: &usize| {
                let across = side / coarse;
                square(left + k % across * coarse, top + k / across * coarse, coarse).0 > 0
            };
            let count = &mut counts[doublings as usize];
            count.tiles += 1;
            count.pixels += pixels;
            count.shaded += (0..(side / coarse).pow(2)).filter(is_shaded).count() as u64;
            texels.push(texel(doublings));
        }
        Self { tile, width: columns, height: rows, texels, counts }
    }

    /// An image with these rates: each coarse pixel has the mean of its pixels that show a surface. A shader that runs at the centre
    /// of coarse pixels has a larger error.
    ///
    /// # Panics
    /// If the image has more tiles.
    pub fn coarse(&self, image: &LinearImage) -> LinearImage {
        let mut coarse = image.clone();
        let coarse_pixel_of = |at: usize| {
            let (x, y) = (at % image.width, at / image.width);
            let tile = self.tile as usize;
            let doublings = self.texels[y / tile * self.width + x / tile] & 3;
            let [left, top] = [x, y].map(|k| k >> doublings << doublings);
            let rows = top..(top + (1 << doublings)).min(image.height);
            rows.flat_map(move |y| (left..(left + (1 << doublings)).min(image.width)).map(move |x| y * image.width + x))
        };
        for at in (0..image.pixels.len()).filter(|at| image.coverage[*at] > 0.0) {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for other in coarse_pixel_of(at).filter(|other| image.coverage[*other] > 0.0) {
                (0..3).for_each(|k| sum[k] += image.pixels[other][k]);
                count += 1.0;
            }
            coarse.pixels[at] = sum.map(|sum| sum / count);
        }
        coarse
    }
}

/// Texel of square coarse pixels with sides of `1 << doublings`.
fn texel(doublings: u32) -> u8 {
    (doublings << 2 | doublings) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 24 x 16 pixels in tiles of 8 x 8: level 3, then one pixel of level 1, then one of level 0; below no surface, a surface
    /// of 3 x 3 pixels, and a level coarser than any rate.
    fn levels() -> Vec<i32> {
        let level = |at: usize| match (at % 24, at / 24) {
            (13, 2) => 1,
            (23, 0) => 0,
            (_, 0..=7) => 3,
            (9..=11, 9..=11) => 2,
            (16.., _) => 7,
            _ => ANY_LEVEL,
        };
        (0..24 * 16).map(level).collect()
    }

    #[test]
    fn a_tile_has_the_coarsest_rate_of_its_finest_pixel() {
        let image = RateImage::new(&levels(), [24, 16], 0, 8);
        assert_eq!((image.width, image.height, image.tile), (3, 2, 8));
        assert_eq!(image.texels, [10, 5, 0, 10, 10, 10]);
        let count = |texel, side, tiles, pixels, shaded| RateCount { texel, side, tiles, pixels, shaded };
        // The surface of 3 x 3 pixels lies in coarse pixels from 8 to 12: one.
        assert_eq!(
            image.counts,
            [count(0, 1, 1, 64, 64), count(5, 2, 1, 64, 16), count(10, 4, 4, 64 + 9 + 64, 4 + 1 + 4)]
        );
        // The control: without its finest pixel a tile is coarser.
        let mut coarser = levels();
        coarser[23] = 3;
        assert_eq!(RateImage::new(&coarser, [24, 16], 0, 8).texels, [10, 5, 10, 10, 10, 10]);
    }

    #[test]
    fn tiles_at_the_border_are_cut_off() {
        let image = RateImage::new(&[1; 10 * 9], [10, 9], 0, 8);
        assert_eq!((image.width, image.height, image.texels), (2, 2, vec![5; 4]));
        assert_eq!((image.counts[1].pixels, image.counts[1].shaded), (90, 5 * 5));
        let none = RateImage::new(&[], [0, 0], 0, 8);
        assert!(none.texels.is_empty() && none.counts.iter().all(|count| count.tiles == 0));
    }

    #[test]
    fn coarse_pixels_show_the_mean_of_their_surface() {
        let mut image = LinearImage::black(16, 8);
        image.coverage = vec![1.0; 128];
        image.coverage[0] = 0.0;
        image.pixels = (0..128).map(|at| [(at % 16) as f32, 1.0, (at / 16) as f32]).collect();
        let rates = RateImage::new(&[[1; 8], [0; 8]].concat().repeat(8), [16, 8], 0, 8);
        assert_eq!(rates.texels, [5, 0]);
        let coarse = rates.coarse(&image);
        assert_eq!(coarse.pixels[0], image.pixels[0], "no surface");
        assert_eq!(coarse.pixels[1], [(1.0 + 0.0 + 1.0) / 3.0, 1.0, 2.0 / 3.0]);
        assert_eq!([coarse.pixels[2], coarse.pixels[19]], [[2.5, 1.0, 0.5]; 2]);
        assert_eq!(coarse.pixels[8..16], image.pixels[8..16], "shaded one by one");
    }

    /// Level 1 of 2 x 2 points per pixel has one point per pixel.
    #[test]
    fn points_of_antialiasing_are_finer_than_pixels() {
        let texel = |level: i32, antialiasing_levels: u32| {
            let points = 64 << (2 * antialiasing_levels);
            RateImage::new(&vec![level; points], [8, 8], antialiasing_levels, 8).texels[0]
        };
        assert_eq!([0, 1, 2, 3, 4].map(|level| texel(level, 1)), [0, 0, 5, 10, 10]);
        assert_eq!([0, 1, 2, 3, 4].map(|level| texel(level, 0)), [0, 5, 10, 10, 10]);
        // One fine point makes its tile fine.
        let mut levels = vec![3; 256];
        levels[200] = 0;
        assert_eq!(RateImage::new(&levels, [8, 8], 1, 8).texels, [0]);
    }
}
