//! Base of all BRDF encoders: user options, recipes (everything that decides the bytes of a pack), encodings with their
//! measured errors, reports and errors. `brdfc_encode` lists the codecs.

mod averaged;
mod budget;
mod encoded;
mod error;
mod fit_limits;
mod grid_cache;
mod message;
mod options;
mod recipe;
mod trial;
mod words;

pub use averaged::AveragingCost;
pub use budget::{Budget, HIGHLIGHT, OptionError, TAIL};
pub use encoded::{BrdfReport, Encoded};
pub use error::EncodeError;
pub use fit_limits::{ErrorLimits, FitLimits};
pub use grid_cache::GridCache;
pub use message::Message;
pub use options::{EncodeOptions, Variant, range_of};
pub use recipe::{BrdfRecipe, Encode, Predicted};
pub use trial::Trial;
pub use words::format_errors;
