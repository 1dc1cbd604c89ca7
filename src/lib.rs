//! `brdfc`: an offline compiler for measured appearance. See the README for what it does.
//!
//! Layers, each using only those before it: formats (a crate of its own), `source`, the stages `brdf` and `metrics`,
//! `build` and `report`, `cli`.

pub mod brdf;
pub mod metrics;
pub mod source;
