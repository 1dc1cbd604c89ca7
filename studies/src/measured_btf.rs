//! Flat BTFs of images: those of a structure, of all views under all lights, are flattened again with its surface, and
//! the result is compared with them.

use brdfc_core::address::AddressError;
use brdfc_flat_btf::encode::{
    EncodeError, FlatBtfEncoded, FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ReliefForm, ValueSource, encode,
};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_flat_btf::measured::ViewImages;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::rebuild::ViewImage;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_flat_btf::tile_image::TileImage;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile, MacroSurface, SampledDirections};
use brdfc_metrics::lab::{distance_squared, lab};
use brdfc_pwt::candidates::decibels;
use brdfc_readers::colour::encode_srgb;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::convert::Infallible;

/// Largest ΔE of factors before the march, as by `brdfc flatten`.
const TARGET: f64 = 0.7;

/// Errors of the study.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredBtfError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The images cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError<Infallible>),
    /// Directions that cannot be interpolated.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// Result for one structure and form.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MeasuredBtfRow {
    /// The structure's address.
    pub model: String,
    /// Input besides the surface: `images`, or its `materials`.
    pub from: &'static str,
    /// Texels per side of image, layers and flat BTF.
    pub texels: usize,
    /// Number of images: views times lights.
    pub images: usize,
    /// Bytes on a GPU, mipmaps included.
    pub gpu_bytes: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// PSNR over all pixels of all images, sRGB-encoded, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76) over the same.
    pub delta_e: f64,
}

/// Images of a structure.
struct Rendered<'a> {
    model: &'a MesoModel,
    appearance: &'a Appearance,
    lights: &'a [Vector],
    views: Vec<ViewImage>,
}

impl ViewImages for Rendered<'_> {
    type Error = Infallible;

    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, Infallible> {
        let seen = &self.views[view];
        let up = seen.direct(self.model, self.appearance, self.lights[light]);
        // The first row of a file is at the top.
        let pixels = up.chunks_exact(seen.size).rev().flatten().copied().collect();
        Ok(TileImage { width: seen.size, height: seen.size, pixels })
    }
}

/// Number of calls of `done` by [`measured_btf_study`] for a set of directions.
pub fn steps(directions: &DirectionSet) -> usize {
    2 * directions.len()
}

/// Flattens images of one structure, and then the structure with its materials; compares both with the images. Calls
/// `done` after each compared view.
///
/// # Errors
/// Returns an error for a wrong address, or a surface that cannot be encoded.
pub fn measured_btf_study(
    address: &str,
    texels: usize,
    set: &DirectionSet,
    done: &(dyn Fn() + Sync),
) -> Result<[MeasuredBtfRow; 2], MeasuredBtfError> {
    let structure = Structure::parse(address)?;
    let appearance = structure.appearance();
    let model = MesoModel::new(structure.mesh(), 0, &()).map_err(EncodeError::from)?;
    let directions = set.directions();
    let views = directions.iter().map(|view| ViewImage::new(&model, *view, texels, 1)).collect();
    let images = Rendered { model: &model, appearance: &appearance, lights: &directions, views };
    let row = |from, values, reflectance| {
        let recipe = FlattenRecipe {
            texels: texels as u32,
            relief: ReliefForm::Layers,
            flat_texels: texels,
            views: set.clone(),
            lights: set.clone(),
            fill: FillMethod::Poisson,
            bounces: 0,
            reflectance,
            target: FactoredTarget::Error(TARGET),
        };
        let input = FlatInput { mesh: structure.mesh(), repairs: None, values };
        let FlatBtfEncoded { decoder, .. } = encode(input, &recipe, &MemoryScratch::default(), &())?;
        let [psnr, delta_e] = errors(&images, &decoder, done)?;
        let file = FlatBtfFile::new(decoder)?;
        Ok::<_, MeasuredBtfError>(MeasuredBtfRow {
            model: structure.canonical(),
            from,
            texels,
            images: directions.len() * directions.len(),
            gpu_bytes: file.gpu_bytes(),
            file_bytes: file.to_bytes(true).len() as u64,
            psnr,
            delta_e,
        })
    };
    Ok([
        row("images", ValueSource::Measured(&images), Reflectance::Factors)?,
        row("materials", ValueSource::Computed(&appearance), Reflectance::Brdf)?,
    ])
}

/// PSNR and mean ΔE of a flat BTF over all images.
fn errors(images: &Rendered<'_>, decoder: &FlatBtfDecoder, done: &(dyn Fn() + Sync)) -> Result<[f64; 2], FormatError> {
    let directions = SampledDirections::of(decoder.parts())?;
    let single = |v: Vector| v.map(|c| c as f32);
    let of_view = |(seen, view): (&ViewImage, &Vector)| {
        let place = |k: usize| (k as f32 + 0.5) / seen.size as f32;
        let looks: Vec<_> = (0..seen.size * seen.size)
            .map(|at| [at % seen.size, at / seen.size].map(place))
            .map(|at| decoder.look(at, 0.0, single(*view), MacroSurface::PLANE))
            .collect();
        let mut sums = [0.0; 2];
        for light in images.lights {
            let truth = seen.direct(images.model, images.appearance, *light);
            for (look, truth) in looks.iter().zip(&truth) {
                let found = look.shaded(directions.as_ref(), single(*light));
                let differences = [0, 1, 2].map(|c| display(found[c]) - display(truth[c]));
                sums[0] += differences.iter().map(|d| d * d).sum::<f64>() / 3.0;
                sums[1] += f64::from(distance_squared(lab(found), lab(*truth)).sqrt());
            }
        }
        done();
        sums
    };
    let sums: Vec<[f64; 2]> = images.views.par_iter().zip(images.lights).map(of_view).collect();
    let pixels: usize = images.views.iter().map(|view| view.size * view.size * images.lights.len()).sum();
    let mean = |k: usize| sums.iter().map(|of_view| of_view[k]).sum::<f64>() / pixels as f64;
    Ok([decibels(mean(0)), mean(1)])
}

/// Value of a display, 0 to 1.
fn display(linear: f32) -> f64 {
    encode_srgb(f64::from(linear.clamp(0.0, 1.0)))
}
