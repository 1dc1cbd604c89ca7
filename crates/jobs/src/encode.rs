//! How a pack of a BRDF is asked for and made.

pub use brdfc_codec::{Budget, EncodeOptions, ErrorLimits, FitLimits, OptionError, range_of};
pub use brdfc_encode::*;
