//! Section 2, "Adaptive data fitting": terms of the light's direction at the sampled lights, factored once for all
//! coefficients and all degrees.
//!
//! Least squares with a penalty on roughness, `Σ_i (v_i - Σ_k c_k φ_k(l_i))² + λ N Σ_k (d_k (d_k + 1))² c_k²`: `d (d +
//! 1)` is the eigenvalue of the Laplacian on the sphere for harmonics of degree d. The normal equations are factored as
//! `L L^T`. With the weights `w = L^-1 φ`, fitting is a product with `w(l_i)`, the first coefficients are the fit of
//! lower degree, and dropping a coefficient costs its square.

use brdfc_formats::pwt::LightBasis;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Candidate ridges, from rough to smooth.
pub const RIDGES: [f64; 8] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Minimum of `1 - h_ii`, by which residuals of 32 bits are divided.
const MIN_FREEDOM: f64 = 1e-3;

/// Factored design matrix: the terms at the lights.
#[derive(Debug, Clone)]
pub struct Design {
    /// The terms.
    pub basis: LightBasis,
    /// Ridge: `λ`.
    pub ridge: f64,
    /// Weight of each term at each light, light by light.
    pub weights: Vec<f64>,
    /// Lower triangle that converts terms to weights: row `k` has `k + 1` numbers.
    pub triangle: Vec<f64>,
    /// Condition number of the normal equations.
    pub condition: f64,
}

impl Design {
    /// Factors the design for some lights. A solution always exists, even with fewer lights than terms or with
    /// collinear lights: the penalty makes undetermined components smooth.
    pub fn new(basis: LightBasis, lights: &[[f32; 3]], ridge: f64) -> Self {
        let terms = basis.terms();
        let norms = norms(basis);
        let matrix = DMatrix::from_fn(lights.len(), terms, |i, k| f64::from(basis.evaluate(lights[i])[k]) / norms[k]);
        let mut normal = matrix.transpose() * &matrix;
        for k in 0..terms {
            let degree = f64::from(basis.degree_of(k));
            normal[(k, k)] += ridge * lights.len() as f64 * (degree * (degree + 1.0)).powi(2);
        }
        let values = normal.clone().symmetric_eigenvalues();
        let condition = values.max() / values.min().max(f64::MIN_POSITIVE);
        // Rounding may leave a pivot below 0 where the lights do not determine a term.
        let floor = 1e-13 * normal.diagonal().max();
        for k in 0..terms {
            normal[(k, k)] += floor;
        }
        let factor = Cholesky::new(normal).expect("the penalty and the floor make it positive definite").unpack();
        let columns = (0..terms).map(|k| {
            let unit = DVector::from_fn(terms, |row, _| if row == k { 1.0 } else { 0.0 });
            factor.solve_lower_triangular(&unit).expect("its diagonal is positive")
        });
        let inverse = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let weights = matrix * inverse.transpose();
        let triangle = (0..terms).flat_map(|k| (0..=k).map(move |j| (k, j))).map(|(k, j)| inverse[(k, j)] / norms[j]);
        Self {
            basis,
            ridge,
            weights: weights.transpose().iter().copied().collect(),
            triangle: triangle.collect(),
            condition,
        }
    }

    /// Number of terms.
    pub fn terms(&self) -> usize {
        self.basis.terms()
    }

    /// Weights of all terms at a light.
    pub fn row(&self, light: usize) -> &[f64] {
        &self.weights[light * self.terms()..][..self.terms()]
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.weights.len() / self.terms()
    }

