//! Lifting step of energy-preserving packs: their scaling coefficients are logarithms of means. The paper uses means of
//! logarithms, which are darker.
//!
//! Two halves with equal weights and logarithms `p + h` and `p - h` have the mean `exp(p + rise)` with `rise = ln cosh
//! h`. A pack stores `m = p + rise(h)` and `h`; synthesis first computes `p = m - rise(h)`. The mean of both halves
//! remains `exp(m)` if `h` is scaled between levels of detail, rounded or dropped.
//!
//! Halves are weighted by the light that they reflect, `cos θ_o dω`, so that the albedo of each incoming direction is
//! preserved. On the tangent-pole grid the weight is a product of `sin² φ` and `sin θ`.

use crate::vector_math::{exp, ln_parts};
use std::f32::consts::LN_2;
use std::f64::consts::PI;

/// Weights of the halves of each pair, for a grid of `2^levels x 2^levels` cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Lift {
    /// Indexed by `2^j - 1 + row` of the parent.
    latitude: Vec<f32>,
    /// Indexed by `2^j - 1 + column` of the parent.
    longitude: Vec<f32>,
}

impl Lift {
    /// Weights of a grid.
    pub fn new(levels: u32) -> Self {
        let each = |share: fn(f64, f64) -> f64| {
            let of_level = |j: u32| {
                let width = PI / f64::from(1u32 << j);
                (0..1u32 << j).map(move |k| share((f64::from(k) + 0.5) * width, 0.5 * width) as f32)
            };
            (0..levels).flat_map(of_level).collect()
        };
        Self { latitude: each(lower_row), longitude: each(lower_column) }
    }

    /// Share of the lower of two rows, `0..1`, for the pair `row` at level `j`.
    pub fn latitude(&self, j: u32, row: usize) -> f32 {
        self.latitude[(1 << j) - 1 + row]
    }

    /// Share of the lower of two columns, `0..1`, for the pair `column` at level `j`.
    pub fn longitude(&self, j: u32, column: usize) -> f32 {
        self.longitude[(1 << j) - 1 + column]
    }

    /// Share for the pair of a coefficient; 0 for the scaling coefficient.
    pub fn of_coefficient(&self, coefficient: usize) -> f32 {
        if coefficient == 0 {
            return 0.0;
        }
        let j = coefficient.ilog2() / 2;
        let side = 1usize << j;
        if coefficient < 2 * side * side {
            self.latitude(j, coefficient / side - side)
        } else {
            self.longitude(j, coefficient % side)
        }
    }
}

/// Share of `∫ sin² φ` in the lower of two halves of `width` that meet at `middle`.
fn lower_row(middle: f64, width: f64) -> f64 {
    0.5 - 0.5 * (2.0 * middle).sin() * width.sin().powi(2) / (width - 0.5 * (2.0 * middle).cos() * (2.0 * width).sin())
}

/// Share of `∫ sin θ` in the lower of two halves of `width` that meet at `middle`.
fn lower_column(middle: f64, width: f64) -> f64 {
    0.5 - 0.5 * (0.5 * width).tan() / middle.tan()
}

/// Difference between the logarithm of the mean of two halves and the mean of their logarithms. The logarithms are `h`
/// above and below their mean and the lower half has the weight `lower`: `ln(lower exp(h) + (1 - lower) exp(-h))`,
/// exactly 0 for `h = 0`.
///
/// f32 operations in a fixed order without fused operations, which shaders reproduce bit by bit.
pub fn rise(h: f32, lower: f32) -> f32 {
    let (size, upper) = (h.abs(), 1.0 - lower);
    let (brighter, darker) = if h < 0.0 { (upper, lower) } else { (lower, upper) };
    let (exponent, z, bend) = ln_parts(brighter + darker * exp(-2.0 * size));
    size + (exponent * LN_2 + (z + bend))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_mean_of_both_halves_is_preserved(h in -30.0f32..30.0, lower in 0.125f32..0.875) {
            let (h64, share) = (f64::from(h), f64::from(lower));
            let exact = (share * h64.exp() + (1.0 - share) * (-h64).exp()).ln();
            prop_assert!((f64::from(rise(h, lower)) - exact).abs() <= 4e-7 * (1.0 + h64.abs()), "{exact}");
        }
    }

    #[test]
    fn equal_halves_have_the_hyperbolic_cosine() {
        for h in [0.0f32, 0.1, -0.7, 3.0] {
            assert!((rise(h, 0.5) - h.cosh().ln()).abs() < 3e-7);
        }
        for lower in 1..1000 {
            assert_eq!((rise(0.0, lower as f32 / 1001.0), rise(-0.0, lower as f32 / 999.7)), (0.0, 0.0));
        }
    }

    /// Compares with sums over many thin cells.
    #[test]
    fn weights_match_reflected_light() {
        const FINE: usize = 512;
        let weight = |power: i32, from: usize, to: usize| -> f64 {
            (from..to).map(|k| (PI * (k as f64 + 0.5) / FINE as f64).sin().powi(power)).sum()
        };
        let lift = Lift::new(4);
        for j in 0..4 {
            for k in 0..1usize << j {
                let half = FINE >> (j + 1);
                let of = |power: i32| {
                    let (lower, upper) = (
                        weight(power, 2 * k * half, (2 * k + 1) * half),
                        weight(power, (2 * k + 1) * half, (2 * k + 2) * half),
                    );
                    lower / (lower + upper)
                };
                assert!((of(2) - f64::from(lift.latitude(j, k))).abs() < 1e-4, "{j} {k}");
                assert!((of(1) - f64::from(lift.longitude(j, k))).abs() < 1e-4, "{j} {k}");
                let side = 1 << j;
                assert_eq!(lift.of_coefficient(side * side + k * side), lift.latitude(j, k));
                assert_eq!(lift.of_coefficient(2 * side * side + side + k), lift.longitude(j, k));
            }
        }
        assert_eq!(lift.of_coefficient(0), 0.0);
    }
}
