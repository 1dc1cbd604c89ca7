//! Studies that need a graphics adapter.

use super::arguments::Arguments;
use brdfc_formats::BrdfPack;
use brdfc_gpu::{AdapterChoice, AdapterDescription, Gpu};
use brdfc_jobs::encode::PackRecipe;
use brdfc_jobs::encode::encode as encode_pack;
use brdfc_render::rendering::to_png;
use brdfc_source::Input;
use brdfc_source::open::open;
use brdfc_source::pack::open_brdf_pack;
use brdfc_studies::images::{Drawn, ImageRow, PAPER_MEAN, PAPER_SIGMA, StudyError, on_the_cloth};
use brdfc_studies::level_of_detail::{Animation, LevelOfDetail, level_of_detail};
use brdfc_studies::throughput::{Throughput, throughput};
use brdfc_studies::{Study, StudyResult};
use brdfc_table::recipe::TableRecipe;
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, plain};
use brdfc_terminal::{Common, Error, graphics_environment};
use brdfc_wavelet::recipe::Recipe;
use std::path::Path;
use std::time::Instant;

/// Anisotropic and soft, as the paper's velvet.
pub(super) const VELVET: &str = "synth:velvet?kd=0.1,0.01,0.02&ks=0.5,0.3,0.35";
/// Sharp enough to glitter.
pub(super) const GLOSSY: &str = "synth:ggx?kd=0.05,0.04,0.03&f0=0.9,0.8,0.6&alpha=0.1";

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let gpu = opened_adapter(arguments)?;
    let started = Instant::now();
    let seconds = || started.elapsed().as_secs_f64();
    match arguments.study {
        Study::Throughput => {
            let packs = packs(&one(arguments, VELVET)?)?;
            let progress = |done, all| remark(common, &format!("{done} of {all} rows, {:.1} s", seconds()));
            Ok(StudyResult::Throughput(throughput(&gpu, &packs, progress)?))
        }
        Study::LevelOfDetail => {
            let pack = pack(&one(arguments, GLOSSY)?)?;
            let progress = |what: &str| remark(common, &format!("{what}, {:.1} s", seconds()));
            if let Some(folder) = &arguments.out {
                make_folder(folder)?;
            }
            let (result, animation) = level_of_detail(&gpu, &pack, arguments.small, progress)?;
            if let Some(folder) = &arguments.out {
                write_frames(folder, &animation)?;
            }
            Ok(StudyResult::LevelOfDetail(result))
        }
        _ => {
            let velvet = [VELVET.into()];
            let inputs = if arguments.inputs.is_empty() { &velvet[..] } else { &arguments.inputs };
            let mut rows = Vec::new();
            if let Some(folder) = &arguments.out {
                make_folder(folder)?;
            }
            for (number, input) in inputs.iter().enumerate() {
                let opened = open(input, None)?;
                let name = input.short_name();
                let (row, drawn) = on_the_cloth(&gpu, &name, opened.source.as_ref()).map_err(study_error)?;
                rows.push(row);
                if let Some(folder) = &arguments.out {
                    write_drawn(folder, number + 1, &drawn)?;
                }
                let left = seconds() / (number + 1) as f64 * (inputs.len() - number - 1) as f64;
                let done =
                    format!("{} of {}: {name}, {:.1} s, about {left:.0} s left", number + 1, inputs.len(), seconds());
                remark(common, &done);
            }
            Ok(StudyResult::Images { rows })
        }
    }
}

/// The requested adapter.
pub(super) fn opened_adapter(arguments: &Arguments) -> Result<Gpu, Error> {
    graphics_environment::prepare();
    let choice = arguments.adapter.clone().map_or(AdapterChoice::Best, AdapterChoice::Named);
    Ok(Gpu::open(&choice)?)
}

fn study_error(error: StudyError) -> Error {
    match error {
        StudyError::Gpu(error) => error.into(),
        StudyError::Encode(error) => error.into(),
    }
}

