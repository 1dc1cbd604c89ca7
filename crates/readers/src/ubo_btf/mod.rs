//! BTFs of the database of Bonn University of 2014: decorrelated colours, each channel a product of two matrices.
//!
//! Layout: `crates/readers/src/ubo_btf.md`.

mod btf;
mod colour;
mod matrix;
mod read;

use crate::file_kind::{Begins, FileKind};
pub use btf::{CHANNELS, Description, MAX_SIZE, SIGNATURE, UboBtf, VERSIONS};
pub use colour::ColourModel;
pub use matrix::{Channel, Matrix, Scalar};
pub use read::ReadError;

/// BTFs of the Bonn database of 2014.
pub static KIND: FileKind = FileKind {
    description: "a BTF of the Bonn database of 2014 (.btf), for 'brdfc flatten'",
    extensions: &["btf"],
    begins: Begins::With(&[SIGNATURE]),
};
