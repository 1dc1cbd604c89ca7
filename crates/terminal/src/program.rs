//! Program entry: from arguments to an exit code.

use super::{Common, Error, ErrorKind, Flags, output, usage};
use clap::FromArgMatches;
use std::ffi::OsString;
use std::io::Write as _;
use std::panic::AssertUnwindSafe;
use std::process::ExitCode;

/// Message after an interrupt.
pub const INTERRUPTED: &str = "interrupted; the output folder is unchanged";

/// Returns the error of a program that was built without the renderer.
pub fn without_renderer() -> Error {
    Error::no_adapter("no usable graphics adapter: this program was built without its feature 'render'")
}

/// Runs a program: parses its arguments, starts threads, does the work, prints errors and returns the exit code.
///
/// Errors begin with `name`; `flags` returns the common flags from the arguments.
pub fn run_program<A: FromArgMatches>(
    name: &str,
    command: clap::Command,
    words: impl IntoIterator<Item = OsString>,
    flags: impl FnOnce(&A) -> &Flags,
    work: impl FnOnce(A, Common) -> Result<(), Error>,
) -> ExitCode {
    let parsed = command.try_get_matches_from(words).and_then(|matches| A::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(error) => {
            if let Some(message) = usage::wrong_value(&error) {
                output::tell(&format!("{name}: {message}"));
                return ExitCode::from(2);
            }
            return match error.print().and_then(|()| std::io::stdout().flush()) {
                _ if error.use_stderr() => ExitCode::from(2),
                // A closed pipe is not an error: nothing reads the help.
                Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                    let error = Error::write("stdout", &error);
                    output::tell(&format!("{name}: {error}"));
                    ExitCode::from(error.kind().exit_code())
                }
                _ => ExitCode::SUCCESS,
            };
        }
    };
    let worked = std::panic::catch_unwind(AssertUnwindSafe(|| {
        let flags = flags(&arguments);
        let common = flags.common();
        start_threads(flags.jobs)?;
        work(arguments, common)
    }));
    match worked {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            match error.kind() {
                ErrorKind::Cancelled => output::tell(&format!("{name}: {INTERRUPTED}")),
                _ => output::tell(&format!("{name}: {error}")),
            }
            ExitCode::from(error.kind().exit_code())
        }
        Err(_) => {
            output::tell(&format!("{name}: internal error; please report it with the lines above and the input"));
            ExitCode::from(6)
        }
    }
}

/// Limits the number of threads, because hundreds of threads would only wait for each other.
fn start_threads(asked: usize) -> Result<(), Error> {
    const PER_CORE: usize = 4;
    let threads = asked.min(PER_CORE * std::thread::available_parallelism().map_or(1, usize::from));
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|error| Error::internal(format!("cannot start threads: {error}")))
}
