//! `brdfc render --contact`: a contact sheet with one rendering per material.

use super::arguments::Arguments;
use super::light::{Light, lit_views};
use super::{flat, gpu, materials, outputs, scene};
use crate::output::{note, print, print_json, remark, write_file};
use crate::{Common, Error};
use brdfc::render::{MaterialVerification, RenderingGates, contact_sheet, rgb_png};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Materials by name, with renderings and measurements.
    materials: Vec<MaterialVerification>,
    /// Seconds from the start to the sheet, encoding included.
    seconds: f64,
}

pub(super) fn run(
    arguments: &Arguments,
    path: &Path,
    gates: &RenderingGates,
    started: Instant,
    common: Common,
) -> Result<(), Error> {
    flat::refuse_flags(arguments)?;
    let subject = materials::subject(arguments)?;
    let mut setup = scene::setup(arguments, &subject)?;
    let names = scene::materials_in_turn(arguments, &subject)?;
    if !subject.has_lobes(&names) {
        super::refuse_truth(arguments)?;
    }
    let decoding = gpu::decoding(arguments, &subject);
    let gpu = gpu::open(arguments)?;
    let light = Light::of_scene(arguments, &subject, &names, &mut setup.scene, common)?;
    let of_parts = vec![0; setup.scene.parts.len()];
    let (mut cells, mut drawn) = (Vec::new(), Vec::new());
    // One material at a time, because sources and packs of all materials may not fit into memory.
    for (number, name) in names.iter().enumerate() {
        let prepared = materials::prepare(arguments, &subject, std::slice::from_ref(name), common)?;
        let views =
            lit_views(arguments, &subject, &setup, &gpu, (&prepared, &of_parts, decoding), light.as_ref(), common)?;
        let bytes_on_gpu = prepared[0].gpu_bytes();
        let mut verification = setup.verification(&gpu, &views, |_| (name.clone(), bytes_on_gpu));
        verification.environment_bytes_on_gpu = light.as_ref().map(Light::gpu_bytes);
        let verification = verification.checked_by(gates, &views);
        if let Some(nothing) = verification.nothing_seen(&views) {
            note(common, name, &format!("the rendering shows {nothing}"));
        }
        let material = MaterialVerification { material: name.clone(), bytes_on_gpu, verification };
        cells.push(material.cell(&views));
        drawn.push(material);
        remark(common, &format!("{} of {}: {name} drawn", number + 1, names.len()));
    }
    write_file(path, &rgb_png(&contact_sheet(&cells)))?;
    let seconds = started.elapsed().as_secs_f64();
    let failures: Vec<String> = drawn.iter().flat_map(MaterialVerification::closed).collect();
    if common.json {
        print_json(&Report { version: 1, materials: drawn, seconds })?;
    } else {
        print(&outputs::contact_text(&drawn))?;
        remark(common, &format!("{seconds:.1} s"));
    }
    if failures.is_empty() { Ok(()) } else { Err(Error::check(failures.join("; "))) }
}
