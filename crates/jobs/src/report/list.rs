//! The list of a material's parts, for programs that load them.

use super::material::MaterialReport;
use crate::scene::maps::MapsReport;
use brdfc_source::read::{MAX_TEXT_BYTES, read_regular_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Layout of the file.
pub const MATERIAL_VERSION: u32 = 1;

/// The parts of a material, as `<material>.json` lists them.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MaterialFile {
    /// Layout of this file.
    pub version: u32,
    /// The material's name.
    pub material: String,
    /// Files of the material, by part: `brdf` is the pack; where an environment lights the material, `lobes` are its
    /// lobes, `bandwidth` is the bandwidth map and `samples` are the importance samples.
    pub parts: BTreeMap<String, String>,
    /// Measurements of the pack.
    pub report: MaterialReport,
    /// Contents of the lobes and maps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maps: Option<MapsReport>,
}

impl MaterialFile {
    /// The bytes of `<material>.json`.
    pub fn to_bytes(&self) -> Vec<u8> {
        json_file(self)
    }

    /// The names of such files in a folder, sorted.
    pub fn names_in(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let jsons =
            entries.filter(|path| path.extension().is_some_and(|extension| extension == "json") && path.is_file());
        let is_list = |path: &PathBuf| {
            read_regular_file(path, MAX_TEXT_BYTES).is_ok_and(|bytes| serde_json::from_slice::<Self>(&bytes).is_ok())
        };
        let lists = jsons.filter(is_list).filter_map(|path| Some(path.file_name()?.to_str()?.to_owned()));
        let mut names: Vec<String> = lists.collect();
        names.sort();
        names
    }
}

/// Writes a value as an indented JSON file.
pub fn json_file(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(value).expect("reports are plain data");
    bytes.push(b'\n');
    bytes
}
