//! Figure 1 (b) of Baril et al. 2008: polynomial wavelet trees compared with the formats and methods that people relight with,
//! at fitted and at held-out lights.

mod peers;
mod ssim;

use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtDecoder, PwtPack};
use brdfc_jobs::pwt::permutation;
use brdfc_metrics::image::LinearImage;
use brdfc_pwt::measure::{StackErrors, image_errors, images_of_pack};
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{LightSamples, PwtRecipe, Target, encode, plain};
use brdfc_readers::ptm::Ptm;
use peers::{Between, PrincipalComponents};
use serde::Serialize;
use ssim::similarity;
use std::borrow::Cow;
use std::time::Instant;

/// Photographs to compare methods on.
pub struct Stack {
    /// Name in tables.
    pub name: String,
    /// Photographs from which lights are held out, or that are fitted.
    pub samples: LightSamples,
    /// Photographs under other lights; `None` to hold lights out.
    pub unseen: Option<LightSamples>,
}

/// A study of one stack.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct StackStudy {
    /// Name of the stack.
    pub name: String,
    /// Columns and rows: cropped to multiples of 32.
    pub size: [usize; 2],
    /// Number of fitted lights.
    pub lights: usize,
    /// Number of held-out lights.
    pub held_out: usize,
    /// Number of choices of these lights.
    pub splits: usize,
    /// One row for each method.
    pub rows: Vec<RelightingRow>,
}

/// Result of a method to store photographs under known lights. Values are means over the choices of held-out lights.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RelightingRow {
    /// Name of the method.
    pub method: String,
    /// Bytes on a GPU per pixel, including mipmaps.
    pub bytes_per_pixel: f64,
    /// Fetches per pixel under a distant light.
    pub fetches: f64,
    /// PSNR over all values at the fitted lights, dB.
    pub psnr: f64,
    /// PSNR over all values at the held-out lights, dB.
    pub held_out_psnr: f64,
    /// Mean of the PSNR of each photograph at the held-out lights, dB.
    pub held_out_image_psnr: f64,
    /// Mean structural similarity (Wang et al. 2004) at the held-out lights.
    pub held_out_ssim: f64,
    /// Mean ΔE at the fitted lights.
    pub delta_e: f64,
    /// Mean ΔE at the held-out lights.
    pub held_out_delta_e: f64,
    /// Seconds to encode.
    pub seconds: f64,
    /// Seconds to compute one image on the CPU.
    pub image_seconds: f64,
}

/// A study of relighting.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RelightingStudy {
    /// One for each stack.
    pub stacks: Vec<StackStudy>,
    /// Means over the stacks.
    pub means: Vec<RelightingRow>,
}

/// The compared methods.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    /// A polynomial texture map as in its file format.
    Map(MapModel),
    /// All terms.
    Plain(LightBasis),
    /// Principal components, interpolated between the lights.
    Components(Between, usize),
    /// A tree with at most the bytes of so many planes with mipmaps.
    Planes(usize),
    /// A tree with the encoder's default options.
    Default,
}

const HARMONICS: LightBasis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 3 };

/// Numbers of planes whose methods are compared at equal bytes.
pub const PLANES: [usize; 3] = [9, 18, 27];

/// All methods. Names of components and trees end in their number of planes.
fn methods() -> Vec<(String, Method)> {
    let mut all = vec![
        ("PTM, RGB".to_owned(), Method::Map(MapModel::Rgb)),
        ("PTM, LRGB".to_owned(), Method::Map(MapModel::Lrgb)),
        ("HSH, order 3".to_owned(), Method::Plain(HARMONICS)),
    ];
    for planes in PLANES {
        for between in [Between::ThinPlates, Between::Gaussians] {
            all.push((format!("{} {planes}", between.name()), Method::Components(between, planes)));
        }
    }
    for planes in [3].into_iter().chain(PLANES) {
        all.push((format!("{TREE} {planes}"), Method::Planes(planes)));
    }
    all.push((TREE.to_owned(), Method::Default));
    all
}

