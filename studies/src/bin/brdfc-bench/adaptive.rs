//! The studies of predicted bandwidth.

use super::arguments::Arguments;
use super::on_adapter;
use super::structures::file_stem;
use brdfc_core::Source;
use brdfc_formats::FormatError;
use brdfc_jobs::environment::Surroundings;
use brdfc_jobs::tabulated::tabulated;
use brdfc_render::adaptive::Start;
use brdfc_render::rendering::rgb_png;
use brdfc_render::scene::{Environment, Frame};
use brdfc_render::scenes::Builtin;
use brdfc_source::Input;
use brdfc_source::environment::open_environment;
use brdfc_source::open::open;
use brdfc_studies::adaptive::{
    AntialiasingStudy, Case, DirectionsStudy, FourierCheck, FourierRow, Lighting, StudyMaterial, TruthSamples,
    antialiasing_study, directions_study,
};
use brdfc_studies::{Study, StudyResult};
use brdfc_terminal::output::{make_folder, note, remark, write_file};
use brdfc_terminal::table::{percent, plain};
use brdfc_terminal::{Common, Error};
use std::path::Path;
use std::time::Instant;

/// Shapes with smooth and bumpy parts.
const SHAPES: [Builtin; 2] = [Builtin::BumpyBall, Builtin::RibbedTorus];
/// Mean samples per pixel of the studies at a fixed budget.
const BUDGET: f32 = 64.0;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let side = pixels(arguments)?.unwrap_or(512);
    let truth = arguments.truth.unwrap_or(256);
    let environment = match &arguments.environment {
        Some(input) => environment(input)?,
        None => Builtin::BumpyBall.scene().environment,
    };
    let lighting = Lighting::new(environment).map_err(unpackable)?;
    let default = [on_adapter::GLOSSY.into()];
    let inputs = if arguments.inputs.is_empty() { &default[..] } else { &arguments.inputs };
    // Open all inputs before the work, so that a missing one is reported immediately.
    let sources: Vec<Box<dyn Source>> =
        inputs.iter().map(|input| opened(input, common)).collect::<Result<_, Error>>()?;
    let frame = Frame { width: side, height: side, samples: 1 };
    let shapes: &[Builtin] = match arguments.study {
        Study::PixelBandwidth => &[Builtin::Sphere],
        Study::BandwidthDirections => &SHAPES[..1],
        _ => &SHAPES,
    };
    let (started, all) = (Instant::now(), inputs.len() * shapes.len());
    let mut result = empty(arguments.study);
    for (number, (index, shape)) in (0..inputs.len()).flat_map(|i| shapes.iter().map(move |s| (i, *s))).enumerate() {
        let name = inputs[index].short_name();
        let material = StudyMaterial::new(name.clone(), sources[index].as_ref()).map_err(unpackable)?;
        add(&mut result, &material, shape, &lighting, frame, truth, arguments.out.as_deref())?;
        let seconds = started.elapsed().as_secs_f64();
        let left = seconds / (number + 1) as f64 * (all - number - 1) as f64;
        remark(
            common,
            &format!("{} of {all}: {name} on {}, {seconds:.0} s, about {left:.0} s left", number + 1, shape.name()),
        );
    }
    Ok(result)
}

/// Opens an environment as a latitude-longitude image.
pub(super) fn environment(input: &Input) -> Result<Environment, Error> {
    Ok(Surroundings::from(open_environment(input)?).into_image())
}

/// Pixels per side, if they are given.
pub(super) fn pixels(arguments: &Arguments) -> Result<Option<usize>, Error> {
    // Windows of 32 x 32 pixels must fit into the sphere.
    let least = if arguments.study == Study::PixelBandwidth { 64 } else { 32 };
    match arguments.pixels {
        Some(side) if !(least..=2048).contains(&side) => {
            Err(Error::usage(format!("--pixels: found {side}, expected {least} to 2048")))
        }
        pixels => Ok(pixels),
    }
}

/// Opens a material. A scan becomes a table, because renderings look it up millions of times.
pub(super) fn opened(input: &Input, common: Common) -> Result<Box<dyn Source>, Error> {
    let source = open(input, None)?.source;
    let Some(table) = tabulated(source.as_ref(), &())? else { return Ok(source) };
    note(common, input, &table.summary());
    Ok(Box::new(table.source))
}

