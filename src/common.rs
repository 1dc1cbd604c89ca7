//! What the program hands every subcommand.

/// What every subcommand gets besides its own arguments.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    /// No progress and no remarks.
    pub quiet: bool,
    /// The report as JSON.
    pub json: bool,
}
