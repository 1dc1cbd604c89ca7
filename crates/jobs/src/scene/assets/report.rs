//! Measurements of the pack of an asset.

use crate::report::gate::GateResult;
use brdfc_codec::Budget;
use brdfc_core::words::{apart, counted};
use serde::{Deserialize, Serialize};

/// Contents of the pack of an asset, and its errors against the source.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetReport {
    /// Columns and rows of an image, or texels along the sides of a face.
    pub size: [u32; 2],
    /// Number of images: views times lights, or faces of a cube.
    pub images: usize,
    /// Number of texture fetches of a look-up; absent for environments.
    pub fetches: Option<u32>,
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Bytes on a GPU, including mipmaps.
    pub bytes_on_gpu: u64,
    /// PSNR of sRGB levels against the photographs, dB; absent for environments.
    pub psnr: Option<f64>,
    /// Mean ΔE (CIE76) against the photographs; absent for environments, and if the photographs have nothing to measure.
    pub delta_e: Option<f64>,
    /// The target that no pack meets.
    pub missed: Option<String>,
    /// Statements of the source that were applied, and what was left out.
    pub notes: Vec<String>,
}

impl AssetReport {
    /// Checks the pack against its limits. A limit with nothing to measure fails.
    pub(super) fn check(&self, limits: &Budget) -> Vec<GateResult> {
        let of_delta_e = limits.delta_e.map(|limit| {
            let found = self.delta_e.map_or("no photographs to compare with".to_owned(), |found| {
                format!("a mean of {}", apart(found, limit))
            });
            let passed = self.delta_e.is_some_and(|found| found <= limit);
            GateResult::new("require.max_delta_e", found, format!("a mean of at most {limit}"), passed)
        });
        let of_bytes = limits.bytes.map(|limit| {
            let (found, allowed) = (self.bytes_on_gpu, format!("at most {}", counted(limit as usize, "byte")));
            GateResult::new("require.max_bytes", format!("{found} bytes"), allowed, found <= limit)
        });
        let of_fetches = limits.fetches.map(|limit| {
            let found = self.fetches.map_or("no look-ups of its own".to_owned(), |found| found.to_string());
            let passed = self.fetches.is_some_and(|found| found <= limit);
            GateResult::new("require.max_fetches", found, format!("at most {limit}"), passed)
        });
        of_delta_e.into_iter().chain(of_bytes).chain(of_fetches).collect()
    }
}
