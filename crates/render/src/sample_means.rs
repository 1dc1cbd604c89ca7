//! Averaging of samples, shared by all CPU renderers.

use super::scene::{Frame, Scene};
use brdfc_formats::direction::Vector;
use brdfc_metrics::image::LinearImage;
use rayon::prelude::*;

/// An image of means over the samples of each pixel. `radiance` returns the linear RGB of sample `(pixel, sample)`, or
/// `None` if it shows no surface. Samples are added in order.
pub(super) fn sample_means(
    scene: &Scene,
    frame: Frame,
    radiance: impl Fn(usize, usize) -> Option<Vector> + Sync,
) -> LinearImage {
    let samples = frame.samples_per_pixel();
    let pixel = |pixel: usize| {
        let (mut sum, mut covered) = ([0.0; 3], 0usize);
        for radiance in (0..samples).filter_map(|sample| radiance(pixel, sample)) {
            covered += 1;
            (0..3).for_each(|channel| sum[channel] += radiance[channel]);
        }
        (sum.map(|s| (s / samples as f64) as f32), covered as f32 / samples as f32)
    };
    let rows: Vec<Vec<([f32; 3], f32)>> = (0..frame.height)
        .into_par_iter()
        .map(|row| (row * frame.width..(row + 1) * frame.width).map(pixel).collect())
        .collect();
    let (pixels, coverage) = rows.into_iter().flatten().unzip();
    LinearImage { width: frame.width, height: frame.height, pixels, coverage, background: scene.background }
}
