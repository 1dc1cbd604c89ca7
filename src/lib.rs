//! `brdfc`: an offline compiler for measured appearance. See the README for what it does.
//!
//! Layers, each using only those before it: formats (a crate of its own), `source`, the stages `brdf`, `btf`, `bandwidth`
//! and `metrics`, `render`, `report` and `build`, `cli`.

pub mod bandwidth;
pub mod brdf;
pub mod btf;
pub mod build;
pub mod cli;
pub mod metrics;
#[cfg(feature = "render")]
pub mod render;
pub mod report;
pub mod source;

/// Compiles the Rust example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
