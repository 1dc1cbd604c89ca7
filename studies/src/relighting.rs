//! Figure 1 (b) of Baril et al. 2008: polynomial wavelet trees compared with the current formats for photographs under
//! known lights, at fitted and at held-out lights.

use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtDecoder, PwtPack};
use brdfc_jobs::pwt::permutation;
use brdfc_metrics::image::LinearImage;
use brdfc_pwt::measure::{StackErrors, image_errors, images_of_pack, stack_errors};
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{LightSamples, PwtRecipe, Target, encode, plain};
use brdfc_readers::ptm::Ptm;
use serde::Serialize;
use std::time::Instant;

/// Settings of a study of relighting.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RelightingSettings {
    /// Columns and rows: cropped to multiples of 32.
    pub size: [usize; 2],
    /// Number of lights.
    pub lights: usize,
    /// Number of held-out lights.
    pub held_out: usize,
    /// Seeds of the permutations that select them.
    pub seeds: Vec<u64>,
}

/// Result of a method to store photographs under known lights. Values are means over the seeds.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RelightingRow {
    /// Name of the method.
    pub method: String,
    /// Bytes on a GPU, including mipmaps.
    pub bytes: f64,
    /// Share of the bytes of the polynomial texture map.
    pub share: f64,
    /// Fetches per pixel.
    pub fetches: f64,
    /// Signal-to-noise ratio at the fitted lights, dB.
    pub psnr: f64,
    /// Signal-to-noise ratio at the held-out lights, dB.
    pub held_out_psnr: f64,
    /// Mean ΔE at the fitted lights.
    pub delta_e: f64,
    /// Mean ΔE at the held-out lights.
    pub held_out_delta_e: f64,
    /// Seconds to encode.
    pub seconds: f64,
}

/// A study of relighting.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RelightingStudy {
    /// Settings of the study.
    pub settings: RelightingSettings,
    /// One row for each method.
    pub rows: Vec<RelightingRow>,
}

/// The compared methods.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    /// A polynomial texture map as in its file format.
    Map(MapModel),
    /// All terms from a level on.
    Plain(LightBasis, u32),
    /// A tree with a maximum size, as a share of the map's.
    Share(f64),
    /// A tree with the encoder's default options.
    Default,
}

const HARMONICS: LightBasis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 3 };
const BIQUADRATIC: LightBasis = LightBasis { coordinates: LightCoordinates::Projected, degree: 2 };

const METHODS: [(&str, Method); 10] = [
    ("PTM, RGB", Method::Map(MapModel::Rgb)),
    ("PTM, LRGB", Method::Map(MapModel::Lrgb)),
    ("PTM at half size", Method::Plain(BIQUADRATIC, 1)),
    ("HSH, order 3", Method::Plain(HARMONICS, 0)),
    ("HSH, order 3, at half size", Method::Plain(HARMONICS, 1)),
    ("HSH, order 3, at a quarter", Method::Plain(HARMONICS, 2)),
    ("PWT, 30 % of PTM", Method::Share(0.3)),
    ("PWT, 15 %", Method::Share(0.15)),
    ("PWT, 5 %", Method::Share(0.05)),
    ("PWT", Method::Default),
];

/// Bytes of a map's coefficients as textures with mipmaps.
fn map_bytes(size: [usize; 2], model: MapModel) -> f64 {
    let bytes = if model == MapModel::Rgb { 18.0 } else { 9.0 };
    bytes * (size[0] * size[1]) as f64 * 4.0 / 3.0
}

enum Made {
    Map(Ptm),
    Pack(PwtPack),
}

fn made(method: Method, samples: &LightSamples) -> Result<(Made, f64, f64), FormatError> {
    match method {
        // Two or four coefficients of a channel per texel of four.
        Method::Map(model) => {
            let fetches = if model == MapModel::Rgb { 5.0 } else { 3.0 };
            Ok((Made::Map(fit_map(samples, model)?), map_bytes(samples.size, model), fetches))
        }
        Method::Plain(basis, level) => packed(plain(samples, basis, level)?),
        Method::Share(share) => {
            let bytes = (share * map_bytes(samples.size, MapModel::Rgb)) as u64;
            packed(encode(samples, &PwtRecipe { target: Target::Bytes(bytes), ..PwtRecipe::default() })?.pack)
        }
        Method::Default => packed(encode(samples, &PwtRecipe::default())?.pack),
    }
}

