//! Shaders of adaptive shading, assembled from their files.

use super::super::pack::brdf_source;
use super::super::raster::view_wgsl;
use super::super::surface::{ENVIRONMENT_WGSL, PERIODIC_WGSL, SURFACE_WGSL};
use brdfc_formats::bandwidth::propagation::PROPAGATION_WGSL;
use brdfc_formats::bandwidth::shader::BANDWIDTH_WGSL;
use brdfc_formats::importance::IMPORTANCE_WGSL;

/// Sources that [`super::AdaptiveRenderer`] compiles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AdaptiveShaders {
    /// Rasterises the G-buffer: vertex entry point `project`, fragment entry points `place` and `turn`.
    pub g_buffer: String,
    /// All later steps, each a compute entry point.
    pub steps: String,
}

const STEPS: [&str; 11] = [
    include_str!("points.wgsl"),
    include_str!("material.wgsl"),
    include_str!("read_back.wgsl"),
    include_str!("curvature.wgsl"),
    include_str!("texture.wgsl"),
    include_str!("predict.wgsl"),
    include_str!("rates.wgsl"),
    include_str!("pyramid.wgsl"),
    include_str!("upsample.wgsl"),
    include_str!("passes.wgsl"),
    include_str!("shade.wgsl"),
];
const RESOLVE: &str = include_str!("resolve.wgsl");
const G_BUFFER: &str = include_str!("g_buffer.wgsl");

impl Default for AdaptiveShaders {
    fn default() -> Self {
        // Packs are not bound here, so surfaces are group 1.
        let surface = SURFACE_WGSL.replace("@group(2)", "@group(1)");
        let shared = [
            brdf_source(),
            IMPORTANCE_WGSL.to_owned(),
            BANDWIDTH_WGSL.to_owned(),
            PROPAGATION_WGSL.to_owned(),
            PERIODIC_WGSL.to_owned(),
            ENVIRONMENT_WGSL.to_owned(),
        ];
        Self {
            g_buffer: [&view_wgsl(), PERIODIC_WGSL, &surface, G_BUFFER].join("\n"),
            steps: [shared.join("\n"), STEPS.join("\n"), RESOLVE.to_owned()].join("\n"),
        }
    }
}
