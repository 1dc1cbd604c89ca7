//! Small vector helpers that the formats crate does not have.

use brdfc_formats::direction::Vector;
pub(crate) use brdfc_formats::direction::{add_scaled, cross, subtract};

/// A vertex's values in double precision.
pub(crate) fn double(v: [f32; 3]) -> Vector {
    v.map(f64::from)
}
