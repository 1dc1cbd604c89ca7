//! Materials as files that other programs read: `brdfc convert`.

pub use brdfc_jobs::convert::{ConvertError, Converted, PairGrid, Target, convert};
pub use brdfc_readers::merl::Dimensions;
