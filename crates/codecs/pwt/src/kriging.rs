//! Interpolation between the lights: kriging (Matheron 1963), a weighted mean of the values at the measured lights whose
//! weights follow from a covariance function of two directions.
//!
//! No covariance function suits every material: highlights need short ranges, diffuse shading long ones. Many are tried, and a
//! convex combination of the best minimises the squared error of predictions of each light from all others. These predictions
//! follow from the inverse of one matrix (Dubrule 1983).

use crate::stack::spread;
use nalgebra::{DMatrix, DMatrixView};
use rayon::prelude::*;

/// Number of covariance functions that are combined, for up to [`COMPARED_LIGHTS`] lights; fewer for more.
const COMBINED: usize = 24;
const MIN_COMBINED: usize = 4;
/// Maximum number of lights by which covariance functions are compared before they are combined.
const COMPARED_LIGHTS: usize = 96;
/// Steps of the combination.
const STEPS: usize = 400;
/// Covariance functions whose weight is below this share are left out.
const MIN_SHARE: f64 = 1e-3;
/// Keeps systems solvable if the lights do not determine the trend.
const REGULAR: f64 = 1e-9;

/// Shapes of covariance functions, as functions of the distance over the range.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Exponential,
    Matern3,
    Matern5,
    Gaussian,
    /// Polynomials of unit vectors: `((1 + a · b) / 2)^degree`, which is a function of the distance, too.
    Polynomial(i32),
}

/// Coordinates in which covariance functions see lights.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    /// On the paraboloid.
    Paraboloid,
    /// Unit vectors.
    Direction,
    /// The sphere of hemispherical harmonics, on which the whole horizon is one point.
    Hemisphere,
}

/// Paraboloid coordinates of a light.
pub fn paraboloid(light: [f32; 3]) -> [f64; 2] {
    let [x, y, z] = light.map(f64::from);
    [x / (1.0 + z), y / (1.0 + z)]
}

impl Place {
    fn of(self, light: [f32; 3]) -> [f64; 3] {
        let [x, y, z] = light.map(f64::from);
        match self {
            Self::Paraboloid => {
                let [u, v] = paraboloid(light);
                [u, v, 0.0]
            }
            Self::Direction => [x, y, z],
            Self::Hemisphere => {
                let z = z.max(0.0);
                let scale = 2.0 * (z / (1.0 + z)).sqrt();
                [scale * x, scale * y, 2.0 * z - 1.0]
            }
        }
    }
}

/// A covariance function, and the trend that it is the deviation from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    shape: Shape,
    place: Place,
    range: f64,
    /// Variance that is not shared with other lights, as a share of the whole.
    nugget: f64,
    /// True for a trend that is linear in x and y, otherwise constant.
    linear_trend: bool,
}

