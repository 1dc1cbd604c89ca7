//! Poisson inpainting (Pérez, Gangnet and Blake 2003, "Poisson image editing").
//!
//! A hole takes the gradients of a guide image and meets the known texels at its border: `Δx = Δg` inside, `x = f`
//! outside. With `x = g + e` this is the membrane `Δe = 0` inside, `e = f - g` outside. The matrix depends on the mask
//! alone: one factorisation serves all lights and colours of a view.

use super::super::sparse::{Cholesky, Symbolic};
use std::sync::Arc;

/// A factorised mask that fills images of `size` x `size` texels with periodic borders.
pub struct Poisson {
    holes: Vec<u32>,
    /// For each hole, the adjacent known texels.
    borders: Vec<Vec<u32>>,
    factor: Option<Cholesky>,
}

impl Poisson {
    /// Factorises the mask of a square of `known.len()` texels.
    ///
    /// # Panics
    /// Panics if the number of texels is not a square.
    pub fn new(known: &[bool]) -> Self {
        let n = known.len().isqrt();
        assert_eq!(n * n, known.len(), "a square of texels");
        let holes: Vec<u32> = (0..known.len() as u32).filter(|i| !known[*i as usize]).collect();
        if holes.len() == known.len() {
            return Self { borders: vec![Vec::new(); holes.len()], holes, factor: None };
        }
        let mut row_of = vec![u32::MAX; known.len()];
        holes.iter().zip(0..).for_each(|(hole, row)| row_of[*hole as usize] = row);
        let mut borders = vec![Vec::new(); holes.len()];
        let (mut places, mut values) = (Vec::with_capacity(3 * holes.len()), Vec::with_capacity(3 * holes.len()));
        let mut add = |row, column, value| {
            places.push([row, column]);
            values.push(value);
        };
        for (row, hole) in holes.iter().enumerate() {
            let (x, y) = (*hole as usize % n, *hole as usize / n);
            let around = [(x + 1, y), (x + n - 1, y), (x, y + 1), (x, y + n - 1)].map(|(x, y)| y % n * n + x % n);
            add(row as u32, row as u32, 4.0);
            for neighbour in around {
                match row_of[neighbour] {
                    u32::MAX => borders[row].push(neighbour as u32),
                    // The lower half is sufficient.
                    other if other < row as u32 => add(row as u32, other, -1.0),
                    _ => {}
                }
            }
        }
        let factor = (!holes.is_empty()).then(|| {
            let symbolic = Symbolic::new(holes.len(), &places).expect("no more rows than texels");
            // Weakly diagonally dominant, and every hole borders a known texel: positive definite.
            Cholesky::new(&Arc::new(symbolic), &values, &()).expect("the matrix is positive definite")
        });
        Self { holes, borders, factor }
    }

    /// Fills unknown texels; known ones stay unchanged. Copies the guide if no texel is known. Values are not negative.
    pub fn fill(&self, image: &mut [[f32; 3]], guide: &[[f32; 3]]) {
        let mut right = vec![[0.0f64; 3]; self.holes.len()];
        for (row, border) in self.borders.iter().enumerate() {
            for at in border {
                let at = *at as usize;
                (0..3).for_each(|k| right[row][k] += f64::from(image[at][k]) - f64::from(guide[at][k]));
            }
        }
        if let Some(factor) = &self.factor {
            factor.solve(&mut right);
        }
        for (row, hole) in self.holes.iter().enumerate() {
            let at = *hole as usize;
            image[at] = [0, 1, 2].map(|k| (f64::from(guide[at][k]) + right[row][k]).max(0.0) as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(n: usize) -> Vec<bool> {
        (0..n * n).map(|i| !(4..12).contains(&(i % n)) || !(3..11).contains(&(i / n))).collect()
    }

    #[test]
    fn a_guide_that_is_off_by_a_constant_reproduces_the_image() {
        let n = 16;
        let rendering: Vec<[f32; 3]> =
            (0..n * n).map(|i| [(i % n) as f32 + 1.0, ((i * i) % 13) as f32, 5.0 + (i / n) as f32]).collect();
        let guide: Vec<[f32; 3]> = rendering.iter().map(|v| [v[0] + 3.0, v[1], v[2] - 4.0]).collect();
        let known = block(n);
        let mut image = rendering.clone();
        (0..n * n).filter(|i| !known[*i]).for_each(|i| image[i] = [f32::NAN; 3]);
        Poisson::new(&known).fill(&mut image, &guide);
        for (found, expected) in image.iter().zip(&rendering) {
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-4), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn without_gradients_it_is_a_membrane() {
        // A harmonic function is its own membrane; x and y are harmonic away from the seam of the repetition.
        let n = 16;
        let rendering: Vec<[f32; 3]> = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, 2.0]).collect();
        let known = block(n);
        let mut image = rendering.clone();
        (0..n * n).filter(|i| !known[*i]).for_each(|i| image[i] = [0.0; 3]);
        Poisson::new(&known).fill(&mut image, &vec![[0.0; 3]; n * n]);
        for (found, expected) in image.iter().zip(&rendering) {
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-4), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn nothing_known_and_nothing_missing() {
        let mut image = vec![[9.0; 3]; 16];
        Poisson::new(&[false; 16]).fill(&mut image, &[[0.5; 3]; 16]);
        assert!(image.iter().all(|v| *v == [0.5; 3]));
        let mut image = vec![[9.0; 3]; 16];
        Poisson::new(&[true; 16]).fill(&mut image, &[[0.5; 3]; 16]);
        assert!(image.iter().all(|v| *v == [9.0; 3]));
    }
}
