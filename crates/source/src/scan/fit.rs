//! Moving least squares: a local polynomial through the neighbours of the queried point (section 3 of Claustres et al.
//! 2007).
//!
//! With offsets `p` from the queried point, in units of the distance to the first unused neighbour, a weight `(1 -
//! |p|³)³` and the basis `1, p, p pᵀ`, the value of the fit at `p = 0` is its constant term. A second pass reduces the
//! weights of neighbours that the first fit misses (biweight). Linear and quadratic fit share one elimination: the
//! linear normal matrix is the leading block of the quadratic one.
//!
//! The trust in a fit depends on its variance factor `[(BᵀWB)⁻¹]₀₀`, the variance of its value for data of unit
//! variance (1 for a plain mean): full below 20, none above 200, where a neighbourhood is rank-deficient or
//! ill-conditioned for that degree. In between the value is blended with the next lower degree, down to the weighted
//! mean.

use brdfc_core::Tally;

/// Neighbours of a fit in 3 dimensions.
pub const NEIGHBOURS_3D: usize = 14;
/// Neighbours of a fit in 4 dimensions.
pub const NEIGHBOURS_4D: usize = 20;
/// Maximum number of neighbours of a fit.
const MOST: usize = 20;
/// Terms of a quadratic in 3 dimensions.
pub const TERMS_3D: usize = 10;
/// Terms of a quadratic in 4 dimensions.
pub const TERMS_4D: usize = 15;
/// Regularisation of the normal matrix: added to the diagonal for constant, linear and quadratic terms.
pub const RIDGE: [f64; 3] = [2e-9, 1.01e-7, 5e-4];
/// Residual, in units of the median, above which a neighbour hardly counts.
const OUTLIER: f64 = 5.0;
/// Variance factors with full and with no trust.
const TRUST: [f64; 2] = [20.0, 200.0];
/// Share of the quadratic fit if both are trusted: it follows curvature, the linear one averages more noise.
const QUADRATIC_SHARE: f64 = 0.5;
/// Limit of extrapolation below the neighbours, in units of their range.
const MARGIN_BELOW: f64 = 0.1;

/// Neighbours of one queried point.
#[derive(Debug, Clone)]
pub struct Neighbourhood<const D: usize> {
    count: usize,
    offsets: [[f64; D]; MOST],
    weights: [f64; MOST],
    values: [[f64; 3]; MOST],
}

impl<const D: usize> Default for Neighbourhood<D> {
    fn default() -> Self {
        Self { count: 0, offsets: [[0.0; D]; MOST], weights: [0.0; MOST], values: [[0.0; 3]; MOST] }
    }
}

impl<const D: usize> Neighbourhood<D> {
    /// Adds a neighbour: its offset and distance in units of the support radius (a reciprocal row is farther than its
    /// offset), and log values. At most 20.
    pub fn push(&mut self, offset: [f64; D], distance: f64, value: [f64; 3]) {
        let distance = distance.min(1.0);
        self.offsets[self.count] = offset;
        self.weights[self.count] = weight(distance);
        self.values[self.count] = value;
        self.count += 1;
    }

    /// Fitted log values at the queried point for the first `channels` channels, limited to the range of the neighbours
    /// with a margin: a quadratic of `M` terms and a linear fit in equal shares, as far as they are trusted. Needs at
    /// least one neighbour.
    pub fn fit<const M: usize>(&self, channels: usize, tally: &mut Tally) -> [f64; 3] {
        let n = self.count;
        let mut weights = [0.0; MOST];
        weights[..n].copy_from_slice(&self.weights[..n]);
        normalise(&mut weights[..n]);

        let mut mean = [0.0; 3];
        for k in 0..n {
            for channel in 0..channels {
                mean[channel] += weights[k] * self.values[k][channel];
            }
        }
        let basis = self.basis::<M>();
        let mut residuals = [[0.0; 3]; MOST];
        for k in 0..n {
            for channel in 0..channels {
                residuals[k][channel] = self.values[k][channel] - mean[channel];
            }
        }
        let first = solve::<D, M>(&basis[..n], &weights[..n], &residuals[..n]);
        self.reweigh(&basis, &first, &residuals, channels, &mut weights);
        let second = solve::<D, M>(&basis[..n], &weights[..n], &residuals[..n]);

        let trust = second.variance.map(|v| ((TRUST[1] / v).ln() / (TRUST[1] / TRUST[0]).ln()).clamp(0.0, 1.0));
        tally.fell_to_constant += u64::from(trust[0] == 0.0 && trust[1] == 0.0);
        tally.fell_to_linear += u64::from(trust[0] > 0.0 && trust[1] == 0.0);

        let mut fitted = mean;
        let mut clamped = false;
        for channel in 0..channels {
            let linear = trust[0] * second.linear[channel][0];
            let blend = linear + QUADRATIC_SHARE * trust[1] * (second.quadratic[channel][0] - linear);
            let value = mean[channel] + blend;
            let (low, high) = self.range(channel);
            fitted[channel] = value.clamp(low - MARGIN_BELOW * (high - low), high);
            clamped |= fitted[channel] != value;
        }
        tally.clamped_to_neighbours += u64::from(clamped);
        fitted
    }

