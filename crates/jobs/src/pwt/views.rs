//! All views of a BTF as stacked images, and packs of them compared with it.

use super::limits::{check_linear, refused};
use crate::error::Error;
use brdfc_formats::Pack;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatBtfFile, FlatView, unit_vectors};
use brdfc_formats::pwt::{MAX_VIEWS, PwtDecoder};
use brdfc_pwt::measure::{PhotographSums, StackErrors, images_at, photograph_sums};
use brdfc_pwt::{LightSamples, Views};
use brdfc_source::flat_btf::flat_view as decoded_view;
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::pack::open_pack;
use brdfc_source::photograph::CodeValues;
use brdfc_source::{Input, InputError};
use rayon::prelude::*;
use std::path::Path;

/// Views of a BTF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewChoice {
    /// One view, by its index.
    One(usize),
    /// All views.
    All,
}

/// Errors of a pack against a BTF.
#[derive(Debug, Clone, serde::Serialize, schemars::JsonSchema)]
pub struct BtfComparison {
    /// Errors over all images.
    #[serde(flatten)]
    pub errors: StackErrors,
    /// Errors of each view.
    pub views: Vec<ViewErrors>,
}

/// Errors of one view, over all lights.
#[derive(Debug, Clone, Copy, serde::Serialize, schemars::JsonSchema)]
pub struct ViewErrors {
    /// Unit vector to the viewer.
    pub view: [f32; 3],
    /// PSNR of sRGB levels, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

fn single(direction: [f64; 3]) -> [f32; 3] {
    direction.map(|c| c as f32)
}

/// Checks the number of views and the memory of all images of `size`, and triangulates the views.
fn checked_views(path: &Path, set: &DirectionSet, lights: usize, size: [usize; 2]) -> Result<Views, Error> {
    if !(2..=MAX_VIEWS as usize).contains(&set.len()) {
        let allowed = format!("2 to {MAX_VIEWS}; --view 0 takes one");
        return Err(refused(&path.display(), "views", &set.len().to_string(), &allowed));
    }
    check_linear(&path.display(), size, lights * set.len())?;
    Ok(Views::new(set.clone()).map_err(|error| InputError::format(path, error))?)
}

/// Images of all views under each light: `image` returns those of a view under a light, row by row from the top.
fn stacked(
    views: Views,
    lights: Vec<[f32; 3]>,
    [width, height]: [usize; 2],
    image: impl Fn(usize, usize) -> Result<Vec<[f32; 3]>, InputError> + Sync,
) -> Result<LightSamples, Error> {
    let size = [width, height * views.len()];
    let of_light = |light: usize| -> Result<Vec<[f32; 3]>, InputError> {
        let mut pixels = Vec::with_capacity(size[0] * size[1]);
        for view in 0..views.len() {
            pixels.extend(image(view, light)?.into_iter().map(|pixel| pixel.map(|value| value.max(0.0))));
        }
        Ok(pixels)
    };
    let images: Vec<Result<_, _>> = (0..lights.len()).into_par_iter().map(of_light).collect();
    let images = images.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(LightSamples { repeats: true, views: Some(views), ..LightSamples::new(size, lights, images) })
}

/// Reads all images of an ordinary BTF.
pub(super) fn all_views(path: &Path, btf: &OrdinaryBtf) -> Result<LightSamples, Error> {
    let lights: Vec<[f32; 3]> = btf.lights().directions().into_iter().map(single).collect();
    let views = checked_views(path, btf.views(), lights.len(), btf.size())?;
    stacked(views, lights, btf.size(), |view, light| btf.image(view, light).map(|image| image.pixels))
}

/// Decodes all views of a flat BTF with components. Rows of flat BTFs go up, rows of images go down.
pub(super) fn all_flat_views(path: &Path, file: &FlatBtfFile) -> Result<LightSamples, Error> {
    let of_file = |error| Error::from(InputError::format(path, error));
    // Reports a file without sampled views.
    decoded_view(file, 0).map_err(of_file)?;
    let factors = file.decoder.parts().reflectance.factors().expect("it has sampled views");
    let header = factors.header();
    let angles = header.views.iter().map(|angles| angles.map(|angle| f64::from(angle).to_degrees())).collect();
    let set = DirectionSet { name: "views".to_owned(), angles };
    let lights = unit_vectors(&header.lights);
    let side = header.size as usize;
    let views = checked_views(path, &set, lights.len(), [side, side])?;
    let decoded: Vec<FlatView> = (0..set.len() as u32).into_par_iter().map(|view| factors.view(view)).collect();
    stacked(views, lights, [side, side], |view, light| {
        let rows = decoded[view].light(light as u32).chunks_exact(side).rev();
        Ok(rows.flatten().map(|texel| brdfc_formats::container::rgb9e5::decode(*texel)).collect())
    })
}

/// Measures a pack of several views against all images of an ordinary BTF, as sRGB levels and by ΔE (CIE76). Reads one image at a
/// time for each thread; the memory is that of the decoded images of one view. `codes` is the meaning of the code values of images in
/// spite of what they state.
///
/// # Errors
/// Returns an error if an input cannot be read or is of another kind or size.
pub fn compare_btf(reference: &Path, input: &Input, codes: Option<CodeValues>) -> Result<BtfComparison, Error> {
    let btf = OrdinaryBtf::open_as(reference, codes)?;
    let decoder = match open_pack(input)? {
        Pack::Pwt(pack) if pack.header().view_count() > 1 => PwtDecoder::new(pack),
        Pack::Pwt(_) => return Err(refused(input, "views", "1", "2 or more, as of 'brdfc pwt --view all'")),
        other => return Err(refused(input, "pack", other.kind().summary(), "a polynomial wavelet tree of a BTF")),
    };
    let (found, expected) = (decoder.pack().header().size.map(|side| side as usize), btf.size());
    if found != expected {
        let [found, expected] = [found, expected].map(|[width, height]| format!("{width} x {height}"));
        return Err(refused(input, "size", &found, &format!("{expected}, the size of the reference")));
    }
    let lights: Vec<[f32; 3]> = btf.lights().directions().into_iter().map(single).collect();
    let views: Vec<[f32; 3]> = btf.views().directions().into_iter().map(single).collect();
    let mut all = Vec::new();
    let mut errors = Vec::new();
    for (number, view) in views.iter().enumerate() {
        let images = images_at(&decoder, *view, 0, &lights);
        let of_light = |(light, image): (usize, &Vec<[f32; 3]>)| -> Result<PhotographSums, InputError> {
            Ok(photograph_sums(image, &btf.image(number, light)?.pixels))
        };
        let sums: Vec<Result<_, _>> = images.par_iter().enumerate().map(of_light).collect();
        let sums = sums.into_iter().collect::<Result<Vec<_>, _>>()?;
        let StackErrors { psnr, delta_e, .. } = StackErrors::of_photographs(&sums);
        errors.push(ViewErrors { view: *view, psnr, delta_e });
        all.extend(sums);
    }
    Ok(BtfComparison { errors: StackErrors::of_photographs(&all), views: errors })
}
