//! How wrong a pack is: decoded as shaders do, against the photographs.

use crate::choose::{decibels, shown, squares};
use crate::stack::LightSamples;
use brdfc_formats::pwt::{Domain, PwtDecoder};
use brdfc_metrics::lab::{distance_squared, lab};
use rayon::prelude::*;
use std::borrow::Cow;

/// Errors at some lights.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct StackErrors {
    /// Photographs.
    pub lights: usize,
    /// Texels of each that were compared.
    pub texels: usize,
    /// Peak signal-to-noise ratio of sRGB codes, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

/// Errors of a pack at its finest level against photographs, be they those that it was made of or others. Every
/// `stride`-th row is compared.
pub fn stack_errors(decoder: &PwtDecoder, samples: &LightSamples, stride: usize) -> StackErrors {
    let unpacked = decoder.unpacked(0);
    compared(samples, stride, |light| {
        let weights = decoder.pack().header().weights(samples.lights[light]);
        let unpacked = &unpacked;
        move |row| Cow::Owned(unpacked.rows(row..row + 1, &weights))
    })
}

/// Errors of pictures against photographs of the same size under the same lights.
pub fn picture_errors(pictures: &LightSamples, samples: &LightSamples) -> StackErrors {
    let width = samples.size[0];
    compared(samples, 1, |light| move |row: usize| Cow::Borrowed(&pictures.pictures[light][row * width..][..width]))
}

/// `rows` gives the rows of the picture of a light.
fn compared<'a, R>(samples: &LightSamples, stride: usize, rows: impl Fn(usize) -> R + Sync) -> StackErrors
where
    R: Fn(usize) -> Cow<'a, [[f32; 3]]>,
{
    let [width, height] = samples.size;
    let compared: Vec<usize> = (0..height).step_by(stride.max(1)).collect();
    let of_light = |light: usize| -> [f64; 2] {
        let found = rows(light);
        let mut sums = [0.0; 2];
        for row in &compared {
            let found = found(*row);
            let wanted = &samples.pictures[light][row * width..][..width];
            let codes = |colours: &[[f32; 3]]| shown(Domain::Linear, colours.as_flattened().to_vec());
            sums[0] += squares(&codes(&found), &codes(wanted));
            let distance = |(found, wanted): (&[f32; 3], &[f32; 3])| distance_squared(lab(*found), lab(*wanted)).sqrt();
            sums[1] += found.iter().zip(wanted).map(distance).map(f64::from).sum::<f64>();
        }
        sums
    };
    let sums: Vec<[f64; 2]> = (0..samples.lights.len()).into_par_iter().map(of_light).collect();
    let texels = compared.len() * width;
    let count = (texels * sums.len()).max(1) as f64;
    let [squares, distances] = sums.iter().fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
    StackErrors { lights: sums.len(), texels, psnr: decibels(squares / (3.0 * count)), delta_e: distances / count }
}
