//! Shared parts of command-line programs: common flags, results on stdout, notes on stderr, tables, errors with exit codes.

mod common;
pub mod directions;
#[cfg(feature = "render")]
pub mod graphics_environment;
pub mod inputs;
pub mod output;
mod program;
pub mod table;
pub mod usage;
pub mod values;

pub use brdfc_core::words;
pub use brdfc_jobs::{Error, ErrorKind};
pub use common::{Common, Flags};
pub use program::{INTERRUPTED, run_program, without_renderer};
