//! Averaging of points to pixels.

use crate::gbuffer::GBuffer;
use crate::scene::{Frame, Scene};
use brdfc_metrics::image::LinearImage;

/// Averages the points of each pixel.
pub fn resolve(scene: &Scene, frame: Frame, buffer: &GBuffer, radiance: &[[f32; 3]], sub: usize) -> LinearImage {
    let (mut pixels, mut coverage) = (Vec::new(), Vec::new());
    for pixel in 0..frame.width * frame.height {
        let (x, y) = (pixel % frame.width * sub, pixel / frame.width * sub);
        let (mut sum, mut covered) = ([0.0f32; 3], 0usize);
        for at in (0..sub * sub).map(|k| (y + k / sub) * buffer.width + x + k % sub) {
            if buffer.part_at(at).is_some() {
                covered += 1;
                (0..3).for_each(|k| sum[k] += radiance[at][k]);
            }
        }
        let share = (sub * sub) as f32;
        pixels.push(sum.map(|s| s / share));
        coverage.push(covered as f32 / share);
    }
    LinearImage { width: frame.width, height: frame.height, pixels, coverage, background: scene.background }
}
