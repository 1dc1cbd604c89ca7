//! Errors of a pack against the photographs, decoded as in shaders.

use crate::candidates::{decibels, squares, to_srgb};
use crate::stack::LightSamples;
use brdfc_formats::pwt::{Domain, PwtDecoder, Weights};
use brdfc_metrics::lab::{distance_squared, lab};
use brdfc_metrics::shown::{MIN_CONTRAST, MIN_SHOWN, Shown};
use brdfc_readers::pixels::Pixels;
use rayon::prelude::*;
use std::borrow::Cow;

/// Errors over some lights.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct StackErrors {
    /// Number of photographs.
    pub lights: usize,
    /// Texels compared per photograph: defined ones.
    pub texels: usize,
    /// PSNR of all sRGB-encoded values, dB.
    pub psnr: f64,
    /// Mean of the PSNR of each photograph, dB.
    pub image_psnr: f64,
    /// Mean ΔE (CIE76) of the texels that are neither black nor white in the photographs, so that a black background does not dilute it;
    /// 0 without such texels.
    pub delta_e: f64,
    /// Share of the photographs' texels that are neither black nor white.
    pub shown: f64,
    /// Brightest of these texels over the darkest, linear values; 1 without such texels.
    pub contrast: f64,
}

/// Errors of a pack at its finest level against photographs, which may differ from the photographs of the fit. Compares
/// every `stride`-th row.
pub fn stack_errors(decoder: &PwtDecoder, samples: &LightSamples, stride: usize) -> StackErrors {
    let weights: Vec<Weights> = samples.lights.iter().map(|light| decoder.pack().header().weights(*light)).collect();
    let height = samples.view_size()[1];
    let sums = sums(samples, stride, |row| {
        let (view, row) = ((row / height) as u32, row % height);
        let unpacked = decoder.unpacked_rows(view, 0, row..row + 1);
        let weights = &weights;
        move |light: usize| Cow::Owned(unpacked.rows(row..row + 1, &weights[light]))
    });
    StackErrors::of_photographs(&sums)
}

/// Errors of images against photographs of the same size under the same lights.
pub fn image_errors(images: &LightSamples, samples: &LightSamples) -> StackErrors {
    let width = samples.size[0];
    let row = |row: usize| move |light: usize| images.images[light].linear(row * width..(row + 1) * width);
    StackErrors::of_photographs(&sums(samples, 1, row))
}

/// Sums over one photograph, from which [`StackErrors::of_photographs`] are computed.
#[derive(Debug, Clone, Copy, Default)]
pub struct PhotographSums {
    /// The photograph's texels.
    shown: Shown,
    /// Squared differences of sRGB-encoded values.
    squares: f64,
    /// Sum of ΔE over the texels that are neither black nor white.
    distances: f64,
}

/// Sums for texels in linear RGB against texels of a photograph.
pub fn photograph_sums(found: &[[f32; 3]], expected: &[[f32; 3]]) -> PhotographSums {
    let codes = |colours: &[[f32; 3]]| to_srgb(Domain::Linear, colours.as_flattened().to_vec());
    let seen = |colour: &[f32; 3]| lab(colour.map(|value| value.max(0.0)));
    let distance = |(found, expected): (&[f32; 3], &[f32; 3])| distance_squared(seen(found), seen(expected)).sqrt();
    let mut shown = Shown::default();
    let is_shown = |(_, expected): &(&[f32; 3], &[f32; 3])| shown.add(expected.map(f64::from));
    let distances = found.iter().zip(expected).filter(is_shown).map(distance).map(f64::from).sum();
    PhotographSums { squares: squares(&codes(found), &codes(expected)), distances, shown }
}

impl PhotographSums {
    /// PSNR of sRGB-encoded values, dB.
    pub fn psnr(&self) -> f64 {
        decibels(self.squares / (3.0 * self.shown.of.max(1) as f64))
    }

    /// Mean ΔE of the texels that are neither black nor white; 0 without any.
    pub fn mean_delta_e(&self) -> f64 {
        self.distances / self.shown.count.max(1) as f64
    }
}

impl std::ops::AddAssign for PhotographSums {
    fn add_assign(&mut self, other: Self) {
        self.shown += other.shown;
        self.squares += other.squares;
        self.distances += other.distances;
    }
}

