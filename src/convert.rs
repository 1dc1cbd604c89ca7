//! Conversion of materials to file formats of other programs: `brdfc convert`.

pub use brdfc_jobs::convert::{ConvertError, Converted, PairGrid, Target, convert};
pub use brdfc_readers::merl::Dimensions;
