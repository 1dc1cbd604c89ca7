//! The study of methods that shade under an environment.

use super::adaptive::{environment, opened, pixels, unpackable};
use super::arguments::Arguments;
use super::structures::file_stem;
use brdfc_core::Source;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_formats::lobes::LobesPack;
use brdfc_jobs::environment::prefilter_image;
use brdfc_jobs::lobes::encode_lobes;
use brdfc_lobes::LobesRecipe;
use brdfc_render::adaptive::FilteredLight;
use brdfc_render::rendering::rgb_png;
use brdfc_render::scene::{Environment, Frame};
use brdfc_source::Input;
use brdfc_studies::StudyResult;
use brdfc_studies::adaptive::{
    Case, CaseRow, Cost, FETCHES, Gaussians, Light, Lighting, LitBalls, MATERIALS, MAX_SAMPLES, Method, MethodSummary,
    Prefiltered, SIZES, SplitSumMaterial, StudyMaterial, TARGETS, Target, TruthSamples, combinations, compare,
    environments, equal_time_sheet, shapes, summary, training_environments,
};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::plain;
use brdfc_terminal::{Common, Error};
use std::time::Instant;

/// Shares of the cases at each size.
const SHARES: [usize; 3] = [3, 10, 30];
/// Samples per pixel of the ground truth, and pixels per side, with --small.
const SMALL: (usize, usize) = (128, 64);

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let started = Instant::now();
    pixels(arguments)?;
    let inputs: Vec<(String, Box<dyn Source>)> = if arguments.inputs.is_empty() {
        let open_default =
            |(name, address): &(&str, &str)| Ok(((*name).to_owned(), opened(&Input::from(*address), common)?));
        MATERIALS.iter().map(open_default).collect::<Result<_, Error>>()?
    } else {
        let open_input = |input: &Input| Ok((input.short_name(), opened(input, common)?));
        arguments.inputs.iter().map(open_input).collect::<Result<_, Error>>()?
    };
    let shapes = shapes();
    let cases = cases(arguments, inputs.len(), shapes.len());
    let lights = lights(arguments)?;
    let training = training_environments().into_iter().map(light).collect::<Result<Vec<Light>, Error>>()?;
    let mut materials = Vec::new();
    // Cases of --small have few of the materials.
    let used = cases.iter().map(|(_, [material, ..])| material + 1).max().unwrap_or(0);
    for (name, source) in &inputs[..used] {
        let material = StudyMaterial::new(name.clone(), source.as_ref()).map_err(unpackable)?;
        let lobes = lobes(source.as_ref())?;
        let balls = LitBalls::new(&material, &training);
        let (split_sum, gaussians) = (SplitSumMaterial::fitted(&balls), Gaussians::fitted(&balls));
        remark(common, &format!("{name}: samples, map, lobes and models, {:.0} s", started.elapsed().as_secs_f64()));
        materials.push((material, lobes, split_sum, gaussians));
    }
    let truth = arguments.truth.or(arguments.small.then_some(SMALL.0));
    let drawing = Instant::now();
    let work = |cases: &[Combination]| cases.iter().map(|case| case.0 * case.0).sum::<usize>() as f64;
    let mut rows = Vec::new();
    for (number, (size, [material, shape, light])) in cases.iter().enumerate() {
        let ((material, lobes, fitted, gaussians), (shape, scene)) = (&materials[*material], &shapes[*shape]);
        let Light { name: environment, lighting, filtered } = &lights[*light];
        let frame = Frame { width: *size, height: *size, samples: 1 };
        let light = FilteredLight { environment: filtered, scattered: true };
        let split_sum = fitted.lit_by(filtered)?;
        let prefiltered = Prefiltered { light: &light, lobes, split_sum: &split_sum, gaussians };
        let (row, sheet) = Case::with(material, scene, lighting, frame, TruthSamples::Halves(truth), |case| {
            let row = compare(case, prefiltered, [&material.name, shape, environment]);
            let sheet = arguments.out.as_ref().and_then(|_| equal_time_sheet(case, prefiltered, &row));
            (row, sheet)
        });
        if let (Some(folder), Some(sheet)) = (&arguments.out, sheet) {
            make_folder(folder)?;
            let name = file_stem(&format!("equal-time-{}-{shape}-{environment}-{size}", material.name));
            write_file(&folder.join(format!("{name}.png")), &rgb_png(&sheet))?;
        }
        rows.push(row);
        let left = drawing.elapsed().as_secs_f64() * work(&cases[number + 1..]) / work(&cases[..=number]);
        let done =
            format!("{} of {}: {} on {shape}, {environment}, {size} pixels", number + 1, cases.len(), material.name);
        remark(common, &format!("{done}, {:.0} s, about {left:.0} s left", started.elapsed().as_secs_f64()));
    }
    Ok(StudyResult::Adaptive { targets: TARGETS.to_vec(), summary: summary(&rows), rows })
}

