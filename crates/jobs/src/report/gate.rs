//! Results of gates: limits that finished packs and renderings are checked against.

use crate::encode::Message;
use serde::{Deserialize, Serialize};

/// Beginning of the reason why there is no value, such as "no light: all surfaces are black".
const NOTHING: &str = "no ";

/// A limit and the value that was found. A gate with nothing to measure fails.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct GateResult {
    /// Key of the gate.
    pub gate: String,
    /// The value that was found; if there is none, the reason, which begins with "no".
    pub found: String,
    /// Limit that the value has to meet, such as `at most 0.5`.
    pub allowed: String,
    /// True if the gate passed.
    pub passed: bool,
}

impl GateResult {
    /// Result of the gate with the key `gate`.
    pub fn new(gate: &str, found: impl Into<String>, allowed: impl Into<String>, passed: bool) -> Self {
        Self { gate: gate.to_owned(), found: found.into(), allowed: allowed.into(), passed }
    }
}

impl GateResult {
    /// The message with the position of the key.
    pub fn message(&self) -> Message {
        let Self { gate, found, allowed, .. } = self;
        let text = if found.starts_with(NOTHING) {
            format!(": {found}; expected {allowed}")
        } else {
            format!(": found {found}, expected {allowed}")
        };
        Message::default().with_key(gate).with_text(text)
    }
}

impl std::fmt::Display for GateResult {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.message().fmt(f)
    }
}
