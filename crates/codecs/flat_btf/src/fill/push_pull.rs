//! Push-pull (section 3.3 of Hadim et al. 2009): fills holes from successively coarser means of the known texels around
//! them.

/// A mask prepared to fill images of `size` x `size` texels with periodic borders.
pub struct PushPull {
    /// Weight of each texel per level, finest first: share of known texels under it, 0 to 1.
    weights: Vec<Vec<f32>>,
    size: usize,
}

impl PushPull {
    /// Prepares the mask of a square of `known.len()` texels, with a power of two on each side.
    ///
    /// # Panics
    /// Panics with another number of texels.
    pub fn new(known: &[bool]) -> Self {
        let size = known.len().isqrt();
        assert!(size * size == known.len() && size.is_power_of_two(), "{} texels", known.len());
        let mut weights = vec![known.iter().map(|k| f32::from(u8::from(*k))).collect::<Vec<f32>>()];
        let mut n = size;
        while n > 1 && weights.last().is_some_and(|level| level.contains(&0.0)) {
            let fine = weights.last().expect("there is a level");
            let coarse = (0..n / 2 * (n / 2)).map(|i| four(i, n).iter().map(|at| fine[*at]).sum::<f32>().min(1.0));
            let coarse = coarse.collect();
            weights.push(coarse);
            n /= 2;
        }
        Self { weights, size }
    }

    /// Fills unknown texels; known ones stay unchanged. Black if no texel is known.
    pub fn fill(&self, image: &mut [[f32; 3]]) {
        // Pull: weighted means, level by level.
        let mut levels: Vec<Vec<[f32; 3]>> = Vec::with_capacity(self.weights.len() - 1);
        let mut n = self.size;
        for level in 1..self.weights.len() {
            let fine: &[[f32; 3]] = levels.last().map_or(&*image, Vec::as_slice);
            let weights = &self.weights[level - 1];
            let mean = |i: usize| {
                let (mut sum, mut total) = ([0.0f32; 3], 0.0f32);
                for at in four(i, n) {
                    let weight = weights[at];
                    if weight > 0.0 {
                        total += weight;
                        (0..3).for_each(|k| sum[k] += weight * fine[at][k]);
                    }
                }
                if total > 0.0 { sum.map(|s| s / total) } else { [0.0; 3] }
            };
            let coarse = (0..n / 2 * (n / 2)).map(mean).collect();
            levels.push(coarse);
            n /= 2;
        }
        // Push: fill missing values from the level above.
        for level in (0..self.weights.len() - 1).rev() {
            let (below, above) = levels.split_at_mut(level);
            let fine: &mut [[f32; 3]] = if level == 0 { &mut *image } else { below[level - 1].as_mut_slice() };
            let coarse = &above[0];
            let n = self.size >> level;
            for (i, weight) in self.weights[level].iter().enumerate().filter(|(_, w)| **w < 1.0) {
                let smooth = between(coarse, n / 2, i % n, i / n);
                (0..3).for_each(|k| {
                    let own = if *weight > 0.0 { weight * fine[i][k] } else { 0.0 };
                    fine[i][k] = own + (1.0 - weight) * smooth[k];
                });
            }
        }
    }
}

/// The four texels of a level of `n` per side under texel `i` of the next coarser one.
fn four(i: usize, n: usize) -> [usize; 4] {
    let (column, row) = (2 * (i % (n / 2)), 2 * (i / (n / 2)));
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| (row + y) * n + column + x)
}

/// Bilinear value of a level with side `n` at a texel of the next finer one.
fn between(coarse: &[[f32; 3]], n: usize, column: usize, row: usize) -> [f32; 3] {
    // A fine texel lies a quarter of a coarse one from the coarse centre, on the side given by its parity.
    let pair = |at: usize| {
        let near = at / 2;
        let far = if at.is_multiple_of(2) { (near + n - 1) % n } else { (near + 1) % n };
        [(near, 0.75f32), (far, 0.25f32)]
    };
    let mut sum = [0.0; 3];
    for (y, wy) in pair(row) {
        for (x, wx) in pair(column) {
            (0..3).for_each(|k| sum[k] += wx * wy * coarse[y * n + x][k]);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_texels_stay_and_constants_extend() {
        let n = 32;
        let known: Vec<bool> = (0..n * n).map(|i| i % 7 == 0 && i / n < 20).collect();
        let fill = PushPull::new(&known);
        let mut image: Vec<[f32; 3]> =
            known.iter().map(|k| if *k { [0.25, 0.5, 2.0] } else { [f32::NAN; 3] }).collect();
        fill.fill(&mut image);
        for value in image {
            assert!((value[0] - 0.25).abs() < 1e-6 && (value[2] - 2.0).abs() < 1e-5, "{value:?}");
        }
    }

    #[test]
    fn holes_lie_between_their_surroundings() {
        let n = 16;
        let known: Vec<bool> = (0..n * n).map(|i| !(5..11).contains(&(i % n)) || !(5..11).contains(&(i / n))).collect();
        let source: Vec<[f32; 3]> = (0..n * n).map(|i| [(i % n) as f32, 1.0, 0.0]).collect();
        let mut image = source.clone();
        (0..n * n).filter(|i| !known[*i]).for_each(|i| image[i] = [1e30; 3]);
        PushPull::new(&known).fill(&mut image);
        for i in 0..n * n {
            if known[i] {
                assert_eq!(image[i], source[i]);
            } else {
                assert!((1.0..15.0).contains(&image[i][0]) && (image[i][1] - 1.0).abs() < 1e-6, "{:?}", image[i]);
            }
        }
        // The left of the hole is darker than its right.
        assert!(image[8 * n + 5][0] + 1.0 < image[8 * n + 10][0]);
    }

    #[test]
    fn nothing_known_is_black_and_nothing_missing_is_untouched() {
        let mut image = vec![[f32::NAN; 3]; 16];
        PushPull::new(&[false; 16]).fill(&mut image);
        assert!(image.iter().all(|v| *v == [0.0; 3]));
        let mut image = vec![[3.0; 3]; 16];
        PushPull::new(&[true; 16]).fill(&mut image);
        assert!(image.iter().all(|v| *v == [3.0; 3]));
    }
}
