//! What a gate saw: a limit that a finished pack or rendering is held against.

use serde::{Deserialize, Serialize};

/// A limit, and what was found. A gate that saw nothing did not pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct GateResult {
    /// Which, by its key.
    pub gate: String,
    /// What was found: a number, or why there is none.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
    /// Whether it is open.
    pub passed: bool,
}

impl GateResult {
    /// Of a gate by this name.
    pub fn new(gate: &str, found: impl Into<String>, allowed: impl Into<String>, passed: bool) -> Self {
        Self { gate: gate.to_owned(), found: found.into(), allowed: allowed.into(), passed }
    }
}

impl std::fmt::Display for GateResult {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { gate, found, allowed, .. } = self;
        write!(f, "{gate}: found {found}, expected {allowed}")
    }
}
