//! The study of photographs under known lights.

use super::arguments::Arguments;
use brdfc_jobs::pwt::LightInput;
use brdfc_render::rendering::to_png;
use brdfc_studies::StudyResult;
use brdfc_studies::relighting::{RelightingStudy, relighting, relit};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};

/// Number of held-out lights.
const HELD_OUT: usize = 8;
/// Seeds of the permutations that select them.
const SEEDS: [u64; 5] = [0, 1, 2, 3, 4];

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let [input] = &arguments.inputs[..] else {
        let found = arguments.inputs.len();
        return Err(Error::usage(format!("INPUT: found {found}, expected one: a folder of photographs with an .lp")));
    };
    let samples = LightInput::open(input, None)?.into_samples();
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let with_input = |error: brdfc_formats::FormatError| Error::input(format!("{input}: {error}"));
    let done = |method: &str| remark(common, &format!("{method}: done"));
    let study = relighting(&samples, HELD_OUT, &SEEDS, &done).map_err(with_input)?;
    if let Some(folder) = &arguments.out {
        let rendering = relit(&samples, HELD_OUT).map_err(with_input)?;
        write_file(&folder.join("relighting.png"), &to_png(&rendering, 1.0))?;
    }
    Ok(StudyResult::Relighting(study))
}

pub(super) fn text(study: &RelightingStudy) -> String {
    let rows: Vec<Vec<String>> = study
        .rows
        .iter()
        .map(|row| {
            vec![
                row.method.clone(),
                bytes(row.bytes.round() as u64),
                percent(row.share),
                format!("{:.1}", row.fetches),
                format!("{:.1}", row.psnr),
                format!("{:.1}", row.held_out_psnr),
                format!("{:.2}", row.delta_e),
                format!("{:.2}", row.held_out_delta_e),
                format!("{:.2}", row.seconds),
            ]
        })
        .collect();
    let settings = &study.settings;
    let [width, height] = settings.size;
    let header = ["method", "GPU", "of PTM", "fetches", "dB", "dB held out", "ΔE", "ΔE held out", "seconds"];
    format!(
        "{width} x {height} pixels, {} lights, {} of them held out, means over {} choices\n\n{}",
        settings.lights,
        settings.held_out,
        settings.seeds.len(),
        plain(&header, &rows)
    )
}
