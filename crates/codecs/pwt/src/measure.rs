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
    /// Share of the photographs' texels that are neither black nor white.
    pub shown: f64,
    /// Brightest of those texels over the darkest, linear values; 1 where there are none.
    pub contrast: f64,
}

/// Smallest linear value, of any channel, that is not black: a fiftieth of white as an sRGB code.
const BLACK: f32 = 0.005;
/// Least share of texels that are neither black nor white for errors to say anything.
const SHOWN: f64 = 1e-3;
/// Least contrast among them.
const CONTRAST: f64 = 1.02;

/// Errors of a pack at its finest level against photographs, be they those that it was made of or others. Every
/// `stride`-th row is compared.
pub fn stack_errors(decoder: &PwtDecoder, samples: &LightSamples, stride: usize) -> StackErrors {
    let unpacked = decoder.unpacked(0);
    let sums = sums(samples, stride, |light| {
        let weights = decoder.pack().header().weights(samples.lights[light]);
        let unpacked = &unpacked;
        move |row| Cow::Owned(unpacked.rows(row..row + 1, &weights))
    });
    StackErrors::of_photographs(&sums)
}

/// Errors of pictures against photographs of the same size under the same lights.
pub fn picture_errors(pictures: &LightSamples, samples: &LightSamples) -> StackErrors {
    let width = samples.size[0];
    let rows = |light: usize| move |row: usize| Cow::Borrowed(&pictures.pictures[light][row * width..][..width]);
    StackErrors::of_photographs(&sums(samples, 1, rows))
}

/// Sums over one photograph, from which [`StackErrors::of_photographs`] are reckoned.
#[derive(Debug, Clone, Copy)]
pub struct PhotographSums {
    texels: usize,
    /// Texels of the photograph that are neither black nor white.
    shown: usize,
    /// Darkest and brightest sum of channels among them.
    range: [f32; 2],
    /// Squared differences of sRGB codes.
    squares: f64,
    /// ΔE.
    distances: f64,
}

impl Default for PhotographSums {
    fn default() -> Self {
        Self { texels: 0, shown: 0, range: [f32::INFINITY, 0.0], squares: 0.0, distances: 0.0 }
    }
}

/// Of texels, linear RGB, against those of a photograph.
pub fn photograph_sums(found: &[[f32; 3]], wanted: &[[f32; 3]]) -> PhotographSums {
    let codes = |colours: &[[f32; 3]]| shown(Domain::Linear, colours.as_flattened().to_vec());
    let seen = |colour: &[f32; 3]| lab(colour.map(|value| value.max(0.0)));
    let distance = |(found, wanted): (&[f32; 3], &[f32; 3])| distance_squared(seen(found), seen(wanted)).sqrt();
    let is_shown = |colour: &&[f32; 3]| colour.iter().any(|c| *c > BLACK) && colour.iter().any(|c| *c < 1.0);
    let shown = || wanted.iter().filter(is_shown).map(|colour| colour.iter().map(|c| c.max(0.0)).sum::<f32>());
    PhotographSums {
        texels: wanted.len(),
        shown: shown().count(),
        range: [shown().fold(f32::INFINITY, f32::min), shown().fold(0.0, f32::max)],
        squares: squares(&codes(found), &codes(wanted)),
        distances: found.iter().zip(wanted).map(distance).map(f64::from).sum(),
    }
}

impl std::ops::AddAssign for PhotographSums {
    fn add_assign(&mut self, other: Self) {
        self.texels += other.texels;
        self.shown += other.shown;
        self.range = [self.range[0].min(other.range[0]), self.range[1].max(other.range[1])];
        self.squares += other.squares;
        self.distances += other.distances;
    }
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
    /// Of photographs of one size.
    pub fn of_photographs(sums: &[PhotographSums]) -> Self {
        let mut all = PhotographSums::default();
        sums.iter().for_each(|sums| all += *sums);
        let count = all.texels.max(1) as f64;
        Self {
            lights: sums.len(),
            texels: sums.first().map_or(0, |sums| sums.texels),
            psnr: decibels(all.squares / (3.0 * count)),
            delta_e: all.distances / count,
            shown: all.shown as f64 / count,
            contrast: if all.shown > 0 { f64::from(all.range[1] / all.range[0]) } else { 1.0 },
        }
    }

    /// Why no error of these photographs says anything, if that is so: then no limit counts as met.
    pub fn nothing_shown(&self) -> Option<String> {
        if self.shown < SHOWN {
            let (found, needed) = (100.0 * self.shown, 100.0 * SHOWN);
            return Some(format!("{found:.2} % of the texels that are neither black nor white; {needed} % are needed"));
        }
        (self.contrast < CONTRAST).then(|| "no contrast: all texels look alike".to_owned())
    }
}

/// The sums of each photograph, over every `stride`-th row that has defined texels. `rows` gives the rows of the picture of a light.
fn sums<'a, R>(samples: &LightSamples, stride: usize, rows: impl Fn(usize) -> R + Sync) -> Vec<PhotographSums>
where
    R: Fn(usize) -> Cow<'a, [[f32; 3]]>,
{
    let width = samples.size[0];
    let is_seen = |row: &usize| (row * width..(row + 1) * width).any(|texel| samples.is_defined(texel));
    let compared: Vec<usize> = (0..samples.size[1]).filter(is_seen).step_by(stride.max(1)).collect();
    let of_light = |light: usize| -> PhotographSums {
        let found = rows(light);
        let mut sums = PhotographSums::default();
        for row in compared.iter().copied() {
            let kept = |colours: &[[f32; 3]]| -> Vec<[f32; 3]> {
                let defined = |(x, colour): (usize, &[f32; 3])| samples.is_defined(row * width + x).then_some(*colour);
                colours.iter().enumerate().filter_map(defined).collect()
            };
            sums += photograph_sums(&kept(&found(row)), &kept(&samples.pictures[light][row * width..][..width]));
        }
        sums
    };
    (0..samples.lights.len()).into_par_iter().map(of_light).collect()
}
