//! Merges rows that measured the same direction pair.

use super::coordinates::Identity;

/// Positions that round to the same multiple of this are in the order of their rows.
const SAME: f64 = 1e-6;

/// Rows of one direction pair.
pub struct Group {
    /// Index of the first of the rows.
    pub representative: usize,
    sum: [f64; 3],
    lowest: [f64; 3],
    highest: [f64; 3],
    count: f64,
}

impl Group {
    /// Mean value of the rows.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s / self.count)
    }

    /// Returns true if there are several rows.
    pub fn repeats(&self) -> bool {
        self.count > 1.0
    }

    /// Largest values of the rows, summed over channels.
    pub fn highest(&self) -> f64 {
        self.highest.iter().sum()
    }

    /// Difference to the smallest values, summed over channels.
    pub fn spread(&self) -> f64 {
        self.highest() - self.lowest.iter().sum::<f64>()
    }

    /// Largest difference within the group, as a fraction of the larger value.
    pub fn disagreement(&self) -> f64 {
        (0..3)
            .map(|c| if self.highest[c] > 0.0 { 1.0 - self.lowest[c] / self.highest[c] } else { 0.0 })
            .fold(0.0, f64::max)
    }
}

/// Groups rows of equal identity, in the order of their positions.
pub fn merge<const D: usize>(identities: &[Identity], positions: &[[f64; D]], values: &[[f64; 3]]) -> Vec<Group> {
    let mut order: Vec<usize> = (0..identities.len()).collect();
    order.sort_by_key(|row| (identities[*row], *row));
    let mut groups: Vec<Group> = Vec::new();
    for row in order {
        let value = values[row];
        match groups.last_mut() {
            Some(group) if identities[group.representative] == identities[row] => {
                group.count += 1.0;
                for channel in 0..3 {
                    group.sum[channel] += value[channel];
                    group.lowest[channel] = group.lowest[channel].min(value[channel]);
                    group.highest[channel] = group.highest[channel].max(value[channel]);
                }
            }
            _ => groups.push(Group { representative: row, sum: value, lowest: value, highest: value, count: 1.0 }),
        }
    }
    groups.sort_by_key(|group| {
        let place = positions[group.representative].map(|c| (c / SAME).round() as i64);
        (place, group.representative)
    });
    groups
}
