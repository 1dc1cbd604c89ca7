//! Measurements of a pack that a search tried.

use serde::{Deserialize, Serialize};

/// A pack that a search tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Trial {
    /// Variant of the pack's codec, as `--codec` takes it.
    pub codec: String,
    /// Size of the pack in units of its codec: nodes per axis (and nodes of a curve), or slices.
    pub size: String,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Texture fetches of a look-up.
    pub fetches: u32,
    /// Mean ΔE (CIE76) of renderings.
    pub delta_e: f64,
    /// 95th percentile of ΔE (CIE76).
    pub delta_e_p95: f64,
    /// `ε_r` at independent test directions, a fraction.
    pub relative_error: f64,
    /// Minimum retained share of the highlight's light over all incoming directions; absent without a highlight.
    #[serde(default)]
    pub highlight: Option<f64>,
    /// True if the pack meets the limits.
    pub meets: bool,
}
