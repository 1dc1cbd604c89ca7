//! Parsers of the values of flags.

pub use brdfc_jobs::encode::bytes_from_text;
pub use brdfc_jobs::whole_number::{any_whole_number, whole_number};
