//! Facts about lobes.

use super::measure::RenderingError;
use brdfc_formats::lobes::{Anchor, LobesPack};

/// Facts about the lobes of a BRDF.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct LobesFacts {
    /// Number of look-ups in an environment.
    pub fetches: usize,
    /// Number of look-ups around the normal, the mirror direction and the direction to the viewer.
    pub anchors: [usize; 3],
    /// Number of view angles with weights.
    pub nodes: u32,
    /// Number of view azimuths with weights, 1 for isotropic materials.
    pub azimuths: u32,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
    /// ΔE (CIE76) of renderings of a ball, in environments that the fit did not use.
    pub delta_e: RenderingError,
}

impl LobesFacts {
    /// Facts of a pack.
    pub fn new(pack: &LobesPack) -> Self {
        let [mean, p95] = pack.header().delta_e;
        let count = |anchor: Anchor| pack.header().lobes.iter().filter(|lobe| lobe.anchor == anchor).count();
        Self {
            fetches: pack.fetches(),
            anchors: Anchor::ALL.map(count),
            nodes: pack.header().nodes,
            azimuths: pack.header().azimuths,
            gpu_bytes: pack.gpu_bytes(),
            delta_e: RenderingError { mean: f64::from(mean), p95: f64::from(p95) },
        }
    }
}
