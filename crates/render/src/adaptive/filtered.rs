//! Filtered importance sampling: samples of the material that look up prefiltered light ("Real-time shading with filtered
//! importance sampling", Colbert and Křivánek 2008).
//!
//! Each of `N` samples of density `p` represents a solid angle of `1 / (N p)`. Instead of the light from exactly its
//! direction it takes a mean over about that solid angle, which replaces noise by a slight blur.

use super::AdaptiveScene;
use super::shading::{by_samples, scattered};
use crate::gbuffer::GBuffer;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use std::f32::consts::TAU;

/// A prefiltered environment, and how samples look it up.
#[derive(Debug, Clone, Copy)]
pub struct FilteredLight<'a> {
    /// Levels of Gaussian kernels.
    pub environment: &'a EnvironmentDecoder,
    /// True if each point starts at a different position in the sequence of samples, which gives noise. Otherwise all
    /// points share the same samples, and errors vary as slowly as the rendering.
    pub scattered: bool,
}

impl FilteredLight<'_> {
    /// Sharpness of the look-up of a sample of a solid angle, sr: 1 or more.
    pub fn sharpness(&self, solid_angle: f32) -> f32 {
        // A Gaussian of variance σ² has the peak of a uniform disc of 2 π σ².
        EnvironmentHeader::sharpness(f64::from(solid_angle / TAU).sqrt()) as f32
    }
}

/// Reflected radiance at a point of the buffer by `count` samples of its material's pack in prefiltered light.
pub fn shade_point_filtered(
    scene: &AdaptiveScene<'_>,
    light: &FilteredLight<'_>,
    buffer: &GBuffer,
    pixel: usize,
    count: u32,
) -> [f32; 3] {
    let first = if light.scattered { scattered(pixel as u32) } else { 0 };
    by_samples(scene, buffer, pixel, count, first, |direction, inverse_density| {
        let sharpness = light.sharpness(inverse_density / count as f32);
        light.environment.radiance(direction, sharpness).map(f64::from)
    })
}
