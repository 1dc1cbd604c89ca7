//! Flags that every program has.

use brdfc_core::whole_number::whole_number;
use clap::Args;

/// Flags for threads and output.
#[derive(Debug, Args)]
#[command(next_help_heading = "Common options")]
pub struct Flags {
    /// Print no progress and no notes on stderr, only errors.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Number of threads, 0 to 1024 (default: 0, one per core). The program starts at most four threads per core. The
    /// number does not change the result.
    #[arg(
        long,
        short,
        global = true,
        value_name = "N",
        default_value_t = 0,
        value_parser = whole_number::<usize>(0..=1024),
    )]
    pub(crate) jobs: usize,
    /// Print the report as JSON (commands without a report reject it); 'brdfc schema' prints the schemas of reports.
    #[arg(long, global = true)]
    json: bool,
}

impl Flags {
    /// Returns the flags that commands need.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: self.json }
    }
}

/// Flags that every command gets in addition to its own arguments.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    /// No progress and no notes.
    pub quiet: bool,
    /// The report as JSON.
    pub json: bool,
}
