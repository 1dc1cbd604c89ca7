//! `brdfc schema`: JSON schemas of the reports of `--json`.

use super::Error;
use super::output::print_json;
use clap::{Args, ValueEnum};
use schemars::schema_for;

/// Print the JSON schema of a report.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc schema encode > encode.schema.json")]
pub struct Arguments {
    /// Report to describe.
    #[arg(value_enum)]
    report: Report,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Report {
    /// 'brdfc build --json', and report.json in the output folder.
    Build,
    /// MATERIAL.json in the output folder.
    Material,
    /// Each line of 'brdfc watch --json'.
    Watch,
    /// 'brdfc encode --json'.
    Encode,
    /// 'brdfc encode --codec lobes --json'.
    EncodeLobes,
    /// 'brdfc compare --json'.
    Compare,
    /// 'brdfc convert --json'.
    Convert,
    /// 'brdfc info --json' for a material, a pack that is drawn, importance samples, lobes, a prefiltered environment, photographs under known lights, or a
    /// polynomial wavelet tree or texture map.
    Info,
    /// 'brdfc info --files --json'.
    Files,
    /// 'brdfc bandwidth --json', and 'brdfc info --json' for a bandwidth map.
    Bandwidth,
    /// 'brdfc samples --json'.
    Samples,
    /// 'brdfc environment --json'.
    Environment,
    /// 'brdfc shader --json'.
    Shader,
    /// 'brdfc pwt --json'.
    Pwt,
    /// 'brdfc info --json' for a structure, a mesh, a height map, or images.
    InfoSurface,
    /// 'brdfc flatten --json'.
    Flatten,
    /// 'brdfc info --json' and 'brdfc report --json' for a flat BTF.
    FlatBtf,
    /// 'brdfc plan --format json'.
    Plan,
    /// 'brdfc report --json' for a build, and the .json next to its page.
    #[value(name = "report")]
    Page,
    /// 'brdfc verify --json'.
    Verify,
    /// 'brdfc view --json'.
    View,
    /// 'brdfc render --json'.
    #[cfg(feature = "render")]
    Render,
    /// 'brdfc render --adaptive --json'.
    #[cfg(feature = "render")]
    RenderAdaptive,
    /// 'brdfc render --contact --json'.
    #[cfg(feature = "render")]
    RenderContact,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Error> {
    print_json(&match arguments.report {
        Report::Build => schema_for!(brdfc::BuildReport),
        Report::Material => schema_for!(brdfc::scene::MaterialFile),
        Report::Watch => schema_for!(super::watch::Report),
        Report::Encode => schema_for!(super::encode::Report),
        Report::EncodeLobes => schema_for!(super::encode_lobes::Report),
        Report::Compare => schema_for!(super::compare::Report),
        Report::Convert => schema_for!(super::convert::Report),
        Report::Info => schema_for!(super::info::Report),
        Report::Files => schema_for!(super::info::FilesReport),
        Report::Bandwidth => schema_for!(super::bandwidth::Report),
        Report::Samples => schema_for!(super::samples::Report),
        Report::Environment => schema_for!(super::environment::Report),
        Report::Shader => schema_for!(super::shader::Report),
        Report::Pwt => schema_for!(super::pwt::Report),
        Report::InfoSurface => schema_for!(super::info::SurfaceReport),
        Report::Flatten => schema_for!(super::flatten::Report),
        Report::FlatBtf => schema_for!(brdfc::flatten::FlatAsset),
        Report::Plan => schema_for!(brdfc::scene::Graph),
        Report::Page => schema_for!(brdfc::report::PageReport<'static>),
        Report::Verify => schema_for!(super::verify::Report),
        Report::View => schema_for!(super::view::Report),
        #[cfg(feature = "render")]
        Report::Render => schema_for!(super::render::Report),
        #[cfg(feature = "render")]
        Report::RenderAdaptive => schema_for!(super::render::AdaptiveReport),
        #[cfg(feature = "render")]
        Report::RenderContact => schema_for!(super::render::ContactReport),
    })
}
