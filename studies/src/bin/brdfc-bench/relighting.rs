//! The study of photographs under known lights.

use super::arguments::Arguments;
use brdfc_jobs::pwt::LightInput;
use brdfc_pwt::LightSamples;
use brdfc_render::rendering::to_png;
use brdfc_source::Input;
use brdfc_studies::StudyResult;
use brdfc_studies::relighting::{
    PLANES, RelightingRow, RelightingStudy, Stack, TREE, component_names, relighting, relit,
};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::plain;
use brdfc_terminal::{Common, Error};
use std::path::Path;

/// Number of held-out lights.
const HELD_OUT: usize = 8;
/// Seeds of the permutations that select them.
const SEEDS: [u64; 5] = [0, 1, 2, 3, 4];
/// Folders of stacks with a split of their own: photographs to fit, and photographs under other lights.
const OWN_SPLIT: [&str; 2] = ["Dome", "Test"];

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    if arguments.inputs.is_empty() {
        let expected = "one or more folders of photographs with an .lp, or of a Dome and a Test";
        return Err(Error::usage(format!("INPUT: found none, expected {expected}")));
    }
    let stacks = arguments.inputs.iter().map(stack).collect::<Result<Vec<_>, Error>>()?;
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let inputs = arguments.inputs.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    let with_input = |error: brdfc_formats::FormatError| Error::input(format!("{inputs}: {error}"));
    let done = |stack: &str, method: &str| remark(common, &format!("{stack}: {method}: done"));
    let study = relighting(&stacks, HELD_OUT, &SEEDS, &done).map_err(with_input)?;
    if let Some(folder) = &arguments.out {
        for (k, stack) in stacks.iter().enumerate() {
            let rendering = relit(stack, HELD_OUT).map_err(with_input)?;
            let name = if k == 0 { "relighting.png".to_owned() } else { format!("relighting-{k}.png") };
            write_file(&folder.join(name), &to_png(&rendering, 1.0))?;
        }
    }
    Ok(StudyResult::Relighting(study))
}

fn stack(input: &Input) -> Result<Stack, Error> {
    let samples = |input: &Input| -> Result<LightSamples, Error> {
        let samples = LightInput::open(input, None)?.into_samples();
        Ok(samples.distant().map_err(Error::input)?.into_owned())
    };
    let name = input.to_string();
    let own = input.path().map(|path| OWN_SPLIT.map(|folder| path.join(folder)));
    match own.filter(|folders| folders.iter().all(|folder| folder.is_dir())) {
        Some([dome, test]) => {
            let open = |path: &Path| samples(&Input::from(path));
            Ok(Stack { name, samples: open(&dome)?, unseen: Some(open(&test)?) })
        }
        None => Ok(Stack { name, samples: samples(input)?, unseen: None }),
    }
}

const HEADER: [&str; 11] = [
    "method",
    "bytes/pixel",
    "fetches",
    "dB",
    "dB held out",
    "dB of images",
    "SSIM",
    "ΔE",
    "ΔE held out",
    "encode, s",
    "image, ms",
];

fn table(rows: &[RelightingRow]) -> String {
    let cells = |row: &RelightingRow| {
        vec![
            row.method.clone(),
            format!("{:.2}", row.bytes_per_pixel),
            format!("{:.1}", row.fetches),
            format!("{:.2}", row.psnr),
            format!("{:.2}", row.held_out_psnr),
            format!("{:.2}", row.held_out_image_psnr),
            format!("{:.3}", row.held_out_ssim),
            format!("{:.2}", row.delta_e),
            format!("{:.2}", row.held_out_delta_e),
            format!("{:.2}", row.seconds),
            format!("{:.1}", 1e3 * row.image_seconds),
        ]
    };
    plain(&HEADER, rows.iter().map(cells).collect::<Vec<_>>())
}

pub(super) fn text(study: &RelightingStudy) -> String {
    let mut text = String::new();
    for stack in &study.stacks {
        let [width, height] = stack.size;
        text += &format!(
            "{}: {width} x {height} pixels, {} lights, {} held out, means over {} choices\n\n{}\n",
            stack.name,
            stack.lights,
            stack.held_out,
            stack.splits,
            table(&stack.rows)
        );
    }
    text += &format!("means over {} stacks\n\n{}\n", study.stacks.len(), table(&study.means));
    text + &differences(study)
}

/// Trees against the better of the interpolations, in each column.
fn differences(study: &RelightingStudy) -> String {
    let rows = study.stacks.iter().map(|stack| {
        let find = |name: String| stack.rows.iter().find(|row| row.method == name);
        let mut cells = vec![stack.name.clone()];
        for planes in PLANES {
            let tree = find(format!("{TREE} {planes}"));
            let peers = component_names().map(|name| find(format!("{name} {planes}")));
            for column in [|row: &RelightingRow| row.psnr, |row: &RelightingRow| row.held_out_psnr] {
                let best = peers.iter().flatten().map(|row| column(row)).fold(f64::NEG_INFINITY, f64::max);
                cells.push(tree.map_or("-".to_owned(), |row| format!("{:+.2}", column(row) - best)));
            }
        }
        cells
    });
    let columns = PLANES.iter().flat_map(|planes| [format!("{planes}"), format!("{planes} held out")]);
    let header: Vec<String> = ["stack".to_owned()].into_iter().chain(columns).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    format!(
        "{TREE} against the better of both interpolations of components at equal bytes, dB\n\n{}",
        plain(&header, rows.collect::<Vec<_>>())
    )
}
