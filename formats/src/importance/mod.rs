//! Importance samples of a BRDF for each outgoing direction. Layout: `spec.md` in this folder.

pub(crate) mod descriptor;
mod pack;

pub use pack::*;
