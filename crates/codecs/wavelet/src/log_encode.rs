//! Log encoding (section 5.1 of Claustres et al. 2007, after McCool et al. 2001): `f~ = ln(f / μ + ε)`, in the paper
//! `ln((f + ε μ) / μ)`.

use super::table::Table;
use brdfc_formats::vector_math;
use rayon::prelude::*;

/// Default of the `ε` of the paper's equation in section 5.1.
pub const DEFAULT_BIAS: f64 = 0.01;
/// Lowest `μ`: a table with a lower mean counts as black.
pub const LOWEST_MEAN: f64 = 1e-30;

/// Constants of the encoding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogEncoding {
    /// `μ`, mean of all samples, 1/sr.
    pub mean: f64,
    /// `ε`, bias that keeps the logarithm finite.
    pub bias: f64,
}

impl LogEncoding {
    /// Creates the encoding of a table: its mean, rounded to the f32 of packs; 1 for a black table.
    pub fn of(table: &Table, bias: f64) -> Self {
        let mean = table.mean();
        let mean = if mean > 0.0 { mean.max(LOWEST_MEAN) } else { 1.0 };
        Self { mean: f64::from(mean as f32), bias: f64::from(bias as f32) }
    }

    /// `f~ = ln(f / μ + ε)`.
    pub fn encode(self, f: f64) -> f64 {
        (f / self.mean + self.bias).ln()
    }

    /// `f = μ (exp(f~) - ε)`.
    pub fn decode(self, value: f64) -> f64 {
        self.mean * (value.exp() - self.bias)
    }
}

/// Encodes every sample of a table.
pub fn log_encode(table: &Table, encoding: LogEncoding) -> Table {
    let (scale, bias) = ((1.0 / encoding.mean) as f32, encoding.bias as f32);
    map(table, |f| vector_math::ln(f * scale + bias))
}

fn map(table: &Table, f: impl Fn(f32) -> f32 + Sync) -> Table {
    let mut mapped = table.clone();
    let values = mapped.values.as_slice_mut().expect("tables are stored in standard layout");
    values.par_chunks_mut(1 << 14).for_each(|chunk| chunk.iter_mut().for_each(|v| *v = f(*v)));
    mapped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fold::Fold;
    use crate::table::Grid;
    use brdfc_core::Symmetry;
    use brdfc_formats::direction::Parameterisation;
    use ndarray::Array3;
    use proptest::prelude::*;

    #[test]
    fn tables_in_single_precision_follow_the_equation() {
        let grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 1 };
        let fold = Fold::new(2, grid.parameterisation, Symmetry::NONE);
        let values = Array3::from_shape_fn((1, 4, 4), |(_, a, b)| 1e-12f32 * 13f32.powi((4 * a + b) as i32));
        let table = Table { grid, fold, values };
        let encoding = LogEncoding::of(&table, DEFAULT_BIAS);
        for (f, v) in table.values.iter().zip(log_encode(&table, encoding).values.iter()) {
            assert!((f64::from(*v) - encoding.encode(f64::from(*f))).abs() < 2e-6, "{f} {v}");
        }
    }

    proptest! {
        #[test]
        fn decode_inverts_encode(log_f in -12.0f64..6.0, log_mean in -6.0f64..3.0) {
            let encoding = LogEncoding { mean: 10f64.powf(log_mean), bias: DEFAULT_BIAS };
            let f = 10f64.powf(log_f);
            let back = encoding.decode(encoding.encode(f));
            prop_assert!((back - f).abs() <= 1e-12 * (f + encoding.mean));
        }
    }
}
