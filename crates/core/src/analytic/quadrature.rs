//! Gauss-Legendre quadrature.

use std::sync::LazyLock;

/// Number of nodes of the rule.
pub const NODES: usize = 24;

/// Position in `(-1, 1)` and weight of each node; exact for polynomials of degree `2 NODES - 1`.
///
/// The positions are the roots of the Legendre polynomial, found by Newton's method (Abramowitz and Stegun 1964,
/// 25.4.29).
static RULE: LazyLock<[[f64; 2]; NODES]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (NODES as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..10 {
            let value;
            [value, slope] = legendre(x);
            x -= value / slope;
        }
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    })
});

/// The Legendre polynomial of degree `NODES` and its derivative.
fn legendre(x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=NODES {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    [value, NODES as f64 * (x * value - before) / (x * x - 1.0)]
}

/// `∫ f dx` from `start` to `end`; zero where `end <= start`.
pub fn integrate<const N: usize>(start: f64, end: f64, f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    if end > start {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        for [x, weight] in *RULE {
            let value = f(middle + half * x);
            for k in 0..N {
                sum[k] += half * weight * value[k];
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_the_degree_are_exact() {
        for degree in 0..2 * NODES as i32 {
            let [found] = integrate(0.0, 2.0, |x| [(0.5 * x).powi(degree)]);
            let error = (found * f64::from(degree + 1) / 2.0 - 1.0).abs();
            assert!(error < 1e-13, "degree {degree}: {error:e}");
        }
        // Negative control: the rule is not exact for other functions.
        let [kink] = integrate(-1.0, 1.0, |x| [(x - 0.3).abs()]);
        assert!((kink - 1.09).abs() > 1e-6);
    }
}
