//! The study of times of a frame.

use super::adaptive::{environment, opened};
use super::arguments::Arguments;
use super::on_adapter::{adapter, opened_adapter};
use super::structures::short_name;
use brdfc_jobs::encode::{PackRecipe, encode};
use brdfc_jobs::environment::prefilter_image;
use brdfc_jobs::lobes::encode_lobes;
use brdfc_lobes::LobesRecipe;
use brdfc_render::lobes::PrefilteredLight;
use brdfc_render::scenes::Builtin;
use brdfc_source::Input;
use brdfc_studies::StudyResult;
use brdfc_studies::frame_time::{FrameMaterial, FrameTimes, frame_times};
use brdfc_studies::relief::{ReliefError, ReliefFrame, ReliefFrames, relief_frames};
use brdfc_table::recipe::TableRecipe;
use brdfc_terminal::output::remark;
use brdfc_terminal::table::{bytes, plain};
use brdfc_terminal::{Common, Error};
use std::time::Instant;

/// Materials of table top, cloth, vase and ball, by default.
const MATERIALS: [&str; 4] = [
    "synth:lambert?kd=0.5,0.4,0.3",
    "synth:ggx?kd=0.05,0.08,0.25&alpha=0.3",
    "synth:ggx?kd=0&f0=0.9,0.8,0.6&alpha=0.15",
    "synth:ggx?kd=0.25,0.02,0.02&alpha=0.07",
];
/// Pixels of a frame, and of a small one.
const SIZE: [usize; 2] = [1920, 1080];
const SMALL: [usize; 2] = [96, 54];
/// Structure of the reliefs, and texels per side.
const STRUCTURE: &str = "button";
const TEXELS: u32 = 128;
/// Each side of a frame over that of a frame of a relief.
const SHARE: usize = 3;
const SMALL_TEXELS: u32 = 16;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let started = Instant::now();
    let default = MATERIALS.map(Input::from);
    let inputs = if arguments.inputs.is_empty() { &default[..] } else { &arguments.inputs };
    let gpu = opened_adapter(arguments)?;
    let mut scene = Builtin::Table.scene();
    if let Some(input) = &arguments.environment {
        scene.environment = environment(input)?;
    }
    let progress = |what: &str| remark(common, &format!("{what}, {:.0} s", started.elapsed().as_secs_f64()));
    let sources = inputs.iter().map(|input| opened(input, common)).collect::<Result<Vec<_>, Error>>()?;
    let materials = sources.iter().cycle().take(scene.parts.len()).map(|source| {
        let recipe = PackRecipe::Table(TableRecipe::default().into()).without_measuring();
        let pack = encode(source.as_ref(), &recipe, &())?.pack;
        let lobes = encode_lobes(source.as_ref(), &LobesRecipe::default(), &())?.best().pack.clone();
        Ok(FrameMaterial { source: source.as_ref(), pack, lobes })
    });
    let materials = materials.collect::<Result<Vec<_>, Error>>()?;
    let light = PrefilteredLight::new(prefilter_image(&scene.environment, None, &())?);
    progress("packs and lobes");
    let size = if arguments.small { SMALL } else { SIZE };
    let times = frame_times(&gpu, &scene, &light, &materials, size, progress)?;
    let texels = if arguments.small { SMALL_TEXELS } else { TEXELS };
    let reliefs =
        relief_frames(&gpu, STRUCTURE, texels, size.map(|side| side / SHARE), progress).map_err(
            |error| match error {
                ReliefError::Gpu(error) => Error::from(error),
                error => Error::input(format!("{STRUCTURE}: {error}")),
            },
        )?;
    Ok(StudyResult::FrameTime { times, reliefs })
}

fn milliseconds(seconds: f64) -> String {
    format!("{:.1} ms", 1e3 * seconds)
}

fn of_reliefs(study: &ReliefFrames) -> String {
    let cells = |row: &ReliefFrame| {
        let (most, mean) = (row.fetches.to_string(), format!("{:.1}", row.mean_fetches));
        vec![row.relief.to_owned(), bytes(row.bytes), most, mean, milliseconds(row.seconds)]
    };
    plain(&["relief", "on a GPU", "fetches", "mean", "time"], study.rows.iter().map(cells))
        + &format!(
            "\nsynth:{0}, {1} x {1} texels, on a plane that fills {2} x {3} pixels; the fastest of 25 runs. A frame that shows\n\
             nothing: {4}. Fetches of the sampler: most of a pixel under one light, and their mean. Point lights: {5}.\n",
            short_name(&study.model),
            study.texels,
            study.size[0],
            study.size[1],
            milliseconds(study.empty),
            study.lights
        )
}

pub(super) fn text(study: &FrameTimes, reliefs: &ReliefFrames) -> String {
    let look_ups: Vec<String> = study.look_ups.iter().map(ToString::to_string).collect();
    let mut rows = vec![
        vec![format!("{} point lights, by packs", study.lights), milliseconds(study.points)],
        vec![format!("environment, by lobes: {} look-ups", look_ups.join(", ")), milliseconds(study.lobes)],
    ];
    rows.extend(study.forward.iter().map(|row| {
        vec![format!("environment, forward shading: samples per pixel: {}", row.samples), milliseconds(row.seconds)]
    }));
    let [width, height] = study.size;
    plain(&["a frame", "time"], &rows)
        + &format!(
            "\n{width} x {height} pixels of which {} show surfaces, one sample of each; the fastest of five runs, until the\n\
             image is read back. {}.\n\
             Forward shading starts from a buffer of surfaces, whose time is not included.\n",
            study.surface,
            adapter(&study.adapter)
        )
        + "\n"
        + &of_reliefs(reliefs)
}
