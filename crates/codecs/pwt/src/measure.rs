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
    /// Texels of each that were compared: defined ones.
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
    let sums = sums(samples, stride, |light| {
        let weights = decoder.pack().header().weights(samples.lights[light]);
        let unpacked = &unpacked;
        move |row| Cow::Owned(unpacked.rows(row..row + 1, &weights))
    });
    StackErrors::of(&sums, compared_texels(samples, stride))
}

/// Errors of pictures against photographs of the same size under the same lights: of all together, and of each.
pub fn picture_errors(pictures: &LightSamples, samples: &LightSamples) -> (StackErrors, Vec<StackErrors>) {
    let width = samples.size[0];
    let rows = |light: usize| move |row: usize| Cow::Borrowed(&pictures.pictures[light][row * width..][..width]);
    let sums = sums(samples, 1, rows);
    let texels = compared_texels(samples, 1);
    (StackErrors::of(&sums, texels), sums.iter().map(|sum| StackErrors::of(&[*sum], texels)).collect())
}

/// What a pack shows at its finest level under some lights.
pub fn pictures_of_pack(decoder: &PwtDecoder, lights: Vec<[f32; 3]>) -> LightSamples {
    let unpacked = decoder.unpacked(0);
    let header = decoder.pack().header();
    let picture = |light: &[f32; 3]| unpacked.rows(0..unpacked.size()[1], &header.weights(*light));
    let pictures = lights.par_iter().map(picture).collect();
    LightSamples { size: unpacked.size(), pictures, lights, repeats: header.repeats, defined: None }
}

impl StackErrors {
    /// Of sums of each photograph: of squared differences of codes, and of ΔE.
    fn of(sums: &[[f64; 2]], texels: usize) -> Self {
        let count = (texels * sums.len()).max(1) as f64;
        let [squares, distances] = sums.iter().fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
        let (psnr, delta_e) = (decibels(squares / (3.0 * count)), distances / count);
        Self { lights: sums.len(), texels, psnr, delta_e }
    }
}

/// Rows that are compared.
fn compared(samples: &LightSamples, stride: usize) -> Vec<usize> {
    (0..samples.size[1]).step_by(stride.max(1)).collect()
}

/// Defined texels of these rows.
fn compared_texels(samples: &LightSamples, stride: usize) -> usize {
    let width = samples.size[0];
    let row = |y: usize| (y * width..(y + 1) * width).filter(|texel| samples.is_defined(*texel)).count();
    compared(samples, stride).into_iter().map(row).sum()
}

/// The sums of [`StackErrors::of`], a pair for each photograph. `rows` gives the rows of the picture of a light.
fn sums<'a, R>(samples: &LightSamples, stride: usize, rows: impl Fn(usize) -> R + Sync) -> Vec<[f64; 2]>
where
    R: Fn(usize) -> Cow<'a, [[f32; 3]]>,
{
    let width = samples.size[0];
    let compared = compared(samples, stride);
    let of_light = |light: usize| -> [f64; 2] {
        let found = rows(light);
        let mut sums = [0.0; 2];
        for row in &compared {
            let kept = |colours: &[[f32; 3]]| -> Vec<[f32; 3]> {
                let defined = |(x, colour): (usize, &[f32; 3])| samples.is_defined(row * width + x).then_some(*colour);
                colours.iter().enumerate().filter_map(defined).collect()
            };
            let (found, wanted) = (kept(&found(*row)), kept(&samples.pictures[light][row * width..][..width]));
            let codes = |colours: &[[f32; 3]]| shown(Domain::Linear, colours.as_flattened().to_vec());
            sums[0] += squares(&codes(&found), &codes(&wanted));
            let distance = |(found, wanted): (&[f32; 3], &[f32; 3])| distance_squared(lab(*found), lab(*wanted)).sqrt();
            sums[1] += found.iter().zip(&wanted).map(distance).map(f64::from).sum::<f64>();
        }
        sums
    };
    (0..samples.lights.len()).into_par_iter().map(of_light).collect()
}