pub(super) fn unpackable(error: FormatError) -> Error {
    Error::internal(format!("bandwidth map of the environment: {error}"))
}

fn empty(study: Study) -> StudyResult {
    match study {
        Study::PixelBandwidth => StudyResult::PixelBandwidth { rows: Vec::new() },
        Study::BandwidthDirections => StudyResult::BandwidthDirections { rows: Vec::new() },
        _ => StudyResult::Antialiasing { rows: Vec::new() },
    }
}

fn add(
    result: &mut StudyResult,
    material: &StudyMaterial<'_>,
    shape: Builtin,
    lighting: &Lighting,
    frame: Frame,
    truth: usize,
    out: Option<&Path>,
) -> Result<(), Error> {
    let (name, on) = (material.name.clone(), shape.name().to_owned());
    match result {
        StudyResult::PixelBandwidth { rows } => {
            let truth = TruthSamples::Fixed(truth, Start::Shared);
            let (row, figures) = Case::with(material, &shape.scene(), lighting, frame, truth, |case| {
                let check = FourierCheck::new(case, material);
                let figures = || [("bandwidth", check.figure(case)), ("combining", check.combining(case))];
                (check.row(case, &name, &on), out.map(|folder| (folder, figures())))
            });
            if let Some((folder, figures)) = figures {
                make_folder(folder)?;
                for (of, figure) in figures {
                    let name = file_stem(&format!("{of}-{name}"));
                    write_file(&folder.join(format!("{name}.png")), &rgb_png(&figure))?;
                }
            }
            rows.push(row);
        }
        StudyResult::BandwidthDirections { rows } => {
            let found = Case::with(
                material,
                &shape.scene(),
                lighting,
                frame,
                TruthSamples::Fixed(truth, Start::Scattered),
                |case| directions_study(case, BUDGET),
            );
            rows.push(DirectionsStudy { material: name, shape: on, rows: found });
        }
        StudyResult::Antialiasing { rows } => {
            rows.push(antialiasing_study(material, shape, lighting, frame, BUDGET));
        }
        _ => unreachable!("studies of this file"),
    }
    Ok(())
}

pub(super) fn fourier_text(rows: &[FourierRow]) -> String {
    let header = [
        "material",
        "shape",
        "windows",
        "within 4",
        "too low by 2",
        "rank",
        "rank of detail",
        "5 %",
        "median",
        "95 %",
        "shaded",
        "by transform",
    ];
    let share = |share: Option<f64>| share.map_or("-".to_owned(), percent);
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut cells = vec![row.material.clone(), row.shape.clone(), row.windows.to_string()];
            cells.extend([percent(row.within_4), percent(row.too_low_by_2)]);
            cells.extend([row.rank_correlation, row.rank_correlation_of_detail].map(|rank| format!("{rank:.3}")));
            cells.extend([row.ratios.low, row.ratios.median, row.ratios.high].map(|ratio| format!("{ratio:.2}")));
            cells.extend([share(row.shaded_by_prediction), share(row.shaded_by_transform)]);
            cells
        })
        .collect();
    let deviations: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let found = &row.deviation;
            let mut cells = vec![row.material.clone(), row.shape.clone(), found.points.to_string()];
            cells.extend([percent(found.within_2), format!("{:.3}", found.rank_correlation)]);
            let ratios = [found.ratios.low, found.ratios.median, found.ratios.high];
            cells.extend(ratios.map(|ratio| format!("{ratio:.2}")));
            cells
        })
        .collect();
    let deviation = ["material", "shape", "points", "within 2", "rank correlation", "5 %", "median", "95 %"];
    let counts = rows.iter().map(|row| {
        let c = &row.sample_counts;
        let mut cells = vec![row.material.clone(), row.shape.clone()];
        cells.extend([c.uniform, c.prediction, c.first_samples, c.both].map(percent));
        cells
    });
    let combined = rows.iter().map(|row| {
        let mut cells = vec![row.material.clone(), row.shape.clone()];
        cells.extend(row.mean_and_maximum.map(|bandwidth| format!("{bandwidth:.3}")));
        cells.extend(row.at_full_resolution.map(percent));
        cells
    });
    let of_combined = ["material", "shape", "mean", "maximum", "full, mean", "full, maximum"];
    let of_counts = ["material", "shape", "uniform", "prediction", "first samples", "both"];
    plain(&header, &cells)
        + "\nPredicted pixel bandwidth over the root mean square of frequency in windows of 32 x 32 pixels of the ground truth as\n\
           displayed. rank: correlation of both; of detail: with the mean of a window as a frequency of 0. shaded: pixels to shade\n\
           for 30 dB, without noise, if levels follow the prediction, or the transform.\n\n"
        + &plain(&of_combined, combined)
        + "\nBandwidths of the directions of a pixel combined by their weighted mean, which is the prediction, and by their maximum:\n\
           means over surface pixels in cycles per pixel, and shares of pixels that demand full resolution.\n\n"
        + &plain(&deviation, &deviations)
        + "\nPredicted standard deviation of samples over that of 256 samples, as displayed. within 2: share of ratios within a\n\
           factor 2 of the median; a common factor does not matter.\n\n"
        + &plain(&of_counts, counts)
        + "\nSamples needed for the same sum of squared errors with numbers in proportion to the measured spread of samples, over\n\
           those needed with uniform numbers, numbers in proportion to the prediction, to the spread of the first four samples of\n\
           neighbours, and to the geometric mean of both.\n"
}