fn packed(pack: PwtPack) -> Result<(Made, f64, f64), FormatError> {
    let (bytes, fetches) = (pack.gpu_bytes() as f64, f64::from(pack.header().fetches()));
    Ok((Made::Pack(pack), bytes, fetches))
}

fn errors(made: &Made, samples: &LightSamples) -> StackErrors {
    match made {
        Made::Map(map) => image_errors(&images_of(map, samples.lights.clone()), samples),
        Made::Pack(pack) => stack_errors(&PwtDecoder::new(pack.clone()), samples, 1),
    }
}

/// Compares all methods on photographs. Calls `done` after each.
///
/// # Errors
/// Returns an error for photographs out of range, or if no light is left to fit.
pub fn relighting(
    samples: &LightSamples,
    held_out: usize,
    seeds: &[u64],
    done: &dyn Fn(&str),
) -> Result<RelightingStudy, FormatError> {
    let samples = samples.cropped(32);
    let lights = samples.lights.len();
    if !(1..lights).contains(&held_out) {
        let allowed = format!("1 to {}", lights.saturating_sub(1));
        return Err(FormatError::whole("lights held out", held_out.to_string(), allowed));
    }
    let whole = map_bytes(samples.size, MapModel::Rgb);
    let mut rows = Vec::new();
    for (name, method) in METHODS {
        let mut sums = [0.0; 7];
        for seed in seeds {
            let order = permutation(lights, *seed);
            let (unseen, fitted) = order.split_at(held_out);
            let (fitted, unseen) = (samples.without(unseen), samples.without(fitted));
            let start = Instant::now();
            let (made, bytes, fetches) = made(method, &fitted)?;
            let seconds = start.elapsed().as_secs_f64();
            let [fitted, unseen] = [errors(&made, &fitted), errors(&made, &unseen)];
            let figures = [bytes, fetches, fitted.psnr, unseen.psnr, fitted.delta_e, unseen.delta_e, seconds];
            sums.iter_mut().zip(figures).for_each(|(sum, figure)| *sum += figure / seeds.len() as f64);
        }
        let [bytes, fetches, psnr, held_out_psnr, delta_e, held_out_delta_e, seconds] = sums;
        let (method, share) = (name.to_owned(), bytes / whole);
        let row =
            RelightingRow { method, bytes, share, fetches, psnr, held_out_psnr, delta_e, held_out_delta_e, seconds };
        rows.push(row);
        done(name);
    }
    let settings = RelightingSettings { size: samples.size, lights, held_out, seeds: seeds.to_vec() };
    Ok(RelightingStudy { settings, rows })
}

/// A held-out photograph, and its reconstructions by a polynomial texture map and a tree of at most 30 % of its bytes:
/// linear RGB, side by side.
///
/// # Errors
/// Returns the errors of [`relighting`].
pub fn relit(samples: &LightSamples, held_out: usize) -> Result<LinearImage, FormatError> {
    let samples = samples.cropped(32);
    let lights = samples.lights.len();
    let order = permutation(lights, 0);
    let unseen = &order[..held_out.clamp(1, lights.max(2) - 1)];
    // Among the held-out lights, the one nearest to halfway down.
    let off = |light: &usize| (samples.lights[*light][2] - std::f32::consts::FRAC_1_SQRT_2).abs();
    let shown = unseen.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)));
    let shown = shown.unwrap_or(0);
    let rest: Vec<usize> = (0..lights).filter(|light| *light != shown).collect();
    let photograph = samples.without(&rest);
    let fitted = samples.without(unseen);
    let map = images_of(&fit_map(&fitted, MapModel::Rgb)?, photograph.lights.clone());
    let bytes = (0.3 * map_bytes(samples.size, MapModel::Rgb)) as u64;
    let tree = encode(&fitted, &PwtRecipe { target: Target::Bytes(bytes), ..PwtRecipe::default() })?.pack;
    let tree = images_of_pack(&PwtDecoder::new(tree), photograph.lights.clone());
    let width = samples.size[0];
    let rows = photograph.images[0].chunks(width).zip(map.images[0].chunks(width)).zip(tree.images[0].chunks(width));
    let pixels: Vec<[f32; 3]> = rows.flat_map(|((a, b), c)| [a, b, c].concat()).collect();
    let (width, height) = (3 * width, samples.size[1]);
    Ok(LinearImage { pixels, coverage: vec![1.0; width * height], ..LinearImage::black(width, height) })
}