fn one(arguments: &Arguments, default: &str) -> Result<Input, Error> {
    match &arguments.inputs[..] {
        [] => Ok(default.into()),
        [one] => Ok(one.clone()),
        more => Err(Error::usage(format!("INPUT: found {}, expected one with this study", more.len()))),
    }
}

/// An input's pack if it has levels of detail, or the wavelet pack of a source at 4:1 and 8 bits.
fn pack(input: &Input) -> Result<BrdfPack, Error> {
    if input.extension()? == "ktx2" {
        let pack = open_brdf_pack(input)?;
        if pack.levels() == 0 {
            let found = format!("found {} with one level of detail", pack.kind().summary());
            return Err(Error::input(format!(
                "{input}: pack: {found}, expected a pack with several (encode --levels)"
            )));
        }
        return Ok(pack);
    }
    let opened = open(input, None)?;
    let recipe = Recipe { energy_preserving: true, ..Recipe::default() };
    Ok(encode_pack(opened.source.as_ref(), &PackRecipe::Wavelet(recipe).without_measuring(), &())?.pack)
}

/// An input's pack, or packs of a source: tables of 16 KiB, plain and factored, and a wavelet pack at 4:1 and 8 bits.
fn packs(input: &Input) -> Result<Vec<BrdfPack>, Error> {
    if input.extension()? == "ktx2" {
        return Ok(vec![open_brdf_pack(input)?]);
    }
    let opened = open(input, None)?;
    let table = PackRecipe::Table(TableRecipe::default().into()).without_measuring();
    let factored = TableRecipe { factored: true, ..TableRecipe::default() };
    let factored = PackRecipe::Table(factored.into()).without_measuring();
    let wavelet = PackRecipe::Wavelet(Recipe::default()).without_measuring();
    let packs = [table, factored, wavelet].map(|recipe| Ok(encode_pack(opened.source.as_ref(), &recipe, &())?.pack));
    packs.into_iter().collect()
}

fn write_frames(folder: &Path, animation: &Animation) -> Result<(), Error> {
    for (name, frames) in
        [("finest", &animation.finest), ("by-distance", &animation.by_distance), ("smooth", &animation.smooth)]
    {
        for (number, frame) in frames.iter().enumerate() {
            let path = folder.join(format!("{name}-{}.png", number + 1));
            write_file(&path, &to_png(frame, animation.exposure))?;
        }
    }
    Ok(())
}

/// Writes the renderings of material `number` on the cloth.
fn write_drawn(folder: &Path, number: usize, drawn: &Drawn) -> Result<(), Error> {
    for (name, image) in [("pack", &drawn.pack), ("pixels", &drawn.pixels), ("vertices", &drawn.vertices)] {
        write_file(&folder.join(format!("cloth-{number}-{name}.png")), &to_png(image, drawn.exposure))?;
    }
    Ok(())
}

pub(super) fn adapter(description: &AdapterDescription) -> String {
    let kind = if description.software { ", a software driver" } else { "" };
    format!("{}, {}{kind}", description.name, description.driver)
}

pub(super) fn throughput_text(result: &Throughput) -> String {
    let all = format!("CPU, {} threads", result.threads);
    let header = ["codec", "filter", "level", "fetches", "on GPU", "shader", "shader, exact", "CPU, 1 thread", &all];
    let mega = |rate: f64| format!("{:.2}", rate / 1e6);
    let has_levels = |codec: &str| result.rows.iter().any(|row| row.codec == codec && row.level > 0);
    let rows: Vec<Vec<String>> = result
        .rows
        .iter()
        .map(|row| {
            let level = if has_levels(&row.codec) { row.level.to_string() } else { "-".to_owned() };
            let mut cells = vec![row.codec.clone(), row.filter.clone(), level, row.fetches.to_string()];
            cells.push(bytes(row.bytes_on_gpu));
            cells.extend([row.shader, row.shader_exact, row.cpu_one, row.cpu_all].map(mega));
            cells
        })
        .collect();
    let shaders = adapter(&result.adapter);
    plain(&header, &rows)
        + &format!(
            "\nMillions of evaluations per second. Shaders: {shaders}.\n\
             A fetch of the sampler filters four texels, of a table eight; exact weights and the CPU fetch each of them.\n"
        )
}

