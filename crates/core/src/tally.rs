//! Counts of repairs during evaluation.

use std::ops::AddAssign;

/// Counts of evaluations and repairs. All repairs are zero for analytic models.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Tally {
    /// Number of evaluated direction pairs.
    pub evaluations: u64,
    /// Interpolations with some, but not all, cells invalid: their weights were renormalised.
    pub partly_invalid: u64,
    /// Interpolations with all cells invalid: the nearest valid cell was used.
    pub nearest_valid: u64,
    /// Local fits whose degree was reduced from quadratic to linear.
    pub fell_to_linear: u64,
    /// Local fits whose degree was reduced to a constant (a weighted mean).
    pub fell_to_constant: u64,
    /// Local fits whose value was clamped to the range of its neighbours.
    pub clamped_to_neighbours: u64,
    /// Values that were negative (measurement noise, colours out of gamut) or NaN, and were raised to zero.
    pub negative_raised: u64,
    /// Values that exceeded the maximum of a pack, and were lowered to it.
    pub largest_lowered: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.evaluations += other.evaluations;
        self.partly_invalid += other.partly_invalid;
        self.nearest_valid += other.nearest_valid;
        self.fell_to_linear += other.fell_to_linear;
        self.fell_to_constant += other.fell_to_constant;
        self.clamped_to_neighbours += other.clamped_to_neighbours;
        self.negative_raised += other.negative_raised;
        self.largest_lowered += other.largest_lowered;
    }
}
