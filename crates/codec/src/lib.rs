//! What every encoder of BRDFs has, whichever its codec: a recipe that says everything that decides the bytes of a pack, an
//! encoding with its measured errors, a report, one error. `brdfc_encode` lists the codecs.

mod averaged;
mod encoded;
mod error;
mod grid_cache;
mod recipe;
mod trial;
mod words;

pub use averaged::AveragingCost;
pub use encoded::{BrdfReport, Encoded};
pub use error::EncodeError;
pub use grid_cache::GridCache;
pub use recipe::{BrdfRecipe, Encode, Predicted};
pub use trial::Trial;
pub use words::errors_in_words;
