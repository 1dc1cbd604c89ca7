//! What every encoder of BRDFs has, whichever its codec: options that users ask by, a recipe that says everything that decides the
//! bytes of a pack, an encoding with its measured errors, a report, one error. `brdfc_encode` lists the codecs.

mod averaged;
mod budget;
mod encoded;
mod error;
mod fit_limits;
mod grid_cache;
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
pub use options::{EncodeOptions, Variant, range_of};
pub use recipe::{BrdfRecipe, Encode, Predicted};
pub use trial::Trial;
pub use words::errors_in_words;