/// A size, and numbers of material, shape and environment.
type Combination = (usize, [usize; 3]);

/// All cases at the size of --pixels; otherwise shares of them that take about as long at each size.
fn cases(arguments: &Arguments, materials: usize, shapes: usize) -> Vec<Combination> {
    let counts = [materials, shapes, if arguments.environment.is_some() { 1 } else { 3 }];
    let all: usize = counts.iter().product();
    let of = |size: usize, most: usize| combinations(counts, most).into_iter().map(move |case| (size, case));
    match arguments.pixels {
        Some(size) => of(size, if arguments.small { 2 } else { all }).collect(),
        None if arguments.small => of(SMALL.1, 2).collect(),
        None => SIZES.iter().zip(SHARES).flat_map(|(size, share)| of(*size, all.div_ceil(share))).collect(),
    }
}

fn lights(arguments: &Arguments) -> Result<Vec<Light>, Error> {
    let images = match &arguments.environment {
        Some(input) => vec![(input.short_name(), environment(input)?)],
        None => environments(),
    };
    images.into_iter().map(light).collect()
}

fn light((name, image): (String, Environment)) -> Result<Light, Error> {
    let filtered = EnvironmentDecoder::new(&prefilter_image(&image, None, &())?);
    Ok(Light { name, lighting: Lighting::new(image).map_err(unpackable)?, filtered })
}

/// Lobes of all numbers of look-ups.
fn lobes(source: &dyn Source) -> Result<Vec<LobesPack>, Error> {
    let most = FETCHES[FETCHES.len() - 1];
    let encoded = encode_lobes(source, &LobesRecipe { max_fetches: most, max_delta_e: None }, &())?;
    let mut packs: Vec<LobesPack> = Vec::new();
    for count in FETCHES {
        let within = encoded.trials.iter().rev().find(|trial| trial.pack.fetches() <= count);
        let new = within.filter(|trial| packs.last() != Some(&trial.pack));
        packs.extend(new.map(|trial| trial.pack.clone()));
    }
    Ok(packs)
}

pub(super) fn text(targets: &[Target], rows: &[CaseRow], summary: &[MethodSummary]) -> String {
    let names = Method::ALL.map(|(_, name)| name);
    let header = [&["material", "shape", "light", "pixels", "error"][..], &names].concat();
    let cells = rows.iter().flat_map(|row| {
        let line = |(at, target): (usize, &Target)| -> Vec<String> {
            let case = [row.material.clone(), row.shape.clone(), row.environment.clone(), row.pixels.to_string()];
            let costs = row.methods.iter().map(|of| cell(*target, of.needed[at], of.best[at]));
            case.into_iter().chain([target_text(*target)]).chain(costs).collect()
        };
        targets.iter().enumerate().map(line).collect::<Vec<_>>()
    });
    let cells: Vec<Vec<String>> = cells.collect();
    let least = |of: &dyn Fn(&CaseRow) -> f64| rows.iter().map(of).fold(f64::INFINITY, f64::min);
    let most = |of: &dyn Fn(&CaseRow) -> f64| rows.iter().map(of).fold(0.0, f64::max);
    plain(&header, &cells)
        + &format!(
            "\nSamples or fetches per surface pixel, and milliseconds, that each method needs for the error; '-' and its smallest\n\
             error if no budget of at most {MAX_SAMPLES} per surface pixel reaches it. Interpolated between doublings.\n\
             half, quarter: shaded pixels along each axis, the others interpolated. filt.: filtered importance samples, the\n\
             better of the same samples at all pixels and others at each. adaptive: the best of three cautions, including the\n\
             time of the bandwidth buffer.\n\
             Ground truths have {:.0} to {:.0} samples per pixel, a PSNR of at least {:.1} dB, and a FLIP of at most {:.4} from one\n\
             with half of their samples.\n\n",
            least(&|row| row.truth_samples as f64),
            most(&|row| row.truth_samples as f64),
            least(&|row| row.truth_psnr.unwrap_or(f64::INFINITY)),
            most(&|row| row.truth_flip),
        )
        + &summary_text(targets, summary)
        + &sizes_text(targets, rows)
}

