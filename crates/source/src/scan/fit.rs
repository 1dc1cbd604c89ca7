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

/// Neighbours of one queried point, for a quadratic of `M` terms in `D` dimensions.
#[derive(Debug, Clone)]
pub struct Neighbourhood<const D: usize, const M: usize> {
    /// `1, p, p pᵀ` of every neighbour.
    basis: Vec<[f64; M]>,
    weights: Vec<f64>,
    values: Vec<[f64; 3]>,
}

/// Fit at a queried point.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Log values.
    pub value: [f64; 3],
    /// Share of each neighbour's value in the fit, if it was asked for; their sum is 1 up to the regularisation.
    pub shares: Vec<f64>,
}

impl<const D: usize, const M: usize> Neighbourhood<D, M> {
    /// An empty neighbourhood with memory for `count` neighbours.
    pub fn with_capacity(count: usize) -> Self {
        Self { basis: Vec::with_capacity(count), weights: Vec::with_capacity(count), values: Vec::with_capacity(count) }
    }

    /// Adds a neighbour: its offset and distance in units of the support radius (a reciprocal row is farther than its
    /// offset), and log values.
    pub fn push(&mut self, offset: [f64; D], distance: f64, value: [f64; 3]) {
        self.basis.push(terms(offset));
        self.weights.push(weight(distance.min(1.0)));
        self.values.push(value);
    }

    /// Fitted log values at the queried point for the first `channels` channels, limited to the range of the neighbours
    /// with a margin: a quadratic of `M` terms and a linear fit in equal shares, as far as they are trusted. Needs at
    /// least one neighbour.
    pub fn fit(&self, channels: usize, tally: &mut Tally) -> [f64; 3] {
        self.fit_with_shares(channels, false, tally).value
    }

    /// Same as [`Self::fit`], with the shares of the neighbours if `with_shares` is true.
    pub fn fit_with_shares(&self, channels: usize, with_shares: bool, tally: &mut Tally) -> Fitted {
        let mut weights = self.weights.clone();
        normalise(&mut weights);
        let mut mean = [0.0; 3];
        for (weight, value) in weights.iter().zip(&self.values) {
            for channel in 0..channels {
                mean[channel] += weight * value[channel];
            }
        }
        let mut residuals = vec![[0.0; 3]; self.values.len()];
        for (residual, value) in residuals.iter_mut().zip(&self.values) {
            for channel in 0..channels {
                residual[channel] = value[channel] - mean[channel];
            }
        }
        let plain = if with_shares { weights.clone() } else { Vec::new() };
        let first = solve::<D, M>(&self.basis, &weights, &residuals);
        self.reweigh(&first, &residuals, channels, &mut weights);
        let second = solve::<D, M>(&self.basis, &weights, &residuals);

        let trust = second.variance.map(|v| ((TRUST[1] / v).ln() / (TRUST[1] / TRUST[0]).ln()).clamp(0.0, 1.0));
        tally.fell_to_constant += u64::from(trust[0] == 0.0 && trust[1] == 0.0);
        tally.fell_to_linear += u64::from(trust[0] > 0.0 && trust[1] == 0.0);
        let mut value = mean;
        let mut clamped = false;
        for channel in 0..channels {
            let linear = trust[0] * second.linear[channel][0];
            let blend = linear + QUADRATIC_SHARE * trust[1] * (second.quadratic[channel][0] - linear);
            let fitted = mean[channel] + blend;
            let (low, high) = self.range(channel);
            value[channel] = fitted.clamp(low - MARGIN_BELOW * (high - low), high);
            clamped |= value[channel] != fitted;
        }
        tally.clamped_to_neighbours += u64::from(clamped);
        let quadratic = QUADRATIC_SHARE * trust[1];
        let parts = [(1.0 - quadratic) * trust[0], quadratic];
        Fitted { value, shares: self.shares(&plain, &weights, &second, parts) }
    }

    /// Shares of the values in a fit of a linear and a quadratic part, and the mean by the weights `plain`. Shares of the
    /// parts are those of residuals from that mean.
    fn shares(&self, plain: &[f64], weights: &[f64], fit: &Solution<M>, [linear, quadratic]: [f64; 2]) -> Vec<f64> {
        let share = |((plain, weight), row): ((&f64, &f64), &[f64; M])| {
            let product = |dual: &[f64; M]| row.iter().zip(dual).map(|(a, b)| a * b).sum::<f64>();
            let [of_linear, of_quadratic] = [&fit.linear[UNIT], &fit.quadratic[UNIT]].map(product);
            plain * (1.0 - linear - quadratic) + weight * (linear * of_linear + quadratic * of_quadratic)
        };
        plain.iter().zip(weights).zip(&self.basis).map(share).collect()
    }

