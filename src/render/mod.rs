//! The verifier: draws packs with the shaders that engines use, beside a CPU reference, on any Vulkan driver.

pub mod gpu;
pub mod scene;
