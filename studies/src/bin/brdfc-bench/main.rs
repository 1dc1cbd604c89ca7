//! `brdfc-bench`: studies that reproduce the papers' tables.

#[cfg(feature = "render")]
mod adaptive;
mod arguments;
mod btf;
#[cfg(feature = "render")]
mod codecs;
mod flat_btf;
#[cfg(feature = "render")]
mod frame_time;
mod measured_btf;
#[cfg(feature = "render")]
mod on_adapter;
mod pareto;
mod rays;
mod relief;
mod relighting;
mod remarks;
#[cfg(feature = "render")]
mod shading;
mod stress;
mod structures;
mod wavelet;

use arguments::Arguments;
use brdfc_studies::{Study, StudyResult};
use brdfc_terminal::output::{check_folder, print, print_json};
use brdfc_terminal::{Common, Error, run_program, usage};
use clap::CommandFactory as _;
use serde::Serialize;
use std::process::ExitCode;

/// Output of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct Report {
    /// Layout of this report.
    version: u32,
    /// The study's figures.
    #[serde(flatten)]
    result: StudyResult,
}

fn main() -> ExitCode {
    let command = Arguments::command().mut_args(usage::with_common_settings);
    run_program("brdfc-bench", command, std::env::args_os(), |arguments: &Arguments| &arguments.flags, run)
}

fn run(arguments: Arguments, common: Common) -> Result<(), Error> {
    if arguments.schema {
        return print_json(&schemars::schema_for!(Report));
    }
    let arguments = &arguments;
    arguments.check()?;
    if let Some(folder) = &arguments.out {
        check_folder(folder)?;
    }
    let result = match arguments.study {
        Study::WaveletBrdf => wavelet::run()?,
        Study::FlatBtf => flat_btf::run(arguments, common)?,
        Study::Relief => relief::run(arguments, common)?,
        Study::MeasuredBtf => measured_btf::run(arguments, common)?,
        Study::Relighting => relighting::run(arguments, common)?,
        Study::Btf => btf::run(arguments, common)?,
        Study::Rays => rays::run(arguments, common)?,
        Study::Pareto => pareto::run(arguments, common)?,
        Study::Stress => stress::run(arguments, common)?,
        #[cfg(feature = "render")]
        Study::Adaptive => shading::run(arguments, common)?,
        #[cfg(feature = "render")]
        Study::PixelBandwidth | Study::BandwidthDirections | Study::Antialiasing => adaptive::run(arguments, common)?,
        #[cfg(feature = "render")]
        Study::FrameTime => frame_time::run(arguments, common)?,
        #[cfg(feature = "render")]
        Study::Codecs => codecs::run(arguments, common)?,
        #[cfg(feature = "render")]
        Study::Throughput | Study::LevelOfDetail | Study::Images => on_adapter::run(arguments, common)?,
        #[cfg(not(feature = "render"))]
        Study::Throughput
        | Study::Codecs
        | Study::LevelOfDetail
        | Study::Images
        | Study::FrameTime
        | Study::Adaptive
        | Study::PixelBandwidth
        | Study::BandwidthDirections
        | Study::Antialiasing => return Err(brdfc_terminal::without_renderer()),
    };
    let checked = stress::check(&result);
    if common.json { print_json(&Report { version: 1, result }) } else { print_text(&result) }?;
    checked
}

fn print_text(result: &StudyResult) -> Result<(), Error> {
    match result {
        StudyResult::WaveletBrdf { rows } => print(&wavelet::text(rows)),
        StudyResult::FlatBtf { settings, rows } => print(&flat_btf::text(settings, rows)),
        StudyResult::Relief { settings, rows } => print(&relief::text(settings, rows)),
        StudyResult::MeasuredBtf { rows } => print(&measured_btf::text(rows)),
        StudyResult::Relighting(study) => print(&relighting::text(study)),
        StudyResult::Btf(study) => print(&btf::text(study)),
        StudyResult::Rays(study) => print(&rays::text(study)),
        StudyResult::Pareto(study) => print(&pareto::text(study)),
        StudyResult::Stress(study) => print(&stress::text(study)),
        #[cfg(feature = "render")]
        StudyResult::Adaptive { targets, rows, summary } => print(&shading::text(targets, rows, summary)),
        #[cfg(feature = "render")]
        StudyResult::PixelBandwidth { rows } => print(&adaptive::fourier_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::BandwidthDirections { rows } => print(&adaptive::directions_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::Antialiasing { rows } => print(&adaptive::antialiasing_text(rows)),
        #[cfg(feature = "render")]
        StudyResult::Throughput(study) => print(&on_adapter::throughput_text(study)),
        #[cfg(feature = "render")]
        StudyResult::FrameTime { times, reliefs } => print(&frame_time::text(times, reliefs)),
        #[cfg(feature = "render")]
        StudyResult::Codecs(study) => print(&codecs::text(study)),
        #[cfg(feature = "render")]
        StudyResult::LevelOfDetail(study) => print(&on_adapter::level_of_detail_text(study)),
        #[cfg(feature = "render")]
        StudyResult::Images { rows } => print(&on_adapter::images_text(rows)),
    }
}