/// Images that a pack shows at its finest level for a unit vector to the viewer under some lights.
pub fn images_of_pack(decoder: &PwtDecoder, view: [f32; 3], lights: Vec<[f32; 3]>) -> LightSamples {
    let images = images_at(decoder, view, 0, &lights);
    let header = decoder.pack().header();
    LightSamples { repeats: header.repeats, ..LightSamples::new(header.size.map(|side| side as usize), lights, images) }
}

/// Images at a mipmap level, blended between views as by [`PwtDecoder::value`].
pub fn images_at(decoder: &PwtDecoder, view: [f32; 3], level: u32, lights: &[[f32; 3]]) -> Vec<Vec<[f32; 3]>> {
    let header = decoder.pack().header();
    let (views, shares) = header.seen(view);
    let seen = views.into_iter().zip(shares).filter(|(_, share)| *share > 0.0);
    let unpacked: Vec<_> = seen.map(|(view, share)| (decoder.unpacked(view, level), share)).collect();
    let image = |light: &[f32; 3]| {
        let weights = header.weights(*light);
        let [width, height] = unpacked[0].0.size();
        let mut blended = vec![[0.0f32; 3]; width * height];
        for (view, share) in &unpacked {
            let colours = view.rows(0..height, &weights);
            blended.iter_mut().zip(colours).for_each(|(sum, colour)| (0..3).for_each(|c| sum[c] += share * colour[c]));
        }
        blended
    };
    lights.par_iter().map(image).collect()
}

impl StackErrors {
    /// Errors over photographs of one size.
    pub fn of_photographs(sums: &[PhotographSums]) -> Self {
        let mut all = PhotographSums::default();
        sums.iter().for_each(|sums| all += *sums);
        Self {
            lights: sums.len(),
            texels: sums.first().map_or(0, |sums| sums.shown.of),
            psnr: all.psnr(),
            image_psnr: sums.iter().map(PhotographSums::psnr).sum::<f64>() / sums.len().max(1) as f64,
            delta_e: all.mean_delta_e(),
            shown: all.shown.share(),
            contrast: all.shown.contrast(),
        }
    }

    /// The reason why errors of these photographs are meaningless, if they are. No limit counts as met then.
    pub fn nothing_shown(&self) -> Option<String> {
        if self.shown < MIN_SHOWN {
            let (found, needed) = (100.0 * self.shown, 100.0 * MIN_SHOWN);
            return Some(format!(
                "only {found:.3} % of the texels are neither black nor white; expected at least {needed} %"
            ));
        }
        (self.contrast < MIN_CONTRAST).then(|| "no contrast, because all texels look alike".to_owned())
    }
}

/// Sums of each photograph, over every `stride`-th row that has defined texels. `images` returns the rows of all images: colours by
/// light.
fn sums<'a, R>(samples: &LightSamples, stride: usize, images: impl Fn(usize) -> R + Sync) -> Vec<PhotographSums>
where
    R: Fn(usize) -> Cow<'a, [[f32; 3]]>,
{
    let width = samples.size[0];
    let is_seen = |row: &usize| (row * width..(row + 1) * width).any(|texel| samples.is_defined(texel));
    let rows: Vec<usize> = (0..samples.size[1]).filter(is_seen).collect();
    let first = (stride / 2).min(rows.len().saturating_sub(1));
    let compared: Vec<usize> = rows.into_iter().skip(first).step_by(stride.max(1)).collect();
    let of_row = |row: &usize| -> Vec<PhotographSums> {
        let (found, first) = (images(*row), row * width);
        let masked = |colours: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let defined = |(x, colour): (usize, &[f32; 3])| samples.is_defined(first + x).then_some(*colour);
            colours.iter().enumerate().filter_map(defined).collect()
        };
        let of_light = |(light, image): (usize, &Pixels)| {
            photograph_sums(&masked(&found(light)), &masked(&image.linear(first..first + width)))
        };
        samples.images.iter().enumerate().map(of_light).collect()
    };
    let rows: Vec<Vec<PhotographSums>> = compared.par_iter().map(of_row).collect();
    let mut sums = vec![PhotographSums::default(); samples.lights.len()];
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(sum, row)| *sum += row);
    }
    sums
}
