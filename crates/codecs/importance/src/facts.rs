//! Importance samples as files.

use brdfc_formats::importance::{ImportanceHeader, ImportancePack};

/// What is worth knowing about importance samples.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct ImportanceFacts {
    /// Polar angles of the outgoing direction.
    pub polar: u32,
    /// Its azimuths; 1 for isotropic materials.
    pub azimuths: u32,
    /// Samples of each outgoing direction.
    pub samples: u32,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
}

impl ImportanceFacts {
    /// Of a pack.
    pub fn new(pack: &ImportancePack) -> Self {
        let ImportanceHeader { polar, azimuths, samples } = pack.header();
        Self { polar, azimuths, samples, gpu_bytes: pack.gpu_bytes() }
    }
}