impl Covariance {
    /// All covariance functions that are tried.
    fn candidates() -> Vec<Self> {
        let mut all = Vec::new();
        for shape in [Shape::Exponential, Shape::Matern3, Shape::Matern5, Shape::Gaussian] {
            for place in [Place::Paraboloid, Place::Direction, Place::Hemisphere] {
                for range in [0.3, 0.6, 1.2, 2.4] {
                    for nugget in [1e-4, 1e-3, 1e-2, 1e-1] {
                        for linear_trend in [false, true] {
                            all.push(Self { shape, place, range, nugget, linear_trend });
                        }
                    }
                }
            }
        }
        for shape in [2, 3, 4, 6, 8].map(Shape::Polynomial) {
            for place in [Place::Direction, Place::Hemisphere] {
                for nugget in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
                    all.push(Self { shape, place, range: 1.0, nugget, linear_trend: false });
                }
            }
        }
        all
    }

    fn of_lights(&self, a: [f32; 3], b: [f32; 3]) -> f64 {
        let (a, b) = (self.place.of(a), self.place.of(b));
        let distance = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / self.range;
        match self.shape {
            Shape::Exponential => (-distance).exp(),
            Shape::Matern3 => {
                let d = 3f64.sqrt() * distance;
                (1.0 + d) * (-d).exp()
            }
            Shape::Matern5 => {
                let d = 5f64.sqrt() * distance;
                (1.0 + d + d * d / 3.0) * (-d).exp()
            }
            Shape::Gaussian => (-0.5 * distance * distance).exp(),
            Shape::Polynomial(degree) => (1.0 - 0.25 * distance * distance).powi(degree),
        }
    }

    fn trend(&self, [x, y, _]: [f32; 3]) -> Vec<f64> {
        if self.linear_trend { vec![1.0, f64::from(x), f64::from(y)] } else { vec![1.0] }
    }

    /// Inverse of the system of the lights, with the conditions of the trend.
    fn inverse(&self, lights: &[[f32; 3]]) -> Option<DMatrix<f64>> {
        let (count, trends) = (lights.len(), if self.linear_trend { 3 } else { 1 });
        let system = DMatrix::from_fn(count + trends, count + trends, |i, j| match (i < count, j < count) {
            (true, true) if i == j => 1.0 + self.nugget,
            (true, true) => self.of_lights(lights[i], lights[j]),
            (true, false) => self.trend(lights[i])[j - count],
            (false, true) => self.trend(lights[j])[i - count],
            (false, false) => {
                if i == j {
                    -REGULAR
                } else {
                    0.0
                }
            }
        });
        system.try_inverse().filter(|inverse| inverse.iter().all(|number| number.is_finite()))
    }

    /// Matrix from the values at all lights to the errors of predictions of each light from the others.
    fn left_out(&self, lights: &[[f32; 3]]) -> Option<DMatrix<f64>> {
        let count = lights.len();
        let mut errors = self.inverse(lights)?.view((0, 0), (count, count)).into_owned();
        for i in 0..count {
            let diagonal = errors[(i, i)];
            if diagonal <= REGULAR {
                return None;
            }
            errors.row_mut(i).iter_mut().for_each(|number| *number /= diagonal);
        }
        Some(errors)
    }

    /// Matrix from the values at the lights to predictions at other directions.
    fn predictions(&self, lights: &[[f32; 3]], at: &[[f32; 3]]) -> Option<DMatrix<f64>> {
        let (count, inverse) = (lights.len(), self.inverse(lights)?);
        let seen = DMatrix::from_fn(at.len(), inverse.nrows(), |i, j| {
            if j < count { self.of_lights(at[i], lights[j]) } else { self.trend(at[i])[j - count] }
        });
        Some(seen * inverse.columns(0, count))
    }
}

/// A convex combination of covariance functions.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    parts: Vec<(f64, Covariance)>,
    /// Matrix from the values at all lights to the errors of predictions of each light from the others; `None` if no light can be
    /// left out.
    pub left_out: Option<DMatrix<f64>>,
}

impl Default for Interpolation {
    /// An interpolation for a few lights, which cannot be left out.
    fn default() -> Self {
        let covariance = Covariance {
            shape: Shape::Matern5,
            place: Place::Direction,
            range: 1.2,
            nugget: 1e-3,
            linear_trend: false,
        };
        Self { parts: vec![(1.0, covariance)], left_out: None }
    }
}

/// Covariance functions that suit some values best, with their errors at lights that are left out.
pub struct Shortlist {
    covariances: Vec<(Covariance, DMatrix<f64>)>,
}

impl Shortlist {
    /// Compares all covariance functions on values: rows are lights. Uses only some lights of many.
    pub fn new(lights: &[[f32; 3]], values: &DMatrix<f64>) -> Self {
        // Lists go ring by ring.
        let (count, some) = (lights.len(), spread(lights.len(), COMPARED_LIGHTS));
        let few: Vec<[f32; 3]> = some.iter().map(|light| lights[*light]).collect();
        let products = values.select_rows(&some);
        let products = &products * products.transpose();
        let tried = Covariance::candidates().into_par_iter().map(|covariance| {
            let errors = covariance.left_out(&few);
            let squares = errors.as_ref().map(|errors| squares(errors, &products));
            (covariance, errors, squares)
        });
        let tried: Vec<_> = tried.collect();
        let mut found: Vec<_> =
            tried.into_iter().filter_map(|(c, e, s)| Some((c, e?, s.filter(|s| s.is_finite())?))).collect();
        found.sort_by(|a, b| a.2.total_cmp(&b.2));
        found.truncate((COMBINED * COMPARED_LIGHTS / lights.len().max(COMPARED_LIGHTS)).max(MIN_COMBINED));
        let of_all = |(covariance, errors, _): (Covariance, DMatrix<f64>, f64)| {
            let errors = if some.len() == count { Some(errors) } else { covariance.left_out(lights) };
            Some((covariance, errors?))
        };
        Self { covariances: found.into_par_iter().filter_map(of_all).collect() }
    }

