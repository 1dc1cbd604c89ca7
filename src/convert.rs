//! Conversion of materials to file formats of other programs: `brdfc convert`.
//!
//! Start with [`convert()`], which resamples the source of a [`Material`](crate::Material) into the format of a
//! [`Target`].

pub use brdfc_jobs::convert::{ConvertError, Converted, PairGrid, Target, convert};
pub use brdfc_readers::merl::Dimensions;
