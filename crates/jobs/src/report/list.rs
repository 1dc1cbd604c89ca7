//! What lists the parts of a material for whoever loads them.

use super::material::MaterialReport;
use crate::scene::maps::{MapsReport, part_name};
use crate::scene::run::Made;
use serde::Serialize;
use std::collections::BTreeMap;

/// The parts of a material, as `<material>.json` lists them.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct MaterialFile {
    /// Layout of this file.
    pub version: u32,
    /// The material's name.
    pub material: String,
    /// Files of the material, by part: `brdf` is the pack; where an environment lights the scene, `bandwidth` is
    /// the bandwidth map and `samples` are the importance samples.
    pub parts: BTreeMap<String, String>,
    /// What was measured.
    pub report: MaterialReport,
    /// What the maps hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maps: Option<MapsReport>,
}

/// The bytes of `<material>.json`.
pub fn list_of(name: &str, made: &Made) -> Vec<u8> {
    let parts = made.files.iter().map(|(part, _)| ((*part).to_owned(), part_name(name, part))).collect();
    let (material, report, maps) = (name.to_owned(), made.report.clone(), made.maps.clone());
    json_file(&MaterialFile { version: 1, material, parts, report, maps })
}

/// A file of JSON, for people and programs.
pub fn json_file(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(value).expect("reports are plain data");
    bytes.push(b'\n');
    bytes
}
