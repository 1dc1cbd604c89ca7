//! Command line: one file per subcommand, which converts flags to a recipe and makes one call.

mod bandwidth;
mod build_scene;
mod compare;
mod convert;
mod encode;
mod encode_lobes;
mod environment;
mod eval;
mod flatten;
mod generate;
mod info;
mod interrupt;
mod options;
mod plan;
mod progress;
mod pwt;
mod reading;
#[cfg(feature = "render")]
mod render;
mod report;
mod samples;
mod schema;
mod shader;
mod steps;
mod synth;
mod verify;
mod view;
mod watch;

#[cfg(feature = "render")]
use brdfc_terminal::graphics_environment;
use brdfc_terminal::{Common, Error, Flags, directions, inputs, output, run_program, table, usage};
use clap::{CommandFactory as _, Parser, Subcommand};
use std::process::ExitCode;

/// Compiles measured appearance (BRDFs from MERL, RGL, ALTA and goniometer scans, BTFs, RTI captures) into packed GPU
/// textures, each with its measured error.
#[derive(Debug, Parser)]
#[command(name = "brdfc", version, max_term_width = 110, after_help = after_help())]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    flags: Flags,
}

#[derive(Debug, Subcommand)]
enum Command {
    Build(build_scene::Arguments),
    Watch(watch::Arguments),
    Encode(encode::Arguments),
    Eval(eval::Arguments),
    Compare(compare::Arguments),
    Convert(convert::Arguments),
    Info(info::Arguments),
    Synth(synth::Arguments),
    Bandwidth(bandwidth::Arguments),
    Samples(samples::Arguments),
    Environment(environment::Arguments),
    Shader(shader::Arguments),
    Pwt(Box<pwt::Arguments>),
    Flatten(Box<flatten::Arguments>),
    #[cfg(feature = "render")]
    Render(Box<render::Arguments>),
    /// Not available: this program was built without its feature 'render'.
    #[cfg(not(feature = "render"))]
    Render {
        /// Anything.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        rest: Vec<String>,
    },
    View(view::Arguments),
    Report(report::Arguments),
    Verify(verify::Arguments),
    Plan(plan::Arguments),
    Schema(schema::Arguments),
    #[command(hide = true)]
    Generate(generate::Arguments),
}

impl Command {
    /// Returns the name of a command that prints no report.
    fn without_report(&self) -> Option<&'static str> {
        match self {
            Self::Eval(_) => Some("eval"),
            Self::Synth(_) => Some("synth"),
            Self::Generate(_) => Some("generate"),
            _ => None,
        }
    }
}

/// Commands that print a report.
const WITH_REPORT: &str = "bandwidth, build, compare, convert, encode, environment, flatten, info, plan, pwt, render, report, samples, shader, verify, view and watch";

const EXAMPLES: &str = "\
Examples:
  brdfc build scene.toml                              build the packs of a scene
  brdfc build scans --max-delta-e 1                   the smallest packs of a folder of scans
  brdfc watch scene.toml                              rebuild the packs when an input changes
  brdfc encode red-plastic.binary -o red.ktx2         the smallest pack without visible error
  brdfc encode paint.brdf -o paint.ktx2 --max-error 0.02
  brdfc compare paint.brdf paint.ktx2                 measure the error of the pack
  brdfc info paint.ktx2
  brdfc convert paint.brdf -o paint.binary            convert the scan for other programs
  brdfc render paint.ktx2 -o paint.png                draw the pack with the shaders of engines
  brdfc view paint.ktx2 paint.brdf -o paint.html      a page that draws the pack next to its source
  brdfc report packs -o report.html                   a page of renderings, errors and checks
  brdfc verify packs                                  check that every file is intact
  brdfc flatten synth:button -o button                the flat BTF of a surface with relief
  brdfc pwt icon -o icon.ktx2                         an RTI capture as a pack that can be relit
  brdfc bandwidth museum.exr -o museum.ktx2           a map of how fast the environment varies
  brdfc samples red-plastic.binary -o red.samples.ktx2
  brdfc environment museum.exr -o museum.env.ktx2     an environment for materials of --codec lobes
  brdfc shader table --language essl300               the decoder for an engine

INPUT is a path, - for stdin, or an analytic model such as 'synth:ward?ax=0.15&ay=0.5'.
'brdfc synth --help' lists the models.
";

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    a check failed (limit missed, comparison differs)
  2    wrong usage
  3    invalid input
  4    cannot read or write
  5    no usable graphics adapter
  6    internal error
  130  interrupted";

/// Help below the list of commands.
fn after_help() -> String {
    format!("{EXAMPLES}\nFiles: {}.\n\n{EXIT_CODES}", brdfc::inspect::known_files())
}

/// The command line.
fn command() -> clap::Command {
    let command = Cli::command()
        .mut_args(usage::with_common_settings)
        .mut_subcommands(|command| command.mut_args(usage::with_common_settings));
    // `--max-delta-e` of `render` checks the rendering, so the encoding option gets another name there.
    #[cfg(feature = "render")]
    let command = command.mut_subcommand("render", |command| command.mut_arg("pack_delta_e", pack_delta_e));
    command
}

/// The encoding option `--max-delta-e`, as `render` has it.
#[cfg(feature = "render")]
fn pack_delta_e(argument: clap::Arg) -> clap::Arg {
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    let missed = "If no pack meets the limit, the program draws the closest pack and prints a note, with exit code 0";
    argument.long("pack-delta-e").help(format!("{help}. {missed}"))
}

fn main() -> ExitCode {
    run_program("brdfc", command(), reading::with_values(std::env::args_os()), |cli: &Cli| &cli.flags, run)
}

fn run(cli: Cli, common: Common) -> Result<(), Error> {
    if let (true, Some(name)) = (common.json, cli.command.without_report()) {
        return Err(Error::usage(format!("--json does not apply to {name}, only to {WITH_REPORT}")));
    }
    match cli.command {
        Command::Build(arguments) => build_scene::run(&arguments, common),
        Command::Watch(arguments) => watch::run(&arguments, common),
        Command::Encode(arguments) => encode::run(&arguments, common),
        Command::Eval(arguments) => eval::run(&arguments, common),
        Command::Compare(arguments) => compare::run(&arguments, common),
        Command::Convert(arguments) => convert::run(&arguments, common),
        Command::Info(arguments) => info::run(&arguments, common),
        Command::Synth(arguments) => synth::run(&arguments),
        Command::Bandwidth(arguments) => bandwidth::run(&arguments, common),
        Command::Pwt(arguments) => pwt::run(&arguments, common),
        Command::Samples(arguments) => samples::run(&arguments, common),
        Command::Environment(arguments) => environment::run(&arguments, common),
        Command::Shader(arguments) => shader::run(&arguments, common),
        Command::Flatten(arguments) => flatten::run(&arguments, common),
        #[cfg(feature = "render")]
        Command::Render(arguments) => render::run(&arguments, common),
        #[cfg(not(feature = "render"))]
        Command::Render { .. } => Err(brdfc_terminal::without_renderer()),
        Command::Plan(arguments) => plan::run(&arguments, common),
        Command::View(arguments) => view::run(&arguments, common),
        Command::Report(arguments) => report::run(&arguments, common),
        Command::Verify(arguments) => verify::run(&arguments, common),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Generate(arguments) => generate::run(&arguments, command()),
    }
}
