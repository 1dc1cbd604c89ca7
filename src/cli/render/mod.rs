//! `brdfc render`: draws packs with the shaders that engines use, and measures the error.

mod adaptive;
mod adaptive_options;
mod arguments;
mod asset;
mod contact;
mod flat;
mod gpu;
mod light;
mod lobes;
mod materials;
mod outputs;
mod pwt;
mod scene;
mod textures;

pub use adaptive::Report as AdaptiveReport;
pub use arguments::Arguments;
pub use contact::Report as ContactReport;

use super::output::{note, print, print_json, remark};
use super::{Common, Error, graphics_environment};
use crate::inputs::refuse_stdin_twice;
use crate::table;
use asset::{Asset, AssetKind};
use brdfc::render::{RenderingGates, Verification, Views};
use brdfc_terminal::words::{format_number, join_truncated};
use light::{Light, lit_views};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// Maximum number of materials in a line.
const MAX_LISTED: usize = 6;

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Settings and measurements.
    #[serde(flatten)]
    verification: Verification,
    /// Seconds from the start to the last image, encoding included.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    graphics_environment::prepare();
    let started = Instant::now();
    let environment = arguments.adaptive.environment.as_ref();
    let inputs = [
        ("INPUT", Some(&arguments.input)),
        ("--source", arguments.source.as_ref()),
        ("--environment", environment),
        ("--texture", arguments.adaptive.texture.as_ref()),
    ];
    refuse_stdin_twice(&inputs)?;
    outputs::check(arguments)?;
    let gates = gates(arguments)?;
    if let Some(level) = arguments.lod
        && !(0.0..=6.0).contains(&level)
    {
        return Err(Error::wrong_usage("--lod", format_number(level), "0 to 6"));
    }
    let asset = asset::asset(arguments)?;
    if let Some(asset) = &asset {
        asset::refuse_flags(arguments, asset)?;
        // A pack of lobes has no reference without a source.
        match &asset.kind {
            AssetKind::Lobes(pack) if pack.is_none() || arguments.source.is_some() => {}
            _ => refuse_truth(arguments)?,
        }
    }
    if !matches!(&asset, Some(Asset { kind: AssetKind::Pwt(_), .. }) if arguments.source.is_some()) {
        arguments.images.refuse("renderings without photographs as the --source")?;
    }
    if arguments.adaptive.adaptive {
        return adaptive::run(arguments, common);
    }
    if let Some(path) = &arguments.contact {
        return contact::run(arguments, path, &gates, started, common);
    }
    let (verification, views) = match asset {
        Some(Asset { input, subject, kind: AssetKind::Pwt(pack) }) => {
            pwt::verification(arguments, common, &input, &subject, *pack)?
        }
        Some(Asset { input, subject, kind: AssetKind::Lobes(pack) }) => {
            lobes::verification(arguments, common, &input, &subject, pack.map(|pack| *pack))?
        }
        Some(Asset { input, subject, kind: AssetKind::Flat }) => {
            flat::verification(arguments, common, &input, &subject)?
        }
        None => of_brdfs(arguments, common)?,
    };
    let verification = verification.checked_by(&gates, &views);
    if let Some(nothing) = verification.nothing_seen(&views) {
        note(common, &arguments.input, &format!("the rendering shows {nothing}{}", hint(arguments)));
    }
    if verification.left_out > 0.0 {
        let share = table::percent(verification.left_out);
        let why = "their packs do not cover the directions (view_elevation, light_elevation)";
        remark(common, &format!("excluded {share} of the surfaces: {why}"));
    }
    drop(views);
    let seconds = started.elapsed().as_secs_f64();
    let closed: Vec<String> = verification.gates.iter().filter(|gate| !gate.passed).map(ToString::to_string).collect();
    if common.json {
        print_json(&Report { version: 1, verification, seconds })?;
    } else {
        print(&outputs::text(&verification))?;
        remark(common, &format!("{seconds:.1} s"));
    }
    if closed.is_empty() { Ok(()) } else { Err(Error::check(closed.join("; "))) }
}

/// Rejects samples of a reference that is not an integral over an environment.
fn refuse_truth(arguments: &Arguments) -> Result<(), Error> {
    if arguments.adaptive.truth.is_some() && !arguments.adaptive.adaptive {
        let text =
            "--truth needs --adaptive, an environment in [scene], or --environment with a material or a --source";
        return Err(Error::usage(text));
    }
    Ok(())
}

/// Resolves the limits of the rendering.
fn gates(arguments: &Arguments) -> Result<RenderingGates, Error> {
    let given = [
        ("--max-delta-e", arguments.max_delta_e, f64::MAX, "a number, 0 or more"),
        ("--max-delta-e-p95", arguments.max_delta_e_p95, f64::MAX, "a number, 0 or more"),
        ("--max-flip", arguments.max_flip, 1.0, "0 to 1"),
    ];
    for (flag, limit, most, allowed) in given {
        if let Some(limit) = limit.filter(|limit| !(0.0..=most).contains(limit)) {
            return Err(Error::wrong_usage(flag, format_number(limit), allowed));
        }
    }
    let [delta_e, delta_e_p95, flip] = given.map(|(_, limit, ..)| limit);
    Ok(RenderingGates { delta_e, delta_e_p95, flip })
}

/// Hint for a rendering that shows nothing.
fn hint(arguments: &Arguments) -> &'static str {
    let extension = arguments.input.path().and_then(Path::extension);
    let of_manifest = extension.is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    if of_manifest { "; check render.camera, render.lights and the environment" } else { "" }
}

/// Draws packs of BRDFs under point lights, and adds the light of an environment by their lobes.
fn of_brdfs(arguments: &Arguments, common: Common) -> Result<(Verification, Views), Error> {
    flat::refuse_flags(arguments)?;
    let subject = materials::subject(arguments)?;
    let mut setup = scene::setup(arguments, &subject)?;
    if !subject.has_lobes(&setup.names) {
        refuse_truth(arguments)?;
    }
    // The adapter and the environment first: without them, encoding would be wasted.
    let gpu = gpu::open(arguments)?;
    let light = Light::of_scene(arguments, &subject, &setup.names, &mut setup.scene, common)?;
    let prepared = materials::prepare(arguments, &subject, &setup.names, common)?;

    let of_part = |name: &String| prepared.iter().position(|p| p.name == *name).expect("every name was prepared");
    let of_parts: Vec<usize> = setup.names.iter().map(of_part).collect();
    let decoding = gpu::decoding(arguments, &subject);
    let views = lit_views(arguments, &subject, &setup, &gpu, (&prepared, &of_parts, decoding), light.as_ref(), common)?;
    let of_part = |number: usize| {
        let material = &prepared[of_parts[number]];
        (material.name.clone(), material.gpu_bytes())
    };
    let mut verification = setup.verification(&gpu, &views, of_part);
    verification.environment_bytes_on_gpu = light.as_ref().map(Light::gpu_bytes);
    outputs::write(arguments, &views, verification.exposure)?;
    tell_of_others(arguments, &scene::materials_in_turn(arguments, &subject)?, &setup.names, common);
    Ok((verification, views))
}

/// Prints the materials of a scene that its rendering does not show.
fn tell_of_others(arguments: &Arguments, all: &[String], shown: &[String], common: Common) {
    let others: Vec<&str> = all.iter().filter(|name| !shown.contains(name)).map(String::as_str).collect();
    if !others.is_empty() {
        let listed = join_truncated(&others, MAX_LISTED);
        note(common, &arguments.input, &format!("not drawn: {listed}; --contact draws every material"));
    }
}
