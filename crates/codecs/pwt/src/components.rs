//! Principal components of texels, as vectors of red, green and blue under all lights.

use nalgebra::{DMatrix, DMatrixView, DVector, Matrix3xX, Vector3};

/// Additional components of the iteration, whose own convergence does not matter.
const SPARE: usize = 8;
/// Iterations; each multiplies the error by the ratio of the eigenvalues of a spare and a kept component.
const ITERATIONS: usize = 12;

/// Mean and principal components of weighted values. Entries are red of all lights, then green, then blue.
pub struct Components {
    /// Mean of each entry, without its weight.
    pub mean: DVector<f64>,
    /// Orthonormal columns, the strongest first: of entries times their weights.
    pub axes: DMatrix<f64>,
    /// Weight of each entry.
    pub weights: DVector<f64>,
}

impl Components {
    /// Computes at most `count` components of `values`: a row for each light and channel, a column for each texel. They minimise the
    /// squared error times the squared weights of the rows. Fewer if values have fewer dimensions. Subspace iteration (Bauer 1957) on
    /// the covariance.
    pub fn new(values: &DMatrix<f64>, weights: DVector<f64>, count: usize) -> Self {
        let entries = values.nrows();
        let mut components = Self { mean: values.column_mean(), axes: DMatrix::zeros(entries, 0), weights };
        let centred = components.centred(values);
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
        let least = 1e-12 * values.norm_squared() * components.weights.norm_squared() / entries as f64;
        order.retain(|k| eigen.eigenvalues[*k] > least);
        order.truncate(count);
        components.axes = axes * eigen.eigenvectors.select_columns(&order);
        components
    }

    /// Coefficients of values: a row for each component, a column for each texel.
    pub fn coefficients(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        self.axes.transpose() * self.centred(values)
    }

    /// The axes without the weights of the entries.
    pub fn unweighted(&self) -> DMatrix<f64> {
        let mut axes = self.axes.clone();
        axes.column_iter_mut().for_each(|mut axis| axis.component_div_assign(&self.weights));
        axes
    }

    /// Rows of the first axes that belong to a light: its red, green and blue.
    pub fn rows(&self, light: usize, axes: usize) -> Matrix3xX<f64> {
        let lights = self.mean.len() / 3;
        Matrix3xX::from_fn(axes, |channel, axis| self.axes[(channel * lights + light, axis)])
    }

    /// Red, green and blue of entries under a light.
    pub fn of_light(entries: &DVector<f64>, light: usize) -> Vector3<f64> {
        let lights = entries.len() / 3;
        Vector3::from_fn(|channel, _| entries[channel * lights + light])
    }

    /// Colours of texels under a light, from the coefficients of the first components.
    pub fn colours(&self, light: usize, coefficients: &DMatrixView<'_, f64>) -> Matrix3xX<f64> {
        let mut colours = self.rows(light, coefficients.nrows()) * coefficients;
        let [mean, weights] = [&self.mean, &self.weights].map(|entries| Self::of_light(entries, light));
        colours.column_iter_mut().for_each(|mut colour| colour.copy_from(&(mean + colour.component_div(&weights))));
        colours
    }

    /// Weighted deviations from the mean.
    fn centred(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let mut centred = values.clone();
        for mut column in centred.column_iter_mut() {
            column -= &self.mean;
            column.component_mul_assign(&self.weights);
        }
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
        let weights = DVector::from_vec(vec![1.0, 0.5, 2.0, 1.0, 0.1]);
        let found = Components::new(&values, weights.clone(), 4);
        assert_eq!(found.axes.ncols(), 2);
        let identity = found.axes.transpose() * &found.axes;
        assert!((identity - DMatrix::identity(2, 2)).amax() < 1e-10);
        let left = |components: &Components| {
            let mut off = values.clone() - components.unweighted() * components.coefficients(&values);
            off.column_iter_mut().for_each(|mut column| column -= &components.mean);
            off
        };
        // One component is not enough.
        let one = Components::new(&values, weights.clone(), 1);
        assert!(left(&found).amax() < 1e-9 && left(&one).amax() > 0.1);
        assert_eq!(
            Components::new(&DMatrix::from_element(3, 9, 2.0), DVector::from_element(3, 1.0), 4).axes.ncols(),
            0
        );
        // The weighted error is least with these weights, the other one without.
        let even = Components::new(&values, DVector::from_element(5, 1.0), 1);
        let errors = |components: &Components| {
            let off = left(components);
            [DMatrix::from_diagonal(&weights) * &off, off].map(|off| off.norm())
        };
        let [with, without] = [errors(&one), errors(&even)];
        assert!(with[0] < 0.99 * without[0] && without[1] < 0.99 * with[1], "{with:?} {without:?}");
    }
}
