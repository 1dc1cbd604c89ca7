//! Readers of measured data: bytes to typed and checked structs, one file per layout.

pub mod rgl;
pub mod tensor;
