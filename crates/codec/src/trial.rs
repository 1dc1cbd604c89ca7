//! Measurements of a pack that a search tried.

use serde::{Deserialize, Serialize};

/// A pack that a search tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Trial {
    /// The variant of its codec, as `--codec` takes it.
    pub codec: String,
    /// Its size in units of its codec: nodes per axis (with those of a curve), or slices.
    pub size: String,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Texture fetches of a look-up.
    pub fetches: u32,
    /// Mean ΔE*ab of renderings.
    pub delta_e: f64,
    /// Its 95th percentile.
    pub delta_e_p95: f64,
    /// `ε_r` at independent test directions, a fraction.
    pub relative_error: f64,
    /// Smallest retained share of the highlight's light over all incoming directions; absent without a highlight.
    #[serde(default)]
    pub highlight: Option<f64>,
    /// True if it meets the budget.
    pub meets: bool,
}
