//! A low-discrepancy sequence with well-distributed runs.

/// The root of `x³ = x + 1`. Its inverse powers are the hardest to approximate by fractions.
const PLASTIC: f64 = 1.324_717_957_244_746;

/// Point `index` of the additive recurrence with the inverse plastic number and its square (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences"), in the unit square.
///
/// A renderer may start at any index and take any number of points. Any run of an additive recurrence is a shifted copy
/// of the first run of that length, so that all runs are equally well distributed. Sobol' points have this property
/// only in aligned runs of a power of two.
pub fn sequence_point(index: u32) -> [f64; 2] {
    let index = f64::from(index);
    [(0.5 + index / PLASTIC).fract(), (0.5 + index / (PLASTIC * PLASTIC)).fract()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// RMS error over all runs of a length for a disc, a ramp and a smooth bump, relative to the integral.
    fn error(points: &[[f64; 2]], length: usize) -> f64 {
        let values: [fn(&[f64; 2]) -> f64; 3] = [
            |[u, v]| if (u - 0.4).hypot(v - 0.6) < 0.3 { 1.0 / (0.09 * std::f64::consts::PI) } else { 0.0 },
            |[u, v]| 4.0 * u * v,
            |[u, v]| {
                (std::f64::consts::PI / 2.0).powi(2)
                    * (std::f64::consts::PI * u).sin()
                    * (std::f64::consts::PI * v).sin()
            },
        ];
        let mut sum = 0.0;
        let mut runs = 0;
        for value in values {
            for run in points.windows(length) {
                sum += (run.iter().map(value).sum::<f64>() / length as f64 - 1.0).powi(2);
                runs += 1;
            }
        }
        (sum / f64::from(runs)).sqrt()
    }

    #[test]
    fn any_run_is_better_than_random_numbers() {
        let ours: Vec<_> = (0..2048).map(sequence_point).collect();
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let random: Vec<[f64; 2]> = (0..2048).map(|_| [generator.random(), generator.random()]).collect();
        for (length, factor) in [(16, 1.6), (64, 2.5), (256, 4.0), (1024, 5.0)] {
            let (a, b) = (error(&ours, length), error(&random, length));
            println!("{length} points: {a:.5}, random {b:.5}, factor {:.1}", b / a);
            assert!(a * factor < b, "{length}: {a} {b}");
        }
    }
}
