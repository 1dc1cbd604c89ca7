//! Parsers of the values of flags.

pub use brdfc_core::byte_count::bytes_from_text;
pub use brdfc_core::whole_number::{any_whole_number, whole_number};
