//! How users ask for a pack: options of the command line and keys of a manifest, resolved to a recipe.

pub(crate) mod byte_count;
pub mod options;

pub use brdfc_encode::*;
pub use byte_count::bytes_from_text;
