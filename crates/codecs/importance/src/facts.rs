//! Facts about packs of importance samples.

use brdfc_formats::importance::{ImportanceHeader, ImportancePack};

/// Facts about importance samples.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct ImportanceFacts {
    /// Number of polar angles of the outgoing direction.
    pub polar: u32,
    /// Number of azimuths of the outgoing direction; 1 for isotropic materials.
    pub azimuths: u32,
    /// Samples per outgoing direction.
    pub samples: u32,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
}

impl ImportanceFacts {
    /// Facts of a pack.
    pub fn new(pack: &ImportancePack) -> Self {
        let ImportanceHeader { polar, azimuths, samples } = pack.header();
        Self { polar, azimuths, samples, gpu_bytes: pack.gpu_bytes() }
    }
}