pub(super) fn level_of_detail_text(result: &LevelOfDetail) -> String {
    let header = ["level", "fetches", "nearest", "speed-up", "bilinear", "speed-up", "paper", "luminance"];
    let rows: Vec<Vec<String>> = result
        .levels
        .iter()
        .map(|row| {
            let time = |k: usize| [format!("{:.1} ms", 1e3 * row.seconds[k]), format!("{:.2}", row.speed_up[k])];
            let mut cells = vec![row.level.to_string(), format!("{} or {}", row.fetches[0], row.fetches[1])];
            cells.extend(time(0));
            cells.extend(time(1));
            cells.push(row.paper.map_or("-".to_owned(), |paper| format!("{paper:.1}")));
            cells.push(format!("{:.4}", row.luminance));
            cells
        })
        .collect();
    let flicker: Vec<Vec<String>> = [
        ("finest level", result.finest),
        ("level by distance", result.by_distance),
        ("finest level, 16 samples per pixel", result.smooth),
    ]
    .into_iter()
    .map(|(name, f)| {
        vec![
            name.to_owned(),
            format!("{:.3e}", f.variance),
            format!("{:.4}", f.luminance),
            format!("{:.4}", f.relative),
        ]
    })
    .collect();
    plain(&header, &rows)
        + &format!(
            "\nlevel by distance, bilinear: {:.1} ms; without lights: {:.1} ms, subtracted before speed-ups\n\n",
            1e3 * result.seconds_by_distance,
            1e3 * result.seconds_without_light
        )
        + &plain(&["flicker over six frames moving away", "variance", "luminance", "relative"], &flicker)
        + &format!(
            "\n{} triangles, {} x {} pixels of which {} show terrain, {} lights. {}.\n\
             Luminance: mean of the display's over pixels that are 60 units away or more. Variance: of this luminance over\n\
             time, mean over the same pixels; relative to the squared mean luminance.\n",
            result.triangles,
            result.size[0],
            result.size[1],
            result.shaded,
            result.lights,
            adapter(&result.adapter),
        )
}

pub(super) fn images_text(rows: &[ImageRow]) -> String {
    let header =
        ["material", "shader ΔE", "σ", "pack", "σ", "table", "σ", "by default", "σ", "ΔE2000", "PSNR", "verdict"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut cells = vec![row.material.clone()];
            cells.extend(
                [row.shader, row.pack, row.table, row.shader_by_energy]
                    .concat()
                    .iter()
                    .map(|value| format!("{value:.3}")),
            );
            cells.push(format!("{:.3}", row.delta_e_2000));
            cells.push(row.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.1} dB")));
            let verdict = match (row.passes(), row.grid_is_the_limit()) {
                (true, _) => "met",
                (false, true) => "missed: the grid",
                (false, false) => "missed",
            };
            cells.push(verdict.to_owned());
            cells
        })
        .collect();
    let adapter = rows.iter().find_map(|row| row.adapter.as_ref()).map_or(String::new(), adapter);
    plain(&header, &cells)
        + &format!(
            "\nCloth, 512 x 512 pixels of 4 samples, 4:1, 8 bits; mean and standard deviation of ΔE of CIE L*a*b* over\n\
             surfaces, against the source. '--ranking visible --bias 0.0003', except for 'by default'. Pack and table are drawn\n\
             on the CPU, the complete table at 16 bits, with errors of the grid alone.\n\
             Met: at most {PAPER_MEAN} and {PAPER_SIGMA}, the paper's velvet. Shader: {adapter}.\n"
        )
}
