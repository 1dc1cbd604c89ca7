//! Mipmaps of a repeating image.
//!
//! Look-ups use only f32 additions and multiplications in a fixed order, so that a shader can compute the same values.

/// An image and its halvings, finest first. It repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct Mipmaps {
    levels: Vec<MipLevel>,
}

/// One level of [`Mipmaps`].
#[derive(Debug, Clone, PartialEq)]
pub struct MipLevel {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colours, row by row.
    pub texels: Vec<[f32; 3]>,
}

impl Mipmaps {
    /// Makes all levels of an image of `width` pixels per row. Each next level is half as large along both axes, rounded
    /// down, but at least 1; its texels have the means of the areas that they cover.
    ///
    /// # Panics
    /// Panics if the number of pixels is not a positive multiple of `width`.
    pub fn new(width: usize, texels: Vec<[f32; 3]>) -> Self {
        assert!(width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width), "an image has whole rows");
        let mut levels = vec![MipLevel { width, height: texels.len() / width, texels }];
        while let Some(last) = levels.last().filter(|last| last.width * last.height > 1) {
            let next = last.halved();
            levels.push(next);
        }
        Self { levels }
    }

    /// Width and height of the finest level.
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// All levels, finest first.
    pub fn levels(&self) -> &[MipLevel] {
        &self.levels
    }

    /// The colour at a place, `(0, 0)` the corner of the first texel and 1 a repetition, over a footprint whose longer side
    /// has the root of `texels_squared` texels of the finest level: bilinear in two levels, and linear between them.
    pub fn colour(&self, place: [f32; 2], texels_squared: f32) -> [f32; 3] {
        let (level, share) = self.level(texels_squared);
        let finer = self.levels[level].at(place);
        if share == 0.0 {
            return finer;
        }
        mixed(finer, self.levels[level + 1].at(place), share)
    }

    /// The level of a footprint, and the share of the next one. The logarithm is linear between powers of two.
    fn level(&self, texels_squared: f32) -> (usize, f32) {
        if texels_squared <= 1.0 {
            return (0, 0.0);
        }
        let bits = texels_squared.to_bits();
        let exponent = (bits >> 23) as i32 - 127;
        let beyond = f32::from_bits(bits & 0x7f_ffff | 0x3f80_0000) - 1.0;
        let level = (0.5 * (exponent as f32 + beyond)).min((self.levels.len() - 1) as f32);
        (level as usize, level - level.floor())
    }
}

impl MipLevel {
    fn at(&self, place: [f32; 2]) -> [f32; 3] {
        let ([left, right], s) = tap(place[0], self.width);
        let ([above, below], t) = tap(place[1], self.height);
        let texel = |row: usize, column: usize| self.texels[row * self.width + column];
        let upper = mixed(texel(above, left), texel(above, right), s);
        mixed(upper, mixed(texel(below, left), texel(below, right), s), t)
    }

    fn halved(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let rows: Vec<Vec<(usize, f32)>> = (0..height).map(|row| covered(row, self.height, height)).collect();
        let columns: Vec<Vec<(usize, f32)>> = (0..width).map(|column| covered(column, self.width, width)).collect();
        let texel = |at: usize| {
            let mut sum = [0.0f32; 3];
            for (row, of_row) in &rows[at / width] {
                for (column, of_column) in &columns[at % width] {
                    let texel = self.texels[row * self.width + column];
                    (0..3).for_each(|k| sum[k] += of_row * of_column * texel[k]);
                }
            }
            sum
        };
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }
}

/// Finer texels that a coarser one covers, with their shares of its area.
fn covered(at: usize, from: usize, to: usize) -> Vec<(usize, f32)> {
    let ratio = from as f64 / to as f64;
    let (first, end) = (at as f64 * ratio, (at + 1) as f64 * ratio);
    let share = |texel: usize| (end.min((texel + 1) as f64) - first.max(texel as f64)) / ratio;
    (first as usize..(end.ceil() as usize).min(from)).map(|texel| (texel, share(texel) as f32)).collect()
}

/// Two neighbours along an axis of `size` repeating texels, and the weight of the second.
fn tap(place: f32, size: usize) -> ([usize; 2], f32) {
    let at = (place - place.floor()) * size as f32 - 0.5;
    let lower = at.floor();
    let first = if lower < 0.0 { size - 1 } else { (lower as usize).min(size - 1) };
    ([first, if first + 1 == size { 0 } else { first + 1 }], at - lower)
}

fn mixed(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize) -> Vec<[f32; 3]> {
        (0..width * height).map(|i| [((i * 7) % 13) as f32, ((i * 5) % 11) as f32, 1.0]).collect()
    }

    #[test]
    fn levels_have_the_mean_of_the_image() {
        for (width, height) in [(8, 8), (7, 5), (1, 9), (12, 1)] {
            let mipmaps = Mipmaps::new(width, image(width, height));
            let mean = |level: &MipLevel, k: usize| {
                level.texels.iter().map(|texel| f64::from(texel[k])).sum::<f64>() / level.texels.len() as f64
            };
            let expected = [0, 1, 2].map(|k| mean(&mipmaps.levels()[0], k));
            for level in mipmaps.levels() {
                for k in 0..3 {
                    let found = mean(level, k);
                    assert!((found - expected[k]).abs() < 1e-4, "{width} x {height}: {found} {}", expected[k]);
                }
            }
            let last = mipmaps.levels().last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            assert_eq!(mipmaps.colour([0.3, 0.7], 1e12), last.texels[0]);
        }
    }

    #[test]
    fn look_ups_are_bilinear_and_repeat() {
        let mipmaps = Mipmaps::new(4, image(4, 2));
        let texel = |row: usize, column: usize| mipmaps.levels()[0].texels[row * 4 + column];
        assert_eq!(mipmaps.colour([0.125, 0.25], 0.0), texel(0, 0));
        assert_eq!(mipmaps.colour([0.25, 0.25], 1.0), mixed(texel(0, 0), texel(0, 1), 0.5));
        assert_eq!(mipmaps.colour([0.0, 0.25], 0.0), mixed(texel(0, 3), texel(0, 0), 0.5), "over the border");
        assert_eq!(mipmaps.colour([3.25, -0.75], 0.0), mipmaps.colour([0.25, 0.25], 0.0));
        // Two texels are level 1, and 1.41 texels half way.
        assert_eq!(mipmaps.colour([0.25, 0.5], 4.0), mipmaps.levels()[1].at([0.25, 0.5]));
        let between = mixed(mipmaps.levels()[0].at([0.25, 0.5]), mipmaps.levels()[1].at([0.25, 0.5]), 0.5);
        assert_eq!(mipmaps.colour([0.25, 0.5], 2.0), between);
    }
}