    /// Leverages `h_ii`, the diagonal of the hat matrix, for the terms up to a degree. The leave-one-out error of a
    /// light is its residual divided by `1 - h_ii`.
    ///
    /// Returns `None` if a light determines its own prediction, as with fewer lights than terms and a small ridge: then
    /// the residual is rounding and does not yield a leave-one-out error.
    pub fn leverages(&self, degree: u32) -> Option<Vec<f64>> {
        let terms = LightBasis { degree, ..self.basis }.terms();
        let leverage = |light| self.row(light)[..terms].iter().map(|w| w * w).sum::<f64>();
        let leverages: Vec<f64> = (0..self.lights()).map(leverage).collect();
        leverages.iter().all(|leverage| 1.0 - leverage >= MIN_FREEDOM).then_some(leverages)
    }
}

/// Root mean squares of terms over the hemisphere.
fn norms(basis: LightBasis) -> Vec<f64> {
    const HEIGHTS: usize = 24;
    const AZIMUTHS: usize = 48;
    let mut sums = vec![0.0f64; basis.terms()];
    for k in 0..HEIGHTS * AZIMUTHS {
        let z = ((k / AZIMUTHS) as f64 + 0.5) / HEIGHTS as f64;
        let azimuth = ((k % AZIMUTHS) as f64 + 0.5) / AZIMUTHS as f64 * std::f64::consts::TAU;
        let r = (1.0 - z * z).sqrt();
        let terms = basis.evaluate([r * azimuth.cos(), r * azimuth.sin(), z].map(|c| c as f32));
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += f64::from(term).powi(2));
    }
    sums.iter().map(|sum| (sum / (HEIGHTS * AZIMUTHS) as f64).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::pwt::LightCoordinates;

    /// Lights on a spiral from the pole to near the horizon.
    fn lights(count: usize) -> Vec<[f32; 3]> {
        let light = |k: usize| {
            let z = 1.0 - 0.9 * (k as f32 + 0.5) / count as f32;
            let (r, phi) = ((1.0 - z * z).sqrt(), 2.4 * k as f32);
            [r * phi.cos(), r * phi.sin(), z]
        };
        (0..count).map(light).collect()
    }

    fn fit(design: &Design, values: &[f64]) -> Vec<f64> {
        let coefficient = |k: usize| values.iter().enumerate().map(|(i, v)| design.row(i)[k] * v).sum::<f64>();
        (0..design.terms()).map(coefficient).collect()
    }

    /// Weights of all terms at any light.
    fn weights_at(design: &Design, light: [f32; 3]) -> Vec<f64> {
        let terms = design.basis.evaluate(light);
        let row = |k: usize| &design.triangle[k * (k + 1) / 2..][..=k];
        let weight = |k: usize| row(k).iter().zip(terms).map(|(t, term)| t * f64::from(term)).sum();
        (0..design.terms()).map(weight).collect()
    }

    fn predict(design: &Design, light: usize, coefficients: &[f64], terms: usize) -> f64 {
        design.row(light).iter().zip(coefficients).take(terms).map(|(w, c)| w * c).sum()
    }

    /// Known answer: sums of terms are recovered.
    #[test]
    fn polynomials_are_fitted_exactly() {
        let lights = lights(40);
        for coordinates in LightCoordinates::POLYNOMIAL {
            let basis = LightBasis { coordinates, degree: 3 };
            let values: Vec<f64> = lights
                .iter()
                .map(|l| basis.evaluate(*l).iter().enumerate().map(|(k, t)| k as f64 * f64::from(*t)).sum())
                .collect();
            let design = Design::new(basis, &lights, 1e-12);
            let coefficients = fit(&design, &values);
            for (i, value) in values.iter().enumerate() {
                let found = predict(&design, i, &coefficients, design.terms());
                assert!((found - value).abs() < 1e-4 * (1.0 + value.abs()), "{coordinates:?} {found} {value}");
            }
            // The negative control: one degree too few.
            let few = LightBasis { degree: 2, ..basis }.terms();
            assert!((0..40).any(|i| (predict(&design, i, &coefficients, few) - values[i]).abs() > 0.1));
        }
    }

    /// The first coefficients equal the coefficients of a fit of lower degree, and the residual divided by `1 - h_ii`
    /// is the leave-one-out error.
    #[test]
    fn lower_degrees_and_lights_left_out() {
        let lights = lights(30);
        let values: Vec<f64> = (0..30).map(|k| f64::from(k * k % 17) / 17.0).collect();
        let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 3 };
        let design = Design::new(basis, &lights, 1e-3);
        let coefficients = fit(&design, &values);
        let low = Design::new(LightBasis { degree: 2, ..basis }, &lights, 1e-3);
        for (a, b) in fit(&low, &values).iter().zip(&coefficients) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        let leverages = design.leverages(3).unwrap();
        for left_out in [0, 7, 29] {
            let without = |k: &usize| *k != left_out;
            let others: Vec<[f32; 3]> = (0..30).filter(without).map(|k| lights[k]).collect();
            // The penalty is per light.
            let design_without = Design::new(basis, &others, 1e-3 * 30.0 / 29.0);
            let others: Vec<f64> = (0..30).filter(without).map(|k| values[k]).collect();
            let weights = weights_at(&design_without, lights[left_out]);
            let found: f64 = fit(&design_without, &others).iter().zip(&weights).map(|(c, w)| c * w).sum();
            let residual = values[left_out] - predict(&design, left_out, &coefficients, design.terms());
            let expected = values[left_out] - residual / (1.0 - leverages[left_out]);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }

    /// The leave-one-out error of few lights matches the residual, or is `None`, for every ridge.
    #[test]
    fn few_lights_left_out() {
        let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 2 };
        let mut said = 0;
        for count in [1usize, 2, 3, 4, 6, 9] {
            let all = lights(count);
            let values: Vec<f64> = (0..count).map(|k| (k * k * 5 % 7) as f64 / 7.0).collect();
            for ridge in RIDGES {
                let design = Design::new(basis, &all, ridge);
                let coefficients = fit(&design, &values);
                for degree in 0..=2 {
                    let Some(leverages) = design.leverages(degree) else { continue };
                    assert!(count > 1, "a single light has no leave-one-out error");
                    let terms = LightBasis { degree, ..basis }.terms();
                    let own = LightBasis { degree, ..basis };
                    for left_out in 0..count {
                        let without = |k: &usize| *k != left_out;
                        let others: Vec<[f32; 3]> = (0..count).filter(without).map(|k| all[k]).collect();
                        let ridge = ridge * count as f64 / (count - 1) as f64;
                        let refitted = Design::new(own, &others, ridge);
                        let others: Vec<f64> = (0..count).filter(without).map(|k| values[k]).collect();
                        let found: f64 = fit(&refitted, &others)
                            .iter()
                            .zip(weights_at(&refitted, all[left_out]))
                            .map(|(c, w)| c * w)
                            .sum();
                        let residual = values[left_out] - predict(&design, left_out, &coefficients, terms);
                        let expected = values[left_out] - residual / (1.0 - leverages[left_out]);
                        assert!((found - expected).abs() < 1e-3, "{count} lights, {ridge}: {found} {expected}");
                        said += 1;
                    }
                }
            }
        }
        assert!(said > 100, "{said}");
    }

    /// Fewer lights than terms, equal and collinear lights: results are finite and smooth.
    #[test]
    fn poor_lights_have_a_fit() {
        let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 5 };
        let line: Vec<[f32; 3]> = (1..20)
            .map(|k| {
                let a = k as f32 * 0.15;
                [a.cos(), 0.0, a.sin()]
            })
            .collect();
        for lights in [lights(3), vec![[0.0, 0.6, 0.8]; 12], line] {
            let design = Design::new(basis, &lights, 1e-4);
            assert!(design.weights.iter().chain(&design.triangle).all(|w| w.is_finite()));
            assert!(design.condition > 1.0);
            let coefficients = fit(&design, &vec![0.5; lights.len()]);
            let found = predict(&design, 0, &coefficients, design.terms());
            assert!((found - 0.5).abs() < 1e-3, "{found}");
        }
    }
}
