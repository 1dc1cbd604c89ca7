//! The study of run time and error.

use super::arguments::Arguments;
use brdfc_source::Input;
use brdfc_source::open::open;
use brdfc_studies::StudyResult;
use brdfc_studies::pareto::{ParetoMaterial, ParetoRow, ParetoStudy, drawing, pareto, settings};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// A glossy plastic, a velvet, a brushed metal.
const MODELS: [&str; 3] = ["synth:ggx?alpha=0.15", "synth:velvet", "synth:ward?ax=0.15&ay=0.5"];
/// Minimum time between progress messages.
const BETWEEN_REMARKS: Duration = Duration::from_secs(5);

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let models = MODELS.map(Input::from);
    let inputs = if arguments.inputs.is_empty() { &models[..] } else { &arguments.inputs };
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let settings = settings(arguments.small);
    let started = Instant::now();
    let last_remark = Cell::new(Instant::now());
    let mut materials = Vec::new();
    for (number, input) in inputs.iter().enumerate() {
        let opened = open(input, None)?;
        let name = input.short_name();
        let done = |share: f64| {
            if last_remark.get().elapsed() < BETWEEN_REMARKS && share < 1.0 {
                return;
            }
            last_remark.set(Instant::now());
            let seconds = started.elapsed().as_secs_f64();
            let left = seconds / (number as f64 + share) * (inputs.len() as f64 - number as f64 - share);
            let (at, all, percent) = (number + 1, inputs.len(), 100.0 * share);
            remark(common, &format!("{at} of {all}: {name}, {percent:.0} %, {seconds:.0} s, about {left:.0} s left"));
        };
        materials.push(pareto(&name, opened.source.as_ref(), &settings, &done)?);
    }
    let study = ParetoStudy { threads: rayon::current_num_threads(), materials };
    if let Some(folder) = &arguments.out {
        let drawn = drawing(&study).map_err(Error::internal)?;
        write_file(&folder.join("pareto.svg"), drawn.as_bytes())?;
    }
    Ok(StudyResult::Pareto(study))
}

pub(super) fn text(study: &ParetoStudy) -> String {
    let mut text: String = study.materials.iter().map(material_text).collect();
    text += &format!(
        "Rows on the Pareto front of bytes on a GPU and mean ΔE, or of seconds of encoding and mean ΔE; --json has \
         all.\nEncoding: from the opened source to the file, on {} threads, without measuring errors; once, or the shortest \
         of up to three\nif that takes less than half a second. Decoding: millions of evaluations per second of one CPU \
         thread.\n",
        study.threads
    );
    text
}

fn material_text(material: &ParetoMaterial) -> String {
    let on_front = |row: &&ParetoRow| row.on_bytes_front || row.on_seconds_front;
    let mut rows: Vec<&ParetoRow> = material.rows.iter().filter(on_front).collect();
    rows.sort_by(|a, b| a.bytes_on_gpu.cmp(&b.bytes_on_gpu).then(b.delta_e.total_cmp(&a.delta_e)));
    let cells = |row: &&ParetoRow| {
        let front = match (row.on_bytes_front, row.on_seconds_front) {
            (true, true) => "both",
            (true, false) => "bytes",
            _ => "seconds",
        };
        vec![
            row.codec.clone(),
            row.setting.clone(),
            bytes(row.bytes_on_gpu),
            bytes(row.bytes_on_disk),
            row.fetches.to_string(),
            format!("{:.1} ms", 1e3 * row.encode_seconds),
            format!("{:.2}", row.decode_rate / 1e6),
            percent(row.relative_error),
            format!("{:.3}", row.delta_e),
            format!("{:.2}", row.delta_e_p95),
            front.to_owned(),
        ]
    };
    let header = [
        &material.material,
        "setting",
        "on GPU",
        "on disk",
        "fetches",
        "encode",
        "decode",
        "ε_r",
        "ΔE",
        "95 %",
        "front of",
    ];
    let shown: Vec<Vec<String>> = rows.iter().map(cells).collect();
    plain(&header, &shown) + &format!("{} of {} settings\n\n", rows.len(), material.rows.len())
}
