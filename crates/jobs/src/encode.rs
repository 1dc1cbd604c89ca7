//! Options and encoders of BRDF packs.

pub use brdfc_codec::{Budget, EncodeOptions, ErrorLimits, FitLimits, Message, OptionError, range_of};
pub use brdfc_encode::*;