/// Name of trees in tables.
pub const TREE: &str = "PWT";

/// Names of the methods that interpolate components.
pub fn component_names() -> [&'static str; 2] {
    [Between::ThinPlates.name(), Between::Gaussians.name()]
}

/// Bytes of planes of 8 bits with mipmaps.
fn plane_bytes(size: [usize; 2], planes: f64) -> f64 {
    planes * (size[0] * size[1]) as f64 * 4.0 / 3.0
}

enum Made {
    Map(Ptm),
    Pack(PwtPack),
    Components(PrincipalComponents),
}

/// Encodes photographs. Returns bytes and fetches as well.
fn made(method: Method, samples: &LightSamples) -> Result<(Made, f64, f64), FormatError> {
    match method {
        // Two or four coefficients of a channel per texel of four.
        Method::Map(model) => {
            let (planes, fetches) = if model == MapModel::Rgb { (18.0, 5.0) } else { (9.0, 3.0) };
            Ok((Made::Map(fit_map(samples, model)?), plane_bytes(samples.size, planes), fetches))
        }
        Method::Plain(basis) => packed(plain(samples, basis, 0)?),
        Method::Components(between, planes) => {
            let components = PrincipalComponents::new(samples, planes, between);
            let fetches = planes.div_ceil(4) as f64;
            Ok((Made::Components(components), plane_bytes(samples.size, planes as f64), fetches))
        }
        Method::Planes(planes) => {
            let bytes = plane_bytes(samples.size, planes as f64) as u64;
            packed(encode(samples, &PwtRecipe { target: Target::Bytes(bytes), ..PwtRecipe::default() })?.pack)
        }
        Method::Default => packed(encode(samples, &PwtRecipe::default())?.pack),
    }
}

fn packed(pack: PwtPack) -> Result<(Made, f64, f64), FormatError> {
    let (bytes, fetches) = (pack.gpu_bytes() as f64, f64::from(pack.header().fetches()));
    Ok((Made::Pack(pack), bytes, fetches))
}

/// Images under some lights.
fn shown(made: &Made, lights: Vec<[f32; 3]>) -> LightSamples {
    match made {
        Made::Map(map) => images_of(map, lights),
        Made::Pack(pack) => images_of_pack(&PwtDecoder::new(pack.clone()), [0.0, 0.0, 1.0], lights),
        Made::Components(components) => components.images(lights),
    }
}

/// The fitted and the held-out photographs of each choice.
fn splits(stack: &Stack, held_out: usize, seeds: &[u64]) -> Result<Vec<(LightSamples, LightSamples)>, FormatError> {
    let samples = stack.samples.cropped(32);
    if let Some(unseen) = &stack.unseen {
        return Ok(vec![(samples, unseen.cropped(32))]);
    }
    let lights = samples.lights.len();
    if !(1..lights).contains(&held_out) {
        let allowed = format!("1 to {}", lights.saturating_sub(1));
        return Err(FormatError::whole("lights held out", held_out.to_string(), allowed));
    }
    let split = |seed: &u64| {
        let order = permutation(lights, *seed);
        let (unseen, fitted) = order.split_at(held_out);
        (samples.without(unseen), samples.without(fitted))
    };
    Ok(seeds.iter().map(split).collect())
}

/// Compares all methods on stacks. `seeds` choose the lights that are held out of stacks without unseen photographs. Calls
/// `done` after each method.
///
/// # Errors
/// Returns an error for photographs out of range, or if no light is left to fit.
pub fn relighting(
    stacks: &[Stack],
    held_out: usize,
    seeds: &[u64],
    done: &dyn Fn(&str, &str),
) -> Result<RelightingStudy, FormatError> {
    let mut studies = Vec::new();
    for stack in stacks {
        let splits = splits(stack, held_out, seeds)?;
        let mut rows = Vec::new();
        for (name, method) in methods() {
            let of_split = |(fitted, unseen): &(LightSamples, LightSamples)| figures(method, fitted, unseen);
            let all = splits.iter().map(of_split).collect::<Result<Vec<_>, _>>()?;
            rows.push(row(&name, &all));
            done(&stack.name, &name);
        }
        let (fitted, unseen) = &splits[0];
        studies.push(StackStudy {
            name: stack.name.clone(),
            size: fitted.size,
            lights: fitted.lights.len(),
            held_out: unseen.lights.len(),
            splits: splits.len(),
            rows,
        });
    }
    let mean = |k: usize| {
        let rows: Vec<[f64; 10]> = studies.iter().map(|study| study.rows[k].numbers()).collect();
        row(&studies[0].rows[k].method, &rows)
    };
    let means = if studies.is_empty() { Vec::new() } else { (0..studies[0].rows.len()).map(mean).collect() };
    Ok(RelightingStudy { stacks: studies, means })
}

