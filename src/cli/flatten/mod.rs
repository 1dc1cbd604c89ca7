//! `brdfc flatten`: flat BTFs of surfaces with relief, and of ordinary BTFs.

mod arguments;
mod options;
mod text;

pub use arguments::Arguments;
pub(super) use text::text;

use super::directions::by_flags;
use super::options::failed;
use super::output::{json_or, make_folder, note, print};
use super::steps::Steps;
use super::{Common, Error, interrupt};
use brdfc::encode::ErrorLimits;
use brdfc::flatten::words::{check_sources, delta_e, missed, remarks};
use brdfc::flatten::{FlatAsset, FlattenJob, ImageFacts, StackFormat, Surface, Values, run as flatten};
use brdfc::inspect::Kind;
use brdfc::{FitLimits, encode::GateResult};
use options::{asset_name, check_inputs, check_outputs, meso_options, recipe};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Contents and size of the asset.
    #[serde(flatten)]
    asset: FlatAsset,
    /// Colour and other statements of the images that were read, and what was done; absent without images.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    read: Vec<ImageFacts>,
    /// Seconds from start to finish.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let started = Instant::now();
    let kind = Kind::of(&arguments.meso)?;
    // The folder of a flat BTF may also hold images, and a folder without images is reported as one.
    let is_stack = |path: &Path| kind == Kind::Btf || path.is_dir() && (kind.is_flat_btf() || kind == Kind::Folder);
    let stack = arguments.meso.path().filter(|path| is_stack(path));
    check_inputs(arguments)?;
    let name = asset_name(arguments)?;
    let mut recipe = recipe(arguments)?;
    let options = meso_options(arguments, stack.is_some())?;
    check_outputs(arguments, &name)?;
    let steps = Steps::new(common, interrupt::watch()?);
    let surface = Surface::open(&options, stack, arguments.reading.codes, &steps)?;
    if let Values::Measured(stack) = &surface.values {
        (recipe.views, recipe.lights) = (stack.views().clone(), stack.lights().clone());
    }
    let read = surface.images.clone();
    let reliability = surface.reliability.clone();
    let format = arguments.image_format.unwrap_or(StackFormat::Png);
    let images = arguments.write_images.as_deref().map(|folder| (folder, format));
    let job = FlattenJob {
        name: &name,
        folder: &arguments.out,
        recipe: &recipe,
        supercompress: !arguments.no_supercompression,
        surface,
        images,
        raw: arguments.write_flat.as_deref(),
    };
    job.check().map_err(|error| Error::usage(by_flags(&error)))?;
    make_folder(&arguments.out)?;
    for folder in [&arguments.write_images, &arguments.write_flat].into_iter().flatten() {
        make_folder(folder)?;
    }
    let asset = flatten(job, &steps)?;
    drop(steps);
    for line in remarks(&asset.about) {
        note(common, &arguments.meso, &line);
    }
    for (name, one) in asset.about.materials.iter().zip(&reliability) {
        one.remarks(delta_e(&asset.about).unwrap_or(0.0)).iter().for_each(|line| note(common, name, line));
    }
    let missed = missed(&asset.about);
    if let (Some(text), None) = (&missed, arguments.max_delta_e) {
        note(common, &arguments.meso, &format!("{text}, the default of --max-delta-e"));
    }
    // The default limit is not a check.
    let errors = ErrorLimits { delta_e: arguments.max_delta_e, relative: None };
    let limits = FitLimits { error: None, trusted: arguments.trust_fit };
    let of_sources = check_sources(&asset.about, &reliability, limits, errors);
    let of_sources = of_sources
        .into_iter()
        .filter_map(|(name, gate): (String, GateResult)| failed(&[gate]).map(|text| format!("{name}: {text}")));
    let missed = missed.filter(|_| arguments.max_delta_e.is_some()).map(|text| format!("--max-delta-e: {text}"));
    let missed = missed.into_iter().chain(of_sources).reduce(|all, next| format!("{all}; {next}"));
    let seconds = started.elapsed().as_secs_f64();
    let text = text(&asset, &read, Some(seconds));
    print(&json_or(common, &Report { asset, read, seconds }, text))?;
    missed.map_or(Ok(()), |text| Err(Error::check(text)))
}
