//! Thresholding (section 4.3 of Claustres et al. 2007): whole slices of weak coefficients are dropped.

use super::haar::flip_coefficient;
use super::table::Table;

/// Squared norm of each coefficient over all outer cells and channels: `E_k = Σ c_k²`.
///
/// Computed from the stored rows: the rows that a flip maps onto a stored row hold the same coefficients in another
/// order, so images of a coefficient have the same energy, to the bit.
pub fn slice_energies(coefficients: &Table) -> Vec<f64> {
    let (channels, rows, cells) = coefficients.values.dim();
    let mut stored = vec![0.0f64; cells];
    for channel in 0..channels {
        for row in 0..rows {
            for (energy, c) in stored.iter_mut().zip(coefficients.row(channel, row)) {
                *energy += f64::from(*c) * f64::from(*c);
            }
        }
    }
    (0..cells)
        .map(|k| {
            let mut parts: Vec<f64> =
                coefficients.fold.flips().iter().map(|flip| stored[flip_coefficient(k, *flip).0]).collect();
            parts.sort_by(f64::total_cmp);
            parts.iter().sum()
        })
        .collect()
}

/// Coefficients in order of retention: the scaling coefficient, then by falling energy, ties by number.
///
/// Only the `4^stored_levels` coefficients of levels below `stored_levels` take part.
pub fn ranking(energies: &[f64], stored_levels: u32) -> Vec<u32> {
    let count = energies.len().min(1 << (2 * stored_levels));
    let mut ranked: Vec<u32> = (1..count as u32).collect();
    ranked.sort_by(|a, b| energies[*b as usize].total_cmp(&energies[*a as usize]).then(a.cmp(b)));
    ranked.insert(0, 0);
    ranked
}

/// The first `count` coefficients of a ranking, in ascending order: the slices of a pack.
pub fn keep(ranking: &[u32], count: usize) -> Vec<u32> {
    let mut slices = ranking[..count.clamp(1, ranking.len())].to_vec();
    slices.sort_unstable();
    slices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_first_then_by_energy_then_by_number() {
        let energies = [0.0, 5.0, 7.0, 5.0, 9.0, 1.0];
        assert_eq!(ranking(&energies, 6), [0, 4, 2, 1, 3, 5]);
        assert_eq!(ranking(&energies, 1), [0, 2, 1, 3], "level 1 and finer are not stored");
        assert_eq!(keep(&ranking(&energies, 6), 3), [0, 2, 4]);
        assert_eq!(keep(&ranking(&energies, 6), 0), [0]);
    }
}