fn target_text(target: Target) -> String {
    match target {
        Target::Psnr(psnr) => format!("{psnr} dB"),
        Target::Flip(flip) => format!("FLIP {flip}"),
    }
}

fn cell(target: Target, needed: Option<Cost>, best: Option<f64>) -> String {
    match (needed, best) {
        (Some(cost), _) => format!("{} {}", short(cost.samples), short(1e3 * cost.seconds)),
        (None, Some(best)) => match target {
            Target::Psnr(_) => format!("- {best:.1}"),
            Target::Flip(_) => format!("- {best:.3}"),
        },
        (None, None) => "-".to_owned(),
    }
}

/// Two significant digits.
fn short(value: f64) -> String {
    match value {
        v if v >= 9.95 => format!("{v:.0}"),
        v if v >= 0.995 => format!("{v:.1}"),
        v if v >= 0.0995 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

fn summary_text(targets: &[Target], summary: &[MethodSummary]) -> String {
    let header = ["error", "method", "reached", "fewest", "fastest", "gain", "gain in time", "equal time", "cases"];
    let name = |method: Method| Method::ALL.iter().find(|(of, _)| *of == method).map_or("", |(_, name)| *name);
    let factor = |gain: Option<f64>| gain.map_or("-".to_owned(), |gain| format!("{gain:.2}"));
    let line = |at: usize, of: &MethodSummary| {
        let found = &of.targets[at];
        vec![
            target_text(targets[at]),
            name(of.method).to_owned(),
            format!("{} of {}", found.reached, found.cases),
            found.fewest_samples.to_string(),
            found.fastest.to_string(),
            factor(found.samples_gain),
            factor(found.seconds_gain),
            found.at_equal_time.map_or("-".to_owned(), |error| match targets[at] {
                Target::Psnr(_) => format!("{error:.1} dB"),
                Target::Flip(_) => format!("{error:.3}"),
            }),
            found.within_time.to_string(),
        ]
    };
    let lines: Vec<Vec<String>> =
        (0..targets.len()).flat_map(|at| summary.iter().map(|of| line(at, of)).collect::<Vec<_>>()).collect();
    plain(&header, &lines)
        + "\nreached: cases in which the method has the error, of those in which any method has it. fewest, fastest: cases in\n\
           which it needs the fewest samples, or the shortest time, of all. gain: factor of samples against the best of the\n\
           six methods from forward to quarter, filt. (other than itself), geometric mean over cases that both reach; below\n\
           1 it loses. gain in time: the same factor of time. equal time: mean PSNR, or geometric mean of FLIP, at the time that\n\
           adaptive shading needs for the error, over the cases in which it has the error and the method a rendering.\n"
}

/// Gains of methods by the size of the rendering, which decides most whether adaptive shading pays.
fn sizes_text(targets: &[Target], rows: &[CaseRow]) -> String {
    let mut sizes: Vec<usize> = rows.iter().map(|row| row.pixels).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let header: Vec<String> =
        ["pixels", "method"].map(str::to_owned).into_iter().chain(targets.iter().map(|t| target_text(*t))).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let factor = |gain: Option<f64>| gain.map_or("-".to_owned(), short);
    let of_size = |size: usize| -> Vec<Vec<String>> {
        let of: Vec<CaseRow> = rows.iter().filter(|row| row.pixels == size).cloned().collect();
        let line = |(method, (_, name)): (MethodSummary, &(Method, &str))| -> Vec<String> {
            let gains = method.targets.iter().map(|t| format!("{} {}", factor(t.samples_gain), factor(t.seconds_gain)));
            [size.to_string(), (*name).to_owned()].into_iter().chain(gains).collect()
        };
        summary(&of).into_iter().zip(&Method::ALL).map(line).collect()
    };
    let lines: Vec<Vec<String>> = sizes.into_iter().flat_map(of_size).collect();
    "\n".to_owned() + &plain(&header, &lines) + "\nGains of samples and of time by size.\n"
}
