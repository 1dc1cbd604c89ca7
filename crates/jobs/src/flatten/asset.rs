//! The report in a flat BTF's file: settings and measurements.

use crate::exposure::ExposureFacts;
use brdfc_flat_btf::encode::{AssetReport, FlattenRecipe, Reflectance, ReliefForm};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::bindings::Stored;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_pwt::PwtFacts;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The report in the file of a flat BTF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetFile {
    /// Layout of this file.
    pub version: u32,
    /// Name of the flat BTF, from which its file is named.
    pub name: String,
    /// Source of the asset: an address with all parameters, or file names without folders.
    pub source: String,
    /// Materials of a computed BTF.
    pub materials: Vec<String>,
    /// True if images over the tile coloured or mixed the materials.
    pub images_over_the_tile: bool,
    /// Settings of the encoder.
    pub settings: Settings,
    /// Measurements that the encoder made: sizes, errors and repairs.
    pub report: AssetReport,
    /// Exposure of measured images, if some are black or white everywhere or overexposed.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub exposure: Option<ExposureFacts>,
    /// Facts about the trees; only for the reflectance `pwt`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub trees: Option<PwtFacts>,
}

/// A flat BTF: the report in its file, and its sizes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FlatAsset {
    /// The report in the file.
    #[serde(flatten)]
    pub about: AssetFile,
    /// Bytes of the file.
    pub bytes: u64,
    /// Bytes of its textures on a GPU.
    pub gpu_bytes: u64,
    /// Bytes on a GPU of each bound texture, by its name in the shader.
    pub images: BTreeMap<String, u64>,
}

impl FlatAsset {
    /// Describes a flat BTF in a file of `bytes` bytes.
    pub fn new(about: AssetFile, file: &FlatBtfFile, bytes: u64) -> Self {
        let bindings = file.bindings();
        let stored = bindings.textures().filter(|(_, texels)| texels.stored != Stored::Empty);
        let images = stored.map(|(name, texels)| (name.to_owned(), texels.bytes.len() as u64)).collect();
        Self { about, bytes, gpu_bytes: bindings.gpu_bytes(), images }
    }
}

/// Settings of the encoder in reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Settings {
    /// Texels of the flat BTF per side.
    pub flat_texels: usize,
    /// Texels of the reference plane per side.
    pub texels: u32,
    /// Form of the relief.
    pub relief: ReliefForm,
    /// Name and number of the views; files are named without folders.
    pub views: (String, usize),
    /// Name and number of the lights.
    pub lights: (String, usize),
    /// Method of filling holes.
    pub fill: FillMethod,
    /// Rays per texel for light of one bounce.
    pub bounces: usize,
    /// Form of the reflectance.
    pub reflectance: Reflectance,
    /// Target of the reflectance.
    pub target: FactoredTarget,
    /// True if files are compressed with Zstandard.
    pub supercompression: bool,
}

impl Settings {
    /// The settings of a recipe. `supercompress` is true if files are compressed with Zstandard.
    pub(super) fn new(recipe: &FlattenRecipe, supercompress: bool) -> Self {
        Self {
            flat_texels: recipe.flat_texels,
            texels: recipe.texels,
            relief: recipe.relief,
            views: (recipe.views.name.clone(), recipe.views.len()),
            lights: (recipe.lights.name.clone(), recipe.lights.len()),
            fill: recipe.fill,
            bounces: recipe.bounces,
            reflectance: recipe.reflectance,
            target: recipe.target,
            supercompression: supercompress,
        }
    }
}

impl AssetFile {
    /// Share of the texels that no view sees; `None` without views.
    pub fn unseen(&self) -> Option<f64> {
        Some(self.report.never_seen? as f64 / (self.settings.flat_texels as f64).powi(2))
    }
}
