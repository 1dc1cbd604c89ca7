//! Least squares with coefficients of 0 or more, by an active set (Lawson and Hanson 1974, chapter 23).

/// Relative gradient below which a coefficient stays 0.
const OPTIMAL: f64 = 1e-9;
/// Relative size of a pivot below which a column depends on the others.
const DEPENDENT: f64 = 1e-9;

/// Minimises `x' G x - 2 b' x` for `x >= 0`, from the present `x`. `gram` is `G`, row by row, symmetric and positive
/// semidefinite.
pub fn minimise(gram: &[f64], right: &[f64], x: &mut [f64]) {
    let n = right.len();
    let own = |k: usize| gram[k * n + k];
    let mut passive: Vec<usize> = (0..n).filter(|k| x[*k] > 0.0 && own(*k) > 0.0).collect();
    (0..n).filter(|k| !passive.contains(k)).for_each(|k| x[k] = 0.0);
    // Each pass adds a coefficient or ends; the limit guards against cycles by rounding.
    for _ in 0..3 * n + 3 {
        settle(gram, right, x, &mut passive);
        let gradient = |k: usize| right[k] - (0..n).map(|j| gram[k * n + j] * x[j]).sum::<f64>();
        let free = (0..n).filter(|k| !passive.contains(k) && own(*k) > 0.0);
        // Relative to the length of the column, so that scales do not matter.
        let steepest = free.map(|k| (gradient(k) / own(k).sqrt(), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        let scale = right.iter().enumerate().map(|(k, b)| if own(k) > 0.0 { b.abs() / own(k).sqrt() } else { 0.0 });
        match steepest {
            Some((slope, k)) if slope > OPTIMAL * scale.fold(0.0, f64::max) => passive.push(k),
            _ => return,
        }
    }
}

/// Moves to the minimum over the passive coefficients; those that would become negative are removed on the way.
fn settle(gram: &[f64], right: &[f64], x: &mut [f64], passive: &mut Vec<usize>) {
    while !passive.is_empty() {
        let goals = solve(gram, right, passive);
        // Share of the way at which the first coefficient becomes 0.
        let share_of = |x: f64, goal: f64| if goal > 0.0 { 1.0 } else { x / (x - goal).max(f64::MIN_POSITIVE) };
        let shares: Vec<f64> = passive.iter().zip(&goals).map(|(k, goal)| share_of(x[*k], *goal)).collect();
        let share = shares.iter().copied().fold(1.0, f64::min);
        for (k, goal) in passive.iter().zip(&goals) {
            x[*k] += share * (goal - x[*k]);
        }
        let is_left = |at: usize| goals[at] > 0.0 || shares[at] > share;
        let (left, removed): (Vec<usize>, Vec<usize>) = (0..passive.len()).partition(|at| is_left(*at));
        removed.iter().for_each(|at| x[passive[*at]] = 0.0);
        *passive = left.into_iter().map(|at| passive[at]).collect();
        if removed.is_empty() {
            return;
        }
    }
}

/// Solves for some coefficients by a Cholesky factor; dependent columns get 0.
fn solve(gram: &[f64], right: &[f64], columns: &[usize]) -> Vec<f64> {
    let (n, m) = (right.len(), columns.len());
    let mut factor = vec![0.0; m * m];
    let mut y = vec![0.0; m];
    for i in 0..m {
        for j in 0..=i {
            let inner: f64 = (0..j).map(|k| factor[i * m + k] * factor[j * m + k]).sum();
            let rest = gram[columns[i] * n + columns[j]] - inner;
            factor[i * m + j] = if i > j {
                if factor[j * m + j] > 0.0 { rest / factor[j * m + j] } else { 0.0 }
            } else if rest > DEPENDENT * gram[columns[i] * n + columns[i]] {
                rest.sqrt()
            } else {
                0.0
            };
        }
        let inner: f64 = (0..i).map(|k| factor[i * m + k] * y[k]).sum();
        let pivot = factor[i * m + i];
        y[i] = if pivot > 0.0 { (right[columns[i]] - inner) / pivot } else { 0.0 };
    }
    for i in (0..m).rev() {
        let inner: f64 = (i + 1..m).map(|k| factor[k * m + i] * y[k]).sum();
        let pivot = factor[i * m + i];
        y[i] = if pivot > 0.0 { (y[i] - inner) / pivot } else { 0.0 };
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimum(gram: &[f64], right: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; right.len()];
        minimise(gram, right, &mut x);
        x
    }

    fn near(found: &[f64], expected: &[f64]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
    }

    #[test]
    fn minima_by_hand() {
        near(&minimum(&[2.0, 0.0, 0.0, 4.0], &[6.0, 2.0]), &[3.0, 0.5]);
        near(&minimum(&[2.0, 0.0, 0.0, 4.0], &[6.0, -2.0]), &[3.0, 0.0]);
        near(&minimum(&[1.0, 0.5, 0.5, 1.0], &[1.0, 1.0]), &[2.0 / 3.0, 2.0 / 3.0]);
        // The free minimum is (2, -1): the second becomes 0, and the first the minimum without it.
        near(&minimum(&[1.0, 0.5, 0.5, 1.0], &[1.5, 0.0]), &[1.5, 0.0]);
        // Equal columns share one coefficient; empty ones have none.
        near(&[minimum(&[1.0, 1.0, 1.0, 1.0], &[3.0, 3.0]).iter().sum()], &[3.0]);
        near(&minimum(&[0.0, 0.0, 0.0, 1.0], &[0.0, 2.0]), &[0.0, 2.0]);
    }

    /// The conditions of Karush, Kuhn and Tucker, for random systems and from any start.
    #[test]
    fn minima_are_optimal() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for case in 0..200 {
            let n = 1 + case % 9;
            let rows: Vec<Vec<f64>> = (0..n + 2).map(|_| (0..n).map(|_| random() + 0.3).collect()).collect();
            let target: Vec<f64> = rows.iter().map(|_| random()).collect();
            let gram: Vec<f64> = (0..n * n).map(|at| rows.iter().map(|row| row[at / n] * row[at % n]).sum()).collect();
            let right: Vec<f64> = (0..n).map(|k| rows.iter().zip(&target).map(|(row, t)| row[k] * t).sum()).collect();
            let mut x: Vec<f64> = (0..n).map(|_| random().max(0.0)).collect();
            minimise(&gram, &right, &mut x);
            for k in 0..n {
                let slope = right[k] - (0..n).map(|j| gram[k * n + j] * x[j]).sum::<f64>();
                assert!(x[k] >= 0.0 && slope < 1e-6 && (x[k] == 0.0 || slope.abs() < 1e-6), "{case}: {x:?} {slope}");
            }
        }
    }
}
