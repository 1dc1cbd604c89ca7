//! Merges rows that measured the same direction pair.

/// Positions closer than this, per coordinate, are repeated measurements of one direction pair.
const SAME_POSITION: f64 = 1e-6;

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

/// Groups rows of (almost) equal position, in the order of positions.
pub fn merge<const D: usize>(positions: &[[f64; D]], values: &[[f64; 3]]) -> Vec<Group> {
    let key = |row: usize| positions[row].map(|c| (c / SAME_POSITION).round() as i64);
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by_key(|row| (key(*row), *row));
    let mut groups: Vec<Group> = Vec::new();
    for row in order {
        let value = values[row];
        match groups.last_mut() {
            Some(group) if key(group.representative) == key(row) => {
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
    groups
}
