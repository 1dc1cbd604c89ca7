//! The study of ways to store BTFs.

use super::arguments::Arguments;
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_flat_btf::structures::STRUCTURES;
use brdfc_source::Input;
use brdfc_studies::StudyResult;
use brdfc_studies::btf::{
    BtfAsset, BtfModel, BtfRow, BtfSettings, BtfStudy, BtfStudyError, PARTS, drawing, held_out, study_structure,
};
use brdfc_terminal::directions::{default_set, direction_set};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Texels per side of both BTFs.
const TEXELS: usize = 32;
const MAX_TEXELS: usize = 256;
/// Minimum time between progress messages.
const BETWEEN_REMARKS: Duration = Duration::from_secs(5);

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let texels = arguments.texels.unwrap_or(TEXELS);
    if !(8..=MAX_TEXELS).contains(&texels) || !texels.is_power_of_two() {
        return Err(Error::usage(format!("--texels: found {texels}, expected a power of two from 8 to {MAX_TEXELS}")));
    }
    let set = direction_set("directions", arguments.directions.as_ref().unwrap_or(&default_set()))?;
    let held_out = held_out(set.len()).map_err(|error| Error::usage(format!("--directions: {error}")))?;
    let settings = BtfSettings { texels, directions: set.name.clone(), count: set.len(), held_out };
    let all: Vec<Input> =
        STRUCTURES.iter().map(|info| Input::Address(format!("{SYNTH_PREFIX}{}", info.name))).collect();
    let inputs = if arguments.inputs.is_empty() { &all } else { &arguments.inputs };
    // Check all names before the work, so that a wrong one is reported immediately.
    let addresses = inputs.iter().map(address).collect::<Result<Vec<_>, _>>()?;
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let steps = inputs.len() * set.len() * PARTS;
    let started = Instant::now();
    let (so_far, last_remark) = (Cell::new(0), Cell::new(started));
    let done = |parts: usize| {
        so_far.set(so_far.get() + parts);
        if last_remark.get().elapsed() >= BETWEEN_REMARKS {
            let (elapsed, share) = (started.elapsed().as_secs_f64(), so_far.get() as f64 / steps as f64);
            let left = elapsed / share * (1.0 - share);
            remark(common, &format!("{:.0} %, {elapsed:.0} s, about {left:.0} s left", 100.0 * share));
            last_remark.set(Instant::now());
        }
    };
    let mut models = Vec::new();
    for (input, address) in inputs.iter().zip(addresses) {
        let model = study_structure(address, &settings, &set, &done).map_err(|error| match error {
            BtfStudyError::Address(error) => Error::input(format!("{input}: {error}")),
            BtfStudyError::Parameterise(error) => Error::input(format!("{input}: {error}")),
            BtfStudyError::Format(error) => Error::usage(format!("--directions: {error}")),
        })?;
        models.push(model);
    }
    let study = BtfStudy { settings, models };
    if let Some(folder) = &arguments.out {
        let drawn = drawing(&study).map_err(Error::internal)?;
        write_file(&folder.join("btf.svg"), drawn.as_bytes())?;
    }
    Ok(StudyResult::Btf(study))
}

/// The structure named by an input.
fn address(input: &Input) -> Result<&str, Error> {
    input.address().and_then(|address| address.strip_prefix(SYNTH_PREFIX)).ok_or_else(|| {
        let names: Vec<&str> = STRUCTURES.iter().map(|info| info.name).collect();
        Error::usage(format!("INPUT: found {input}, expected synth: with one of {}", names.join(", ")))
    })
}

pub(super) fn text(study: &BtfStudy) -> String {
    let settings = &study.settings;
    let mut text = format!(
        "{0} x {0} texels, {1} views and lights ({2}), {3} of the lights held out of all fits\n",
        settings.texels,
        settings.count,
        settings.directions,
        settings.held_out.len()
    );
    for model in &study.models {
        for (kind, asset) in [("ordinary BTF", &model.classic), ("flat BTF", &model.flat)] {
            text += &format!("\n{}, {kind}, {} of it visible\n\n{}", model.model, percent(asset.seen), table(asset));
        }
        text += &format!("\n{}", claims(model));
    }
    text
}

fn table(asset: &BtfAsset) -> String {
    let header =
        ["method", "GPU", "of PTM", "fetches", "ΔE", "ΔE held out", "dB", "dB held out", "ΔE new texels", "seconds"];
    let cells = |row: &BtfRow| {
        let missed = if row.met == Some(false) { " (missed)" } else { "" };
        vec![
            format!("{}{missed}", row.method),
            bytes(row.bytes),
            format!("{:.1} %", 100.0 * row.share),
            format!("{:.1}", row.fetches),
            format!("{:.2}", row.delta_e),
            format!("{:.2}", row.held_out_delta_e),
            format!("{:.1}", row.psnr),
            format!("{:.1}", row.held_out_psnr),
            row.held_out_texels_delta_e.map_or("-".to_owned(), |error| format!("{error:.2}")),
            format!("{:.1}", row.seconds),
        ]
    };
    plain(&header, asset.rows.iter().map(cells))
}

fn claims(model: &BtfModel) -> String {
    let claims = &model.claims;
    let label = |met: bool| if met { "met" } else { "missed" };
    format!(
        "PWT at PTM's ΔE, ordinary BTF: {:.1} % of PTM's bytes; target at most 50 %: {}\n\
         PWT at PTM's ΔE, flat BTF: {:.1} % of those of the ordinary BTF; target at most 50 %: {}\n",
        100.0 * claims.classic_share,
        label(claims.classic_met),
        100.0 * claims.flat_share,
        label(claims.flat_met)
    )
}