pub(super) fn directions_text(rows: &[DirectionsStudy]) -> String {
    let header = ["material", "shape", "directions", "PSNR", "samples", "bandwidth", "rendering"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .flat_map(|study| study.rows.iter().map(move |row| (study, row)))
        .map(|(study, row)| {
            vec![
                study.material.clone(),
                study.shape.clone(),
                row.directions.to_string(),
                row.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.2} dB")),
                format!("{:.2}", row.samples),
                format!("{:.0} ms", 1e3 * row.bandwidth_seconds),
                format!("{:.0} ms", 1e3 * row.seconds),
            ]
        })
        .collect();
    plain(&header, &cells)
        + "\nRenderings for the same number of samples per surface pixel, with bandwidth averaged over increasing numbers of\n\
           incident directions. bandwidth: time of the bandwidth buffer.\n"
}

pub(super) fn antialiasing_text(rows: &[AntialiasingStudy]) -> String {
    let header = ["material", "shape", "points", "shaded", "samples", "time", "exponents"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .flat_map(|study| study.rows.iter().map(move |row| (study, row)))
        .map(|(study, row)| {
            let exponents =
                study.exponents.filter(|_| row.points > 1 && row.points == study.rows.last().map_or(0, |r| r.points));
            vec![
                study.material.clone(),
                study.shape.clone(),
                row.points.to_string(),
                row.shaded.to_string(),
                row.samples.to_string(),
                format!("{:.0} ms", 1e3 * row.seconds),
                exponents.map_or(String::new(), |e| format!("{:.2}, {:.2}, {:.2}", e.shaded, e.samples, e.seconds)),
            ]
        })
        .collect();
    plain(&header, &cells)
        + "\nPoints per pixel; shaded pixels of all levels and samples of incident light. exponents: of shaded pixels, samples and\n\
           time over points, from 1 to 16.\n\n"
        + &budgets_text(rows)
}

fn budgets_text(rows: &[AntialiasingStudy]) -> String {
    let header = ["material", "shape", "samples", "time", "line"];
    let line = |study: &AntialiasingStudy| {
        study.line.map_or(String::new(), |line| {
            let [fixed, each] = [1e3 * line.seconds, 1e9 * line.seconds_per_sample];
            format!("{fixed:.0} ms + {each:.0} ns per sample, within {}", percent(line.error))
        })
    };
    let cells: Vec<Vec<String>> = rows
        .iter()
        .flat_map(|study| study.budgets.iter().enumerate().map(move |(at, row)| (study, at, row)))
        .map(|(study, at, row)| {
            let time = format!("{:.0} ms", 1e3 * row.seconds);
            let line = if at + 1 == study.budgets.len() { line(study) } else { String::new() };
            vec![study.material.clone(), study.shape.clone(), row.samples.to_string(), time, line]
        })
        .collect();
    plain(&header, &cells)
        + "\nTime by the number of samples, with one point per pixel, and the line through these times.\n"
}