    /// The combination with the smallest squared error on values at lights that are left out; `None` if none can be.
    pub fn combined(&self, values: &DMatrix<f64>) -> Option<Interpolation> {
        let products = values * values.transpose();
        let count = self.covariances.len();
        let seen: Vec<DMatrix<f64>> = self.covariances.iter().map(|(_, errors)| errors * &products).collect();
        let squares = DMatrix::from_fn(count, count, |i, j| seen[i].dot(&self.covariances[j].1));
        let weights = least_on_simplex(&squares)?;
        let kept = || weights.iter().zip(&self.covariances).filter(|(weight, _)| **weight >= MIN_SHARE);
        let whole: f64 = kept().map(|(weight, _)| weight).sum();
        let parts = kept().map(|(weight, (covariance, _))| (weight / whole, *covariance)).collect();
        let mut errors = DMatrix::zeros(products.nrows(), products.ncols());
        kept().for_each(|(weight, (_, of_one))| errors += of_one * (weight / whole));
        Some(Interpolation { parts, left_out: Some(errors) })
    }
}

impl Interpolation {
    /// Matrix from the values at the lights to predictions at other directions: a row for each of `at`.
    pub fn predictions(&self, lights: &[[f32; 3]], at: &[[f32; 3]]) -> DMatrix<f64> {
        let of_part = |(weight, covariance): &(f64, Covariance)| {
            covariance.predictions(lights, at).map(|predictions| predictions * *weight)
        };
        let parts: Vec<Option<DMatrix<f64>>> = self.parts.par_iter().map(of_part).collect();
        let sum = parts.into_iter().flatten().reduce(|sum, part| sum + part);
        // The mean of all lights if nothing can be solved.
        sum.unwrap_or_else(|| DMatrix::from_element(at.len(), lights.len(), 1.0 / lights.len().max(1) as f64))
    }
}

/// Sum of squares of `errors * values`, from the products of the values of two lights.
fn squares(errors: &DMatrix<f64>, products: &DMatrix<f64>) -> f64 {
    (errors * products).dot(errors)
}

/// Weights of 0 or more with the sum 1 that minimise `w^T squares w`: moves weight between the best pair, repeatedly.
fn least_on_simplex(squares: &DMatrix<f64>) -> Option<Vec<f64>> {
    let count = squares.nrows();
    let first = (0..count).min_by(|a, b| squares[(*a, *a)].total_cmp(&squares[(*b, *b)]))?;
    let mut weights = vec![0.0; count];
    weights[first] = 1.0;
    let mut slopes: Vec<f64> = squares.column(first).iter().copied().collect();
    for _ in 0..STEPS {
        let to = (0..count).min_by(|a, b| slopes[*a].total_cmp(&slopes[*b]))?;
        let used = (0..count).filter(|k| weights[*k] > 0.0);
        let from = used.max_by(|a, b| slopes[*a].total_cmp(&slopes[*b]))?;
        let curvature = squares[(to, to)] + squares[(from, from)] - 2.0 * squares[(to, from)];
        let gain = slopes[from] - slopes[to];
        if gain <= 1e-12 * squares[(first, first)] || curvature <= 0.0 {
            break;
        }
        let moved = (gain / curvature).min(weights[from]);
        weights[to] += moved;
        weights[from] -= moved;
        for (k, slope) in slopes.iter_mut().enumerate() {
            *slope += moved * (squares[(k, to)] - squares[(k, from)]);
        }
    }
    Some(weights)
}

