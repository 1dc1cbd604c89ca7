//! Renderings of materials that an environment lights, by lobes.

use super::arguments::Arguments;
use super::asset::name_of;
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::{self, note, note_repairs, remark};
use crate::progress::Materials;
use crate::{Common, Error};
use brdfc::environment::{self, EnvironmentPack};
use brdfc::lobes::{DEFAULT_DELTA_E, LobesPack, LobesRecipe, encode};
use brdfc::render::{
    Environment, LobesMaterial, Verification, Views, draw_lobes, draw_lobes_integral, draw_lobes_on_cpu, unfiltered,
};
use brdfc::{Input, Material, Progress as _};
use std::path::Path;

/// Directions of the integral for each pixel, by default.
const TRUTH: usize = 256;

/// Draws lobes with the shader and on the CPU, and the integral over the environment if the source is known.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
    pack: Option<LobesPack>,
) -> Result<(Verification, Views), Error> {
    let file = arguments.adaptive.environment.as_deref();
    let mut setup = scene::setup(arguments, subject)?;
    let gpu = gpu::open(arguments)?;
    let environment = prefiltered(file, &setup.scene.environment, common)?;
    let (pack, source) = match (pack, &arguments.source) {
        (Some(pack), source) => (pack, source.as_ref().map(brdfc::open).transpose()?),
        // The input is a material, and its own reference.
        (None, None) => {
            let material = brdfc::open(input)?;
            (encoded(input, &material, common)?, Some(material))
        }
        (None, Some(_)) => {
            return Err(Error::usage(format!("{input}: --source needs a pack of lobes; a material is its own source")));
        }
    };
    let bytes_on_gpu = pack.gpu_bytes() + environment.gpu_bytes();
    let material = LobesMaterial::new(pack, environment);
    let shader = draw_lobes(&gpu, &setup.scene, setup.frame, &material)?;
    let pack = draw_lobes_on_cpu(&setup.scene, setup.frame, &material);
    let source = match &source {
        Some(source) => {
            if file.is_some_and(scene::is_prefiltered) {
                setup.scene.environment = unfiltered(material.environment());
            }
            let by_default = TRUTH.div_ceil(setup.frame.samples * setup.frame.samples);
            let samples = arguments.adaptive.truth.unwrap_or(by_default).next_multiple_of(16);
            remark(
                common,
                &format!("the integral over the environment: {samples} directions for each sample, on the CPU"),
            );
            Some(draw_lobes_integral(&setup.scene, setup.frame, source, samples)?)
        }
        None => None,
    };
    let views = Views { shader, pack, table: None, source, left_out: 0.0 };
    let verification = setup.verification(&gpu, &views, |_| (name_of(input), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Opens a prefiltered environment, or prefilters the environment of the scene, which was read from the file, or is the
/// scene's sky.
fn prefiltered(file: Option<&Path>, image: &Environment, common: Common) -> Result<EnvironmentPack, Error> {
    if let Some(file) = file.filter(|file| scene::is_prefiltered(file)) {
        return environment::open(&Input::from(file), &());
    }
    let progress = Materials::new(1, false, common);
    environment::prefilter(image, None, progress.part("environment").as_ref())
}

fn encoded(input: &Input, material: &Material, common: Common) -> Result<LobesPack, Error> {
    let progress = Materials::new(1, false, common);
    let encoded = encode(material, &LobesRecipe::default(), progress.part(&name_of(input)).as_ref());
    let encoded = encoded.map_err(|error| error.prefixed(input))?;
    let best = encoded.best();
    note_repairs(common, input, &encoded.tally);
    if !best.meets {
        let (error, fetches) = (best.error.mean, best.pack.fetches());
        note(common, input, &format!("{fetches} look-ups have a mean ΔE of {error:.2}, more than {DEFAULT_DELTA_E}"));
    }
    Ok(best.pack.clone())
}

/// Rejects flags that do not apply to renderings by lobes.
pub(super) fn refuse_flags(arguments: &Arguments, input: &Input) -> Result<(), Error> {
    let of = "renderings with point lights";
    let flags = [
        (arguments.packs.is_some(), "--packs", of),
        (arguments.table, "--table", of),
        (arguments.lod.is_some(), "--lod", of),
        (arguments.filter.is_some(), "--filter", of),
        (arguments.exact, "--exact", of),
        (arguments.repeat.is_some(), "--repeat", "flat BTFs"),
        (arguments.options.any(), "an encoding option", of),
        (arguments.contact.is_some(), "--contact", of),
        (arguments.adaptive.adaptive, "--adaptive", "materials and packs of BRDFs"),
    ];
    output::refuse_flags(format!("{input}, lit by an environment"), &flags)
}
