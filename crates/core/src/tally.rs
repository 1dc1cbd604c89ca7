//! Counts of what an evaluation had to repair, so that nothing is repaired in silence.

use std::ops::AddAssign;

/// How often an evaluation could not follow the plain path. All zero for analytic models.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Tally {
    /// Direction pairs evaluated.
    pub evaluations: u64,
    /// Interpolations of which some, but not all, cells were invalid: their weights were renormalised.
    pub partly_invalid: u64,
    /// Interpolations of which every cell was invalid: the nearest valid cell stood in.
    pub nearest_valid: u64,
    /// Local fits that fell from quadratic to linear degree.
    pub fell_to_linear: u64,
    /// Local fits that fell to a constant (a weighted mean).
    pub fell_to_constant: u64,
    /// Local fits whose value was clamped to the range of its neighbours.
    pub clamped_to_neighbours: u64,
    /// Values that were negative (measurement noise, colours out of gamut) or no number, and were raised to zero.
    pub negative_raised: u64,
    /// Values that were larger than a pack may hold, and were lowered to the largest.
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
