//! What the program hands every subcommand.

/// What every subcommand gets besides its own arguments.
#[derive(Debug, Clone, Copy)]
pub struct Common {
    pub quiet: bool,
}
