//! The command line: one file per subcommand, flags to a resolved recipe to one call.

mod bandwidth;
mod bench;
mod build_scene;
mod common;
mod compare;
mod encode;
mod error;
mod eval;
mod flatten;
#[cfg(feature = "render")]
mod graphics_environment;
mod info;
mod interrupt;
mod options;
mod output;
mod progress;
#[cfg(feature = "render")]
mod render;
mod report;
mod samples;
mod schema;
mod steps;
mod synth;
mod table;

pub use error::CliError;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use common::Common;
use std::process::ExitCode;

/// Compiles measured appearance (MERL, RGL, ALTA, gonioreflectometer scans) into packed GPU textures, each with its
/// measured error.
#[derive(Debug, Parser)]
#[command(name = "brdfc", version, max_term_width = 110, after_help = after_help())]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// No progress and no remarks on stderr; errors are still told.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Threads to work with; 0 is one per core. The result does not depend on it.
    #[arg(long, short, global = true, value_name = "N", default_value_t = 0)]
    jobs: usize,
}

#[derive(Debug, Subcommand)]
enum Command {
    Build(build_scene::Arguments),
    Encode(encode::Arguments),
    Eval(eval::Arguments),
    Compare(compare::Arguments),
    Info(info::Arguments),
    Synth(synth::Arguments),
    Bandwidth(bandwidth::Arguments),
    Samples(samples::Arguments),
    Flatten(Box<flatten::Arguments>),
    #[cfg(feature = "render")]
    Render(Box<render::Arguments>),
    /// Not in this program: it was built without its feature 'render'.
    #[cfg(not(feature = "render"))]
    Render {
        /// Anything.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        rest: Vec<String>,
    },
    Report(report::Arguments),
    Bench(bench::Arguments),
    Schema(schema::Arguments),
}

const EXAMPLES: &str = "\
Examples:
  brdfc build scene.toml                              make the packs of a scene
  brdfc encode red-plastic.binary -o red.ktx2         make the smallest pack that looks right
  brdfc encode paint.brdf -o paint.ktx2 --max-error 0.02
  brdfc compare paint.brdf paint.ktx2                 how wrong is it?
  brdfc info paint.ktx2
  brdfc render paint.ktx2 -o paint.png                what does it look like?
  brdfc flatten synth:button -o button                flat BTF of a surface with relief
  brdfc bandwidth museum.exr -o museum.ktx2           how fast does it vary?
  brdfc samples red-plastic.binary -o red.samples.ktx2

INPUT is a path or an analytic model such as synth:ward?kd=0.2&ks=0.1&ax=0.15&ay=0.5 ('brdfc synth --help' lists them).
";

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 a check failed (error budget missed, comparison differs); 2 wrong usage; 3 invalid input;
4 cannot read or write; 5 no usable graphics adapter; 6 internal error; 130 interrupted.";

/// What stands below the list of commands.
fn after_help() -> String {
    format!("{EXAMPLES}\nFiles: {}.\n\n{EXIT_CODES}", brdfc_source::open::known_files())
}

/// Runs the program: parses arguments, does the work, prints errors, gives the exit code.
fn main() -> ExitCode {
    // A negative number is a value, for which a check says what is allowed, and no flag.
    let negatives = |argument: clap::Arg| argument.allow_negative_numbers(true);
    let command = Cli::command().mut_args(negatives).mut_subcommands(|command| command.mut_args(negatives));
    // There the flag of this name is a check of the picture.
    #[cfg(feature = "render")]
    let command = command
        .mut_subcommand("render", |command| command.mut_arg("pack_delta_e", |argument| argument.long("pack-delta-e")));
    let parsed = command.try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { 0 };
            // A closed pipe is no reason to complain about help that nobody reads.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let worked = std::panic::catch_unwind(|| run(cli));
    match worked {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            if let Some(message) = error.message() {
                output::tell(&format!("brdfc: {message}"));
            }
            ExitCode::from(error.exit_code())
        }
        Err(_) => {
            output::tell("brdfc: internal error; please report it with the lines above and the input");
            ExitCode::from(6)
        }
    }
}

fn run(cli: Cli) -> Result<(), CliError> {
    if cli.jobs > 1024 {
        return Err(CliError::Usage(format!("--jobs: found {}; allowed 0 to 1024", cli.jobs)));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(cli.jobs)
        .build_global()
        .map_err(|error| CliError::Internal(format!("cannot start threads: {error}")))?;
    let common = Common { quiet: cli.quiet };
    match cli.command {
        Command::Build(arguments) => build_scene::run(&arguments, common),
        Command::Encode(arguments) => encode::run(&arguments, common),
        Command::Eval(arguments) => eval::run(&arguments, common),
        Command::Compare(arguments) => compare::run(&arguments, common),
        Command::Info(arguments) => info::run(&arguments),
        Command::Synth(arguments) => synth::run(&arguments),
        Command::Bandwidth(arguments) => bandwidth::run(&arguments, common),
        Command::Samples(arguments) => samples::run(&arguments, common),
        Command::Flatten(arguments) => flatten::run(&arguments, common),
        #[cfg(feature = "render")]
        Command::Render(arguments) => render::run(&arguments, common),
        #[cfg(not(feature = "render"))]
        Command::Render { .. } => Err(CliError::without_renderer()),
        Command::Report(arguments) => report::run(&arguments, common),
        Command::Bench(arguments) => bench::run(&arguments, common),
        Command::Schema(arguments) => schema::run(&arguments),
    }
}