    /// Smallest and largest log value of the neighbours.
    pub fn range(&self, channel: usize) -> (f64, f64) {
        let values = self.values.iter().map(|v| v[channel]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    /// Biweights from the residuals of the mean of both fits, over all channels together.
    fn reweigh(&self, fit: &Solution<M>, residuals: &[[f64; 3]], channels: usize, weights: &mut [f64]) {
        let missed = |(row, residual): (&[f64; M], &[f64; 3])| {
            let mut square = 0.0;
            for channel in 0..channels {
                let linear: f64 = (0..=D).map(|t| row[t] * fit.linear[channel][t]).sum();
                let quadratic: f64 = (0..M).map(|t| row[t] * fit.quadratic[channel][t]).sum();
                square += (residual[channel] - 0.5 * (linear + quadratic)).powi(2);
            }
            (square / channels as f64).sqrt()
        };
        let missed: Vec<f64> = self.basis.iter().zip(residuals).map(missed).collect();
        let mut sorted = missed.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len();
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        for (weight, missed) in weights.iter_mut().zip(missed) {
            *weight *= biweight((missed / (OUTLIER * median + 1e-3)).min(1.0)) + 1e-4;
        }
        normalise(weights);
    }
}

/// `1, p, p pᵀ` of an offset.
fn terms<const D: usize, const M: usize>(p: [f64; D]) -> [f64; M] {
    let mut row = [0.0; M];
    row[0] = 1.0;
    row[1..=D].copy_from_slice(&p);
    let mut term = D + 1;
    for a in 0..D {
        for b in a..D {
            row[term] = p[a] * p[b];
            term += 1;
        }
    }
    row
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

/// Coefficients of both fits, per right-hand side, and variance factors of their values at the queried point.
#[derive(Debug, Clone)]
pub struct Solution<const M: usize> {
    /// Coefficients of the linear fit; 0 beyond its terms.
    pub linear: [[f64; M]; RIGHT],
    /// Coefficients of the quadratic fit.
    pub quadratic: [[f64; M]; RIGHT],
    /// Variance factors of the linear and the quadratic value.
    pub variance: [f64; 2],
}

/// Number of right-hand sides: one per channel, and the unit vector of the constant term.
const RIGHT: usize = 4;
/// Index of the unit vector among them: its solution is the first column of the inverse.
const UNIT: usize = 3;

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
    right[0][UNIT] = 1.0;
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
    let mut solution = Solution { linear: [[0.0; M]; RIGHT], quadratic: [[0.0; M]; RIGHT], variance: [0.0; 2] };
    substitute_back(&matrix, &right, D + 1, &mut solution.linear);
    substitute_back(&matrix, &right, M, &mut solution.quadratic);
    // With L D Lᵀ = A and y = L⁻¹ e₀, the corner of the inverse is yᵀ D⁻¹ y.
    let corner = |count: usize| (0..count).map(|j| right[j][UNIT] * right[j][UNIT] / matrix[j][j]).sum();
    solution.variance = [corner(D + 1), corner(M)];
    solution
}

/// Back substitution with the leading `m` x `m` block of the eliminated matrix.
fn substitute_back<const M: usize>(
    matrix: &[[f64; M]; M],
    right: &[[f64; RIGHT]; M],
    m: usize,
    solution: &mut [[f64; M]; RIGHT],
) {
    for i in (0..m).rev() {
        for side in 0..RIGHT {
            let mut value = right[i][side];
            for k in i + 1..m {
                value -= matrix[i][k] * solution[side][k];
            }
            solution[side][i] = value / matrix[i][i];
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
        let mut neighbourhood = Neighbourhood::<3, TERMS_3D>::with_capacity(15);
        for p in spread() {
            let distance = p.iter().map(|c| c * c).sum::<f64>().sqrt();
            neighbourhood.push(p, distance, [value(p); 3]);
        }
        let mut tally = Tally::default();
        (neighbourhood.fit(1, &mut tally)[0], tally)
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
        let mut line = Neighbourhood::<3, TERMS_3D>::with_capacity(15);
        for k in 0..12 {
            let x = 0.7 + 0.02 * f64::from(k);
            line.push([x, 0.0, 0.0], x, [f64::from(k); 3]);
        }
        let value = line.fit(3, &mut tally);
        assert!(value.iter().all(|v| v.is_finite()) && tally.fell_to_constant + tally.fell_to_linear == 1, "{tally:?}");
        let mut same = Neighbourhood::<3, TERMS_3D>::with_capacity(15);
        for k in 0..12 {
            same.push([0.0; 3], 0.0, [f64::from(k % 2); 3]);
        }
        assert!((same.fit(3, &mut tally)[0] - 0.5).abs() < 1e-6);
    }
}
