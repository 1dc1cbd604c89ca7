//! Reference renderer: scenes, ray casting and adaptive shading on the CPU, which GPU renderings are compared with.

pub mod adaptive;
pub mod camera;
pub mod contact_sheet;
pub mod curvature;
pub mod environment;
pub mod environment_light;
pub mod environment_sampler;
pub mod flat;
mod footprint;
pub mod gbuffer;
pub mod lobe_sampler;
pub mod lobes;
pub mod mipmaps;
pub mod pwt;
pub mod rendering;
mod sample_means;
pub mod scene;
pub mod scenes;
pub mod shade;
pub mod shading_point;
#[cfg(test)]
mod testing;
pub mod trace;
mod vector;
pub mod within;
