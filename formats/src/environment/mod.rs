//! Prefiltered environments: cube maps whose mipmap levels have kernels of increasing width, and the
//! irradiance. Layout: `spec.md` in this folder.

pub mod cube;
mod decode;
pub(crate) mod descriptor;
mod header;
mod pack;

pub use decode::EnvironmentDecoder;
pub use header::{ENVIRONMENT_ENTRY, EnvironmentHeader, IRRADIANCE_SIDE, MAX_SIDE, MIN_SIDE};
pub use pack::{ENVIRONMENT_WGSL, EnvironmentPack};
