//! The study of rays.

use super::arguments::Arguments;
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_studies::StudyResult;
use brdfc_studies::rays::{Dump, RayScene, RayStudy, RayStudyError};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{percent, plain};
use brdfc_terminal::{Common, Error};
use std::path::Path;

const BUTTON: &str = "synth:button";
/// Texels per side.
const TEXELS: std::ops::RangeInclusive<usize> = 1..=512;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let input = match &arguments.inputs[..] {
        [] => &BUTTON.into(),
        [one] => one,
        more => return Err(Error::usage(format!("INPUT: found {}, expected one with this study", more.len()))),
    };
    let Some(address) = input.address().and_then(|address| address.strip_prefix(SYNTH_PREFIX)) else {
        return Err(Error::usage(format!("INPUT: found {input}, expected synth: and a structure with --study rays")));
    };
    let texels = arguments.texels.unwrap_or(64);
    if !TEXELS.contains(&texels) {
        let allowed = format!("expected {} to {}", TEXELS.start(), TEXELS.end());
        return Err(Error::usage(format!("--texels: found {texels}, {allowed}")));
    }
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let scene = RayScene::new(address, texels).map_err(|error| match error {
        RayStudyError::Address(error) => Error::input(format!("{input}: {error}")),
        RayStudyError::Parameterise(error) => Error::internal(error.to_string()),
    })?;
    let Some(folder) = &arguments.out else { return Ok(StudyResult::Rays(scene.measure(None))) };
    let dump = scene.dump().map_err(|error| Error::input(format!("{input}: {error}")))?;
    write_dump(&dump, folder)?;
    remark(common, &format!("{}: mesh.ply and rays.bin written", folder.display()));
    Ok(StudyResult::Rays(scene.measure(Some(&dump))))
}

fn write_dump(dump: &Dump, folder: &Path) -> Result<(), Error> {
    write_file(&folder.join("mesh.ply"), &dump.ply())?;
    write_file(&folder.join("rays.bin"), &dump.rays())
}

pub(super) fn text(study: &RayStudy) -> String {
    let all = format!("{} threads", study.threads);
    let header = ["query", "rays", "hits", "tiles", "1 thread", &all, "repeated, 1", "repeated"];
    let rows: Vec<Vec<String>> = study
        .rows
        .iter()
        .map(|row| {
            let mega = |rate: Option<f64>| rate.map_or("-".to_owned(), |rate| format!("{:.2}", rate / 1e6));
            let mut cells = vec![row.query.to_owned(), row.rays.to_string(), percent(row.hits)];
            cells.push(format!("{:.2}", row.tiles));
            cells.extend([Some(row.one), Some(row.all), row.repeated_one, row.repeated_all].map(mega));
            cells
        })
        .collect();
    plain(&header, &rows)
        + &format!(
            "\nMillions of rays per second. {}: {} triangles, {2} x {2} texels; tiles: per ray, mean.\n\
             repeated: with --out, against the mesh of the dump, without traversal of tiles.\n",
            study.model, study.triangles, study.texels
        )
}
