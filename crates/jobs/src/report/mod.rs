//! What is said about finished work: JSON with a schema, and tables for people.

#[cfg(feature = "render")]
pub mod adaptive;
pub mod build;
pub mod material;
#[cfg(feature = "render")]
pub mod render;
