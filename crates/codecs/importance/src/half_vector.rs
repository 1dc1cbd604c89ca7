//! Conversion of half vectors to incoming directions: reflection of the outgoing direction, and its Jacobian.

use brdfc_formats::direction::Vector;

/// Returns `2 (wo · h) h - wo`, where `projection` is `wo · h`.
pub fn reflected(outgoing: Vector, half: Vector, projection: f64) -> Vector {
    [0, 1, 2].map(|k| 2.0 * projection * half[k] - outgoing[k])
}

/// `dωi / dωh = 4 (wo · h)`: steradians of incoming directions per steradian of half vectors (Walter et al. 2007,
/// "Microfacet models for refraction through rough surfaces", eq. 14). A density of half vectors divided by it is a
/// density of incoming directions.
pub fn jacobian(projection: f64) -> f64 {
    4.0 * projection
}
