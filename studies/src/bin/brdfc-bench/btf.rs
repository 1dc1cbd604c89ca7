//! The study of ways to store BTFs.

use super::arguments::Arguments;
use super::remarks::Remarks;
use super::structures::structures;
use brdfc_studies::StudyResult;
use brdfc_studies::btf::{
    BtfAsset, BtfModel, BtfRow, BtfSettings, BtfStudy, BtfStudyError, PARTS, WholeBtf, drawing, held_out,
    held_out_views, study_structure,
};
use brdfc_terminal::directions::{default_set, direction_set};
use brdfc_terminal::output::{make_folder, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};

/// Texels per side of both BTFs.
const TEXELS: usize = 32;
const MAX_TEXELS: usize = 256;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let texels = arguments.power_of_two_texels(TEXELS, MAX_TEXELS)?;
    let set = direction_set("directions", arguments.directions.as_ref().unwrap_or(&default_set()))?;
    let wrong = |error| Error::usage(format!("--directions: {error}"));
    let (held_out, held_out_views) = (held_out(set.len()).map_err(wrong)?, held_out_views(set.len()).map_err(wrong)?);
    let settings = BtfSettings { texels, directions: set.name.clone(), count: set.len(), held_out, held_out_views };
    let structures = structures(arguments)?;
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let remarks = Remarks::new(common, structures.len() * set.len() * PARTS);
    let mut models = Vec::new();
    for (input, address) in structures {
        let done = |parts| remarks.done(parts);
        let model = study_structure(&address, &settings, &set, &done).map_err(|error| match error {
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
        text += &format!("\n{}, all views of the ordinary BTF, some held out\n\n{}", model.model, whole(&model.whole));
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

/// Methods that store all views, and levels of the trees.
fn whole(btf: &WholeBtf) -> String {
    let rows = btf.rows.iter().map(|row| {
        let decibels = [row.psnr, row.held_out_lights_psnr, row.held_out_views_psnr, row.held_out_both_psnr];
        let decibels = decibels.map(|psnr| format!("{psnr:.2}"));
        let ends = [row.method.clone(), bytes(row.budget), bytes(row.bytes)];
        ends.into_iter().chain(decibels).chain([format!("{:.2}", row.held_out_both_delta_e)]).collect::<Vec<_>>()
    });
    let header = ["method", "at most", "GPU", "dB", "dB lights", "dB views", "dB both", "ΔE both"];
    let levels = btf
        .mipmaps
        .iter()
        .map(|row| vec![row.level.to_string(), format!("{:.2}", row.psnr), format!("{:.2}", row.box_psnr)]);
    format!("{}\n{}", plain(&header, rows), plain(&["level", "trees, dB", "filtered images, dB"], levels))
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
