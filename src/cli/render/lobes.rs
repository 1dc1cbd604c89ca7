//! Renderings of materials that an environment lights, by lobes.

use super::arguments::Arguments;
use super::asset::name_of;
use super::light::{Light, Lit, fitted};
use super::materials::{Subject, pack_flag};
use super::{gpu, outputs, scene};
use crate::output::{self, note_gaps};
use crate::reading::open_read;
use crate::{Common, Error};
use brdfc::lobes::{LobesPack, LobesRecipe};
use brdfc::render::{Verification, Views};
use brdfc::{Input, Material};

/// Draws lobes with the shader and on the CPU, and the integral over the environment if the source is known.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
    pack: Option<LobesPack>,
) -> Result<(Verification, Views), Error> {
    let mut setup = scene::setup(arguments, subject)?;
    let gpu = gpu::open(arguments)?;
    let light = Light::of(arguments, subject, &mut setup.scene, common)?;
    // Without a pack for point lights, mirrors would take light away and reflect none.
    setup.scene.parts.iter_mut().for_each(|part| part.surface.mirror = 0.0);
    let read = |input: &Input| open_read(input, arguments.reading);
    let (pack, source) = match (pack, &arguments.source) {
        (Some(pack), source) => (pack, source.as_ref().map(read).transpose()?),
        // The input is a material, and its own reference.
        (None, None) => {
            let material = read(input)?;
            (fitted(input, material.source(), &LobesRecipe::default(), common)?, Some(material))
        }
        (None, Some(_)) => {
            return Err(Error::usage(format!("{input}: --source needs a pack of lobes; a material is its own source")));
        }
    };
    if let Some(material) = &source {
        note_gaps(common, arguments.source.as_ref().unwrap_or(input), material.source());
    }
    let name = name_of(input);
    let materials = [Lit { name: &name, lobes: Some(&pack), source: source.as_ref().map(Material::source) }];
    let of_parts = vec![0; setup.scene.parts.len()];
    let views = light.views(arguments, &setup, &gpu, (&materials, &of_parts), common)?;
    let mut verification = setup.verification(&gpu, &views, |_| (name.clone(), pack.gpu_bytes()));
    verification.environment_bytes_on_gpu = Some(light.gpu_bytes());
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Rejects flags that do not apply to renderings by lobes.
pub(super) fn refuse_flags(arguments: &Arguments, input: &Input) -> Result<(), Error> {
    let of = "renderings with point lights";
    let option = arguments.options.first().map(pack_flag);
    let flags = [
        (arguments.packs.is_some(), "--packs", of),
        (arguments.table, "--table", of),
        (arguments.lod.is_some(), "--lod", of),
        (arguments.filter.is_some(), "--filter", of),
        (arguments.exact, "--exact", of),
        (arguments.repeat.is_some(), "--repeat", "flat BTFs"),
        (option.is_some(), option.as_deref().unwrap_or_default(), of),
        (arguments.contact.is_some(), "--contact", of),
        (arguments.adaptive.adaptive, "--adaptive", "materials and packs of BRDFs"),
    ];
    output::refuse_flags(format!("{input}, lit by an environment"), &flags)
}
