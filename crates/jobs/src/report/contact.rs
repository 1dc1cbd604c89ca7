//! Contact sheet of materials drawn by the engines' shaders and compared with their sources.

use super::render::Verification;
use brdfc_core::words::bytes;
use brdfc_gpu::verify::Views;
use brdfc_render::contact_sheet::Cell;
use brdfc_render::rendering::{difference_panel, to_panel};
use brdfc_render::within::left_out_summary;
use schemars::JsonSchema;
use serde::Serialize;

/// One material of a sheet.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MaterialVerification {
    /// Name of the material, or the input.
    pub material: String,
    /// Bytes of its pack on a GPU.
    pub bytes_on_gpu: u64,
    /// Errors of its rendering. Every material has the exposure of its own rendering.
    #[serde(flatten)]
    pub verification: Verification,
}

impl MaterialVerification {
    /// Labelled renderings of source, shader and their difference.
    pub fn cell(&self, views: &Views) -> Cell {
        let exposure = self.verification.exposure;
        let reference = views.reference();
        let row = [
            views.source.as_ref().map(|source| to_panel(source, exposure)),
            Some(to_panel(&views.shader, exposure)),
            Some(difference_panel(&views.shader, reference, exposure)),
        ];
        let mean = self.verification.checked().delta_e.mean;
        let left_out = left_out_summary(self.verification.left_out);
        Cell {
            name: self.material.clone(),
            details: format!("{}  mean ΔE {mean:.2}{left_out}", bytes(self.bytes_on_gpu)),
            failed: self.closed().next().is_some(),
            rows: vec![row],
        }
    }

    /// Messages of the gates that failed.
    pub fn closed(&self) -> impl Iterator<Item = String> {
        self.verification.gates.iter().filter(|gate| !gate.passed).map(|gate| format!("{}: {gate}", self.material))
    }
}
