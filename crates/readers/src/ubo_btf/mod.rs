//! BTFs of the database of Bonn University of 2014: colours that were decorrelated, each channel a product of two matrices.
//!
//! Layout: `crates/readers/src/ubo_btf.md`.

mod btf;
mod colour;
mod matrix;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use btf::{CHANNELS, Description, MAX_SIZE, SIGNATURE, UboBtf, VERSIONS};
pub use colour::ColourModel;
pub use matrix::{Channel, Matrix, Scalar};
pub use read::ReadError;