/// Values of every light as the rows of a matrix.
pub fn rows(values: &[Vec<f32>]) -> DMatrix<f64> {
    let columns = values.first().map_or(0, Vec::len);
    let numbers: Vec<f64> = values.iter().flatten().map(|value| f64::from(*value)).collect();
    DMatrixView::from_slice(&numbers, columns, values.len()).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ptm::spread_lights;

    /// Values of a smooth function and of noise at lights, a row for each light.
    fn values(lights: &[[f32; 3]], noise: f64) -> DMatrix<f64> {
        let mut state = 7u32;
        DMatrix::from_fn(lights.len(), 40, |i, j| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [x, y, z] = lights[i].map(f64::from);
            let angle = 0.7 * j as f64;
            let lobe = (x * angle.cos() + y * angle.sin() + 1.5 * z).powi(4) / 10.0;
            lobe + noise * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
        })
    }

    /// Errors at lights that are left out are those of a fit without each light.
    #[test]
    fn left_out_errors_are_those_of_fits_without_a_light() {
        let lights = spread_lights(20);
        let values = values(&lights, 0.1);
        for covariance in Covariance::candidates().into_iter().step_by(7) {
            let errors = covariance.left_out(&lights).unwrap() * &values;
            for left_out in [0, 9, 19] {
                let rest: Vec<usize> = (0..20).filter(|k| *k != left_out).collect();
                let few: Vec<[f32; 3]> = rest.iter().map(|k| lights[*k]).collect();
                let predicted = covariance.predictions(&few, &[lights[left_out]]).unwrap() * values.select_rows(&rest);
                let expected = values.row(left_out) - predicted.row(0);
                let off = (errors.row(left_out) - expected).amax();
                assert!(off < 1e-4 * values.amax(), "{covariance:?} {off}");
            }
        }
    }

    /// A smooth function is predicted between the lights; a rotation of the lights is the negative control.
    #[test]
    fn smooth_functions_are_predicted() {
        let lights = spread_lights(60);
        let between: Vec<[f32; 3]> = spread_lights(37).into_iter().filter(|light| light[2] > 0.3).collect();
        let (known, expected) = (values(&lights, 0.0), values(&between, 0.0));
        let interpolation = Shortlist::new(&lights, &known).combined(&known).unwrap();
        let error = |lights: &[[f32; 3]]| {
            (interpolation.predictions(lights, &between) * &known - &expected).norm() / expected.norm()
        };
        let turned: Vec<[f32; 3]> = lights.iter().map(|[x, y, z]| [-y, *x, *z]).collect();
        let [found, wrong] = [error(&lights), error(&turned)];
        assert!(found < 0.01 && wrong > 0.2, "{found} {wrong}");
        // A constant is predicted everywhere.
        let ones = DMatrix::from_element(lights.len(), 1, 2.0);
        assert!((interpolation.predictions(&lights, &between) * ones).iter().all(|value| (value - 2.0).abs() < 1e-6));
    }

    /// A combination is no worse than its parts, and noise gets smoothed: errors are near the noise, not twice.
    #[test]
    fn combinations_are_no_worse_than_their_parts() {
        let lights = spread_lights(60);
        let noisy = values(&lights, 0.5);
        let shortlist = Shortlist::new(&lights, &noisy);
        let combined = (shortlist.combined(&noisy).unwrap().left_out.unwrap() * &noisy).norm();
        let parts = shortlist.covariances.iter().map(|(_, errors)| (errors * &noisy).norm());
        let best = parts.fold(f64::INFINITY, f64::min);
        assert!(combined <= best * (1.0 + 1e-9), "{combined} {best}");
        let noise = (noisy.len() as f64 * 0.25 / 12.0).sqrt();
        assert!((0.9..1.25).contains(&(combined / noise)), "{combined} {noise}");
    }

    #[test]
    fn few_lights_have_an_interpolation() {
        for lights in [spread_lights(1), spread_lights(2), vec![[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8]]] {
            let known = values(&lights, 0.0);
            let interpolation = Shortlist::new(&lights, &known).combined(&known).unwrap_or_default();
            let found = interpolation.predictions(&lights, &spread_lights(5)) * &known;
            assert!(found.iter().all(|value| value.is_finite()));
        }
    }
}