fn figures(method: Method, fitted: &LightSamples, unseen: &LightSamples) -> Result<[f64; 10], FormatError> {
    let start = Instant::now();
    let (made, bytes, fetches) = made(method, fitted)?;
    let seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let _ = shown(&made, vec![unseen.lights[0]]);
    let image_seconds = start.elapsed().as_secs_f64();
    let seen = image_errors(&shown(&made, fitted.lights.clone()), fitted);
    let images = shown(&made, unseen.lights.clone());
    let StackErrors { psnr, delta_e, image_psnr, .. } = image_errors(&images, unseen);
    let pixels = (fitted.size[0] * fitted.size[1]) as f64;
    let ssim = similarity(&images, unseen);
    Ok([bytes / pixels, fetches, seen.psnr, psnr, image_psnr, ssim, seen.delta_e, delta_e, seconds, image_seconds])
}

/// The row of a method, with means of its figures.
fn row(method: &str, all: &[[f64; 10]]) -> RelightingRow {
    let mean = |k: usize| all.iter().map(|figures| figures[k]).sum::<f64>() / all.len() as f64;
    RelightingRow {
        method: method.to_owned(),
        bytes_per_pixel: mean(0),
        fetches: mean(1),
        psnr: mean(2),
        held_out_psnr: mean(3),
        held_out_image_psnr: mean(4),
        held_out_ssim: mean(5),
        delta_e: mean(6),
        held_out_delta_e: mean(7),
        seconds: mean(8),
        image_seconds: mean(9),
    }
}

impl RelightingRow {
    fn numbers(&self) -> [f64; 10] {
        [
            self.bytes_per_pixel,
            self.fetches,
            self.psnr,
            self.held_out_psnr,
            self.held_out_image_psnr,
            self.held_out_ssim,
            self.delta_e,
            self.held_out_delta_e,
            self.seconds,
            self.image_seconds,
        ]
    }
}

/// A held-out photograph, and its reconstructions by a polynomial texture map, nine components between thin plates, and a tree with
/// the encoder's default options: linear RGB, side by side.
///
/// # Errors
/// Returns the errors of [`relighting`].
pub fn relit(stack: &Stack, held_out: usize) -> Result<LinearImage, FormatError> {
    let (fitted, unseen) = splits(stack, held_out, &[0])?.swap_remove(0);
    // Among the held-out lights, the one nearest to halfway down.
    let off = |light: &usize| (unseen.lights[*light][2] - std::f32::consts::FRAC_1_SQRT_2).abs();
    let light = (0..unseen.lights.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
    let mut images = vec![unseen.images[light].clone()];
    for method in [Method::Map(MapModel::Rgb), Method::Components(Between::ThinPlates, PLANES[0]), Method::Default] {
        images.append(&mut shown(&made(method, &fitted)?.0, vec![unseen.lights[light]]).images);
    }
    let [width, height] = unseen.size;
    let row = |row: usize| images.iter().map(move |image| image.linear(row * width..(row + 1) * width));
    let pixels: Vec<[f32; 3]> = (0..height).flat_map(row).flat_map(Cow::into_owned).collect();
    let width = images.len() * width;
    Ok(LinearImage { pixels, coverage: vec![1.0; width * height], ..LinearImage::black(width, height) })
}
