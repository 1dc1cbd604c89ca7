//! The list of a material's parts, for programs that load them.

use super::material::MaterialReport;
use crate::scene::maps::MapsReport;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Layout of the file.
pub const MATERIAL_VERSION: u32 = 1;

/// The parts of a material, as `<material>.json` lists them.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MaterialFile {
    /// Layout of this file.
    pub version: u32,
    /// The material's name.
    pub material: String,
    /// Files of the material, by part: `brdf` is the pack; where an environment lights the scene, `bandwidth` is
    /// the bandwidth map and `samples` are the importance samples.
    pub parts: BTreeMap<String, String>,
    /// Measurements of the pack.
    pub report: MaterialReport,
    /// Contents of the maps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maps: Option<MapsReport>,
}

impl MaterialFile {
    /// The bytes of `<material>.json`.
    pub fn to_bytes(&self) -> Vec<u8> {
        json_file(self)
    }
}

/// Writes a value as an indented JSON file.
pub fn json_file(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(value).expect("reports are plain data");
    bytes.push(b'\n');
    bytes
}
