//! Principal components of texels, as vectors of red, green and blue under all lights.

use nalgebra::{DMatrix, DMatrixView, DVector, Matrix3xX, Vector3};

/// Additional components of the iteration, whose own convergence does not matter.
const SPARE: usize = 8;
/// Iterations; each multiplies the error by the ratio of the eigenvalues of a spare and a kept component.
const ITERATIONS: usize = 12;

/// Mean and principal components of values. Entries are red of all lights, then green, then blue.
pub struct Components {
    /// Mean of each entry.
    pub mean: DVector<f64>,
    /// Orthonormal columns, the strongest first.
    pub axes: DMatrix<f64>,
}

impl Components {
    /// Computes at most `count` components of `values`: a row for each light and channel, a column for each texel. Fewer if
    /// values have fewer dimensions. Subspace iteration (Bauer 1957) on the covariance.
    pub fn new(values: &DMatrix<f64>, count: usize) -> Self {
        let (entries, mean) = (values.nrows(), values.column_mean());
        let centred = Self::centred(values, &mean);
        let covariance = &centred * centred.transpose();
        let wide = (count + SPARE).min(entries);
        let mut state = 1u32;
        let mut axes = DMatrix::from_fn(entries, wide, |_, _| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        });
        for _ in 0..ITERATIONS {
            axes = (&covariance * axes).qr().q();
        }
        let small = axes.transpose() * &covariance * &axes;
        let eigen = small.symmetric_eigen();
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]).then(a.cmp(b)));
        // Directions without variance are rounding.
        let least = 1e-12 * values.norm_squared();
        order.retain(|k| eigen.eigenvalues[*k] > least);
        order.truncate(count);
        Self { mean, axes: axes * eigen.eigenvectors.select_columns(&order) }
    }

    /// Coefficients of values: a row for each component, a column for each texel.
    pub fn coefficients(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        self.axes.transpose() * Self::centred(values, &self.mean)
    }

    /// Rows of the first axes that belong to a light: its red, green and blue.
    pub fn rows(&self, light: usize, axes: usize) -> Matrix3xX<f64> {
        let lights = self.mean.len() / 3;
        Matrix3xX::from_fn(axes, |channel, axis| self.axes[(channel * lights + light, axis)])
    }

    /// Mean colour under a light.
    pub fn mean_colour(&self, light: usize) -> Vector3<f64> {
        let lights = self.mean.len() / 3;
        Vector3::from_fn(|channel, _| self.mean[channel * lights + light])
    }

    /// Colours of texels under a light, from the coefficients of the first components.
    pub fn colours(&self, light: usize, coefficients: &DMatrixView<'_, f64>) -> Matrix3xX<f64> {
        let mut colours = self.rows(light, coefficients.nrows()) * coefficients;
        let mean = self.mean_colour(light);
        colours.column_iter_mut().for_each(|mut colour| colour += mean);
        colours
    }

    fn centred(values: &DMatrix<f64>, mean: &DVector<f64>) -> DMatrix<f64> {
        let mut centred = values.clone();
        centred.column_iter_mut().for_each(|mut column| column -= mean);
        centred
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answer: texels in a plane of many dimensions have two components, which span it.
    #[test]
    fn components_span_the_values() {
        let directions = [[1.0, 2.0, 0.0, -1.0, 0.5], [0.0, 1.0, 1.0, 1.0, -2.0]];
        let amounts = |i: usize| [(i as f64 * 0.7).sin() * 3.0, (i as f64 * 1.3).cos()];
        let values = DMatrix::from_fn(5, 50, |j, i| {
            let [a, b] = amounts(i);
            4.0 + a * directions[0][j] + b * directions[1][j]
        });
        let found = Components::new(&values, 4);
        assert_eq!(found.axes.ncols(), 2);
        let identity = found.axes.transpose() * &found.axes;
        assert!((identity - DMatrix::identity(2, 2)).amax() < 1e-10);
        let left = |components: &Components| {
            let mut off = values.clone() - &components.axes * components.coefficients(&values);
            off.column_iter_mut().for_each(|mut column| column -= &components.mean);
            off.amax()
        };
        // One component is not enough.
        let one = Components::new(&values, 1);
        assert!(left(&found) < 1e-9 && left(&one) > 0.1);
        assert_eq!(Components::new(&DMatrix::from_element(3, 9, 2.0), 4).axes.ncols(), 0);
    }
}
