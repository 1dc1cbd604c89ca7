//! Equation 2 of Bagher et al. 2012: reflected radiance at a pixel by importance samples.

use super::{AdaptiveScene, resolve};
use crate::gbuffer::GBuffer;
use crate::scene::Frame;
use brdfc_formats::direction::{DirectionPair, Vector};
use brdfc_metrics::image::LinearImage;
use rayon::prelude::*;

/// Reflected radiance at a point of the buffer, given its index and a number of samples.
pub type PointShader<'a> = dyn Fn(usize, u32) -> [f32; 3] + Sync + 'a;

/// Reflected radiance at a point of the buffer by `count` consecutive samples of its material's pack, from a position
/// in the sequence that depends on the point.
pub fn shade_point(scene: &AdaptiveScene<'_>, buffer: &GBuffer, pixel: usize, count: u32) -> [f32; 3] {
    let light = |direction: [f32; 3], _| scene.scene.environment.at(direction.map(f64::from));
    by_samples(scene, buffer, pixel, count, scattered(pixel as u32), light)
}

/// The same from position `first`, with the light from a direction of the world that a sample looks up, given its inverse
/// density, sr.
pub(super) fn by_samples(
    scene: &AdaptiveScene<'_>,
    buffer: &GBuffer,
    pixel: usize,
    count: u32,
    first: u32,
    light: impl Fn([f32; 3], f32) -> Vector,
) -> [f32; 3] {
    let Some(part) = buffer.part_at(pixel) else { return [0.0; 3] };
    let material = &scene.materials[part];
    let frame = buffer.frame(pixel);
    let outgoing = frame.local(buffer.to_viewer[pixel]);
    let mut sum = [0.0f32; 3];
    for index in 0..count {
        let (incoming, inverse_density) = material.samples.sample(outgoing, first.wrapping_add(index));
        if inverse_density <= 0.0 {
            continue;
        }
        let pair = DirectionPair::new(incoming.map(f64::from), outgoing.map(f64::from));
        let f_r = material.reflectance.eval(pair, f64::from(buffer.distance[pixel]));
        let light = light(frame.world(incoming), inverse_density);
        let weight = incoming[2] * inverse_density;
        (0..3).for_each(|k| sum[k] += weight * (f_r[k] * light[k]) as f32);
    }
    scene.texture_at(buffer, pixel).tinted(sum.map(|s| s / count.max(1) as f32))
}

/// Renders forward: shades every point of the buffer with the same number of samples.
pub fn forward(scene: &AdaptiveScene<'_>, frame: Frame, buffer: &GBuffer, count: u32) -> LinearImage {
    let radiance: Vec<[f32; 3]> =
        (0..buffer.part.len()).into_par_iter().map(|pixel| shade_point(scene, buffer, pixel, count)).collect();
    resolve(scene.scene, frame, buffer, &radiance, buffer.width / frame.width)
}

/// Scatters consecutive numbers: a permutation of 32 bits (the finaliser of MurmurHash3 by Appleby).
pub(super) fn scattered(value: u32) -> u32 {
    let mut h = value;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}
