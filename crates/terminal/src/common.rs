//! Flags that every program has.

use brdfc_core::whole_number::whole_number;
use clap::Args;

/// How a program works and talks, whatever it is asked to do.
#[derive(Debug, Args)]
pub struct Flags {
    /// No progress and no remarks on stderr; errors are still told.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Threads to work with, up to 1024; 0 is one per core, and no more than four per core are made. The result does not
    /// depend on it.
    #[arg(long, short, global = true, value_name = "N", default_value_t = 0, value_parser = whole_number::<usize>(0..=1024))]
    pub(crate) jobs: usize,
    /// Print the report as JSON, where there is one; 'brdfc schema' prints the schemas of reports.
    #[arg(long, global = true)]
    json: bool,
}

impl Flags {
    /// What commands need to know of them.
    pub fn common(&self) -> Common {
        Common { quiet: self.quiet, json: self.json }
    }
}

/// What every command gets besides its own arguments.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    /// No progress and no remarks.
    pub quiet: bool,
    /// The report as JSON.
    pub json: bool,
}
