//! Encoder of table packs: logarithms of `f_r` over half-difference angles, with nodes placed for the material and
//! values fitted with perceptual weights. [`search`] finds the smallest table that meets a budget. `formats/src/table`
//! has the layout, the decoder and the shader.

pub mod choose;
mod codec;
pub mod crop;
pub mod curve;
pub mod encode;
mod facts;
pub mod fit;
pub mod lattice;
pub mod levels;
pub mod quantise;
pub mod recipe;
mod report;
pub mod samples;
pub mod search;
pub mod symmetry;
pub mod targets;

pub use codec::Recipe;
pub use facts::TablePackFacts;
pub use report::TableReport;
