//! What is told of a pack that was tried.

use super::{BrdfReport, Encoded};
use serde::{Deserialize, Serialize};

/// One pack that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Trial {
    /// `table`, `factored` or `wavelet`.
    pub codec: String,
    /// Nodes per axis, with those of a curve, or slices.
    pub size: String,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Texture fetches of a look-up.
    pub fetches: u32,
    /// Mean ΔE*ab of pictures.
    pub delta_e: f64,
    /// Its 95th percentile.
    pub delta_e_p95: f64,
    /// `ε_r` off the grid, a fraction.
    pub relative_error: f64,
    /// Whether it meets the budget.
    pub meets: bool,
}

impl Trial {
    /// A pack that was tried, with the report of its codec.
    pub fn new<R>(made: &Encoded<R>, report: &dyn BrdfReport, meets: bool) -> Self {
        let picture = &made.off_grid.picture.delta_e;
        Self {
            codec: report.variant().to_owned(),
            size: report.size(),
            bytes_on_gpu: made.pack.gpu_bytes(),
            fetches: made.pack.fetches(),
            delta_e: picture.mean,
            delta_e_p95: picture.p95,
            relative_error: made.off_grid.norms.relative_mean,
            meets,
        }
    }
}
