//! Reports about finished work: JSON with a schema, and tables.

#[cfg(feature = "render")]
pub mod adaptive;
pub mod build;
#[cfg(feature = "render")]
pub mod contact;
pub mod fit;
pub mod gate;
pub mod list;
pub mod material;
pub mod page;
#[cfg(feature = "render")]
pub mod render;
