//! Importance samples of a BRDF for every outgoing direction. Layout: `spec.md` in this folder.

mod pack;

pub use pack::*;
