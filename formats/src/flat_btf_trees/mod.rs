//! Flat BTFs whose reflectance is polynomial wavelet trees, fitted to the flat views (Baril, Boubekeur, Gioia and Schlick
//! 2008, "Polynomial wavelet trees for bidirectional texture functions"). Byte layout: `spec.md` in this folder.
//!
//! Relief and file are those of [`crate::flat_btf`], the trees those of [`crate::pwt`].

pub(crate) mod descriptor;
pub mod shader;
mod trees;

pub use trees::FlatTrees;
pub(crate) use trees::{DECODER as TREES_DECODER, TREES_ENTRY};
