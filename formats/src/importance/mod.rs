//! Importance samples of a BRDF for every outgoing direction. Layout: `spec.md` in this folder.

pub(crate) mod descriptor;
mod pack;

pub use pack::*;