    /// Smallest and largest log value of the neighbours.
    pub fn range(&self, channel: usize) -> (f64, f64) {
        let values = self.values[..self.count].iter().map(|v| v[channel]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    /// `1, p, p pᵀ` of every neighbour.
    fn basis<const M: usize>(&self) -> [[f64; M]; MOST] {
        let mut basis = [[0.0; M]; MOST];
        for (row, p) in basis.iter_mut().zip(&self.offsets[..self.count]) {
            row[0] = 1.0;
            row[1..=D].copy_from_slice(p);
            let mut term = D + 1;
            for a in 0..D {
                for b in a..D {
                    row[term] = p[a] * p[b];
                    term += 1;
                }
            }
        }
        basis
    }

    /// Biweights from the residuals of the mean of both fits, over all channels together.
    fn reweigh<const M: usize>(
        &self,
        basis: &[[f64; M]; MOST],
        fit: &Solution<M>,
        residuals: &[[f64; 3]; MOST],
        channels: usize,
        weights: &mut [f64; MOST],
    ) {
        let n = self.count;
        let mut missed = [0.0; MOST];
        for k in 0..n {
            let mut square = 0.0;
            for channel in 0..channels {
                let linear: f64 = (0..=D).map(|t| basis[k][t] * fit.linear[channel][t]).sum();
                let quadratic: f64 = (0..M).map(|t| basis[k][t] * fit.quadratic[channel][t]).sum();
                square += (residuals[k][channel] - 0.5 * (linear + quadratic)).powi(2);
            }
            missed[k] = (square / channels as f64).sqrt();
        }
        let mut sorted = missed;
        sorted[..n].sort_unstable_by(f64::total_cmp);
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        for k in 0..n {
            let u = (missed[k] / (OUTLIER * median + 1e-3)).min(1.0);
            weights[k] *= biweight(u) + 1e-4;
        }
        normalise(&mut weights[..n]);
    }
}

/// Weight of a neighbour in the fit, by its distance in units of the support radius, 0 to 1: `(1 - d³)³`, tricube.
fn weight(distance: f64) -> f64 {
    (1.0 - distance.powi(3)).powi(3)
}

/// Weight of a neighbour in the second fit, by its residual in the first, 0 to 1: `(1 - u²)²`.
fn biweight(missed: f64) -> f64 {
    (1.0 - missed * missed).powi(2)
}

fn normalise(weights: &mut [f64]) {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 {
        weights.iter_mut().for_each(|w| *w /= sum);
    } else {
        weights.fill(1.0 / weights.len() as f64);
    }
}

/// Coefficients of both fits, per channel, and variance factors of their values at the queried point.
#[derive(Debug, Clone)]
pub struct Solution<const M: usize> {
    /// Coefficients of the linear fit; 0 beyond its terms.
    pub linear: [[f64; M]; 3],
    /// Coefficients of the quadratic fit.
    pub quadratic: [[f64; M]; 3],
    /// Variance factors of the linear and the quadratic value.
    pub variance: [f64; 2],
}

/// Number of right-hand sides: one per channel, and the unit vector of the constant term.
const RIGHT: usize = 4;

/// Solves `(BᵀWB + ridge) a = BᵀW e` for the quadratic basis of `M` terms and for its linear part, by elimination
/// without pivoting: the matrix is symmetric and positive, and the linear system is its leading block.
pub fn solve<const D: usize, const M: usize>(
    basis: &[[f64; M]],
    weights: &[f64],
    residuals: &[[f64; 3]],
) -> Solution<M> {
    let mut matrix = [[0.0; M]; M];
    let mut right = [[0.0; RIGHT]; M];
    for ((row, weight), residual) in basis.iter().zip(weights).zip(residuals) {
        for a in 0..M {
            let weighted = weight * row[a];
            for b in 0..M {
                matrix[a][b] += weighted * row[b];
            }
            for channel in 0..3 {
                right[a][channel] += weighted * residual[channel];
            }
        }
    }
    right[0][3] = 1.0;
    for term in 0..M {
        matrix[term][term] += RIDGE[if term == 0 { 0 } else { 1 + usize::from(term > D) }];
    }
    for j in 0..M {
        // The ridge keeps pivots positive except for rounding.
        matrix[j][j] = matrix[j][j].max(1e-12);
        let (pivot, pivot_right) = (matrix[j], right[j]);
        for i in j + 1..M {
            let factor = matrix[i][j] / pivot[j];
            for k in 0..M {
                matrix[i][k] -= factor * pivot[k];
            }
            for k in 0..RIGHT {
                right[i][k] -= factor * pivot_right[k];
            }
        }
    }
    let mut solution = Solution { linear: [[0.0; M]; 3], quadratic: [[0.0; M]; 3], variance: [0.0; 2] };
    substitute_back(&matrix, &right, D + 1, &mut solution.linear);
    substitute_back(&matrix, &right, M, &mut solution.quadratic);
    // With L D Lᵀ = A and y = L⁻¹ e₀, the corner of the inverse is yᵀ D⁻¹ y.
    let corner = |count: usize| (0..count).map(|j| right[j][3] * right[j][3] / matrix[j][j]).sum();
    solution.variance = [corner(D + 1), corner(M)];
    solution
}

/// Back substitution with the leading `m` x `m` block of the eliminated matrix.
fn substitute_back<const M: usize>(
    matrix: &[[f64; M]; M],
    right: &[[f64; RIGHT]; M],
    m: usize,
    solution: &mut [[f64; M]; 3],
) {
    for i in (0..m).rev() {
        for channel in 0..3 {
            let mut value = right[i][channel];
            for k in i + 1..m {
                value -= matrix[i][k] * solution[channel][k];
            }
            solution[channel][i] = value / matrix[i][i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that determine a quadratic in 3 dimensions well.
    fn spread() -> Vec<[f64; 3]> {
        let mut points = Vec::new();
        for a in 0..3 {
            for sign in [-0.6, 0.6] {
                let mut p = [0.05 * sign; 3];
                p[a] = sign;
                points.push(p);
            }
        }
        points.extend([[0.4, 0.4, 0.0], [0.4, 0.0, 0.4], [0.0, 0.4, 0.4]]);
        points.extend([[-0.4, -0.4, 0.1], [-0.4, 0.1, -0.4], [0.1, -0.4, -0.4]]);
        points.extend([[0.1, 0.0, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.1]]);
        points
    }

    fn fitted(value: impl Fn([f64; 3]) -> f64) -> (f64, Tally) {
        let mut neighbourhood = Neighbourhood::<3>::default();
        for p in spread() {
            let distance = p.iter().map(|c| c * c).sum::<f64>().sqrt();
            neighbourhood.push(p, distance, [value(p); 3]);
        }
        let mut tally = Tally::default();
        (neighbourhood.fit::<TERMS_3D>(1, &mut tally)[0], tally)
    }

    #[test]
    fn constants_and_planes_are_exact() {
        let (value, tally) = fitted(|_| 2.5);
        assert!((value - 2.5).abs() < 1e-9);
        assert_eq!(tally, Tally::default());
        let (value, _) = fitted(|p| 1.0 + 2.0 * p[0] - p[1] + 0.5 * p[2]);
        assert!((value - 1.0).abs() < 1e-4, "{value}");
    }

    #[test]
    fn a_bowl_is_followed_better_than_by_a_mean() {
        let bowl = |p: [f64; 3]| p.iter().map(|c| c * c).sum::<f64>();
        let (value, _) = fitted(bowl);
        let mean = spread().into_iter().map(bowl).sum::<f64>() / 15.0;
        assert!(value < 0.7 * mean, "{value} against {mean}");
    }

    #[test]
    fn values_stay_near_the_neighbours() {
        let (value, tally) = fitted(|p| if p[0] > 0.5 { 30.0 } else { 0.0 });
        assert!((-3.0..=30.0).contains(&value), "{value}");
        assert!(tally.clamped_to_neighbours <= 1);
    }

    #[test]
    fn degenerate_neighbourhoods_fall_back_and_are_counted() {
        let mut tally = Tally::default();
        let mut line = Neighbourhood::<3>::default();
        for k in 0..12 {
            let x = 0.7 + 0.02 * f64::from(k);
            line.push([x, 0.0, 0.0], x, [f64::from(k); 3]);
        }
        let value = line.fit::<TERMS_3D>(3, &mut tally);
        assert!(value.iter().all(|v| v.is_finite()) && tally.fell_to_constant + tally.fell_to_linear == 1, "{tally:?}");
        let mut same = Neighbourhood::<3>::default();
        for k in 0..12 {
            same.push([0.0; 3], 0.0, [f64::from(k % 2); 3]);
        }
        assert!((same.fit::<TERMS_3D>(3, &mut tally)[0] - 0.5).abs() < 1e-6);
    }
}
