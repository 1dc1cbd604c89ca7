//! The report in a flat BTF's file: settings and measurements.

use brdfc_flat_btf::encode::{AssetReport, FlattenRecipe, Form};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::bindings::Stored;
use brdfc_formats::flat_btf::{FlatBtfFile, view_gpu_bytes};
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
    /// Polar angles and azimuths of the indirection map.
    pub indirection: [u32; 2],
    /// Largest polar angle of the indirection map, degrees.
    pub largest_angle: f64,
    /// Rays per texel and axis.
    pub oversampling: usize,
    /// Name and number of the views; files are named without folders.
    pub views: (String, usize),
    /// Name and number of the lights.
    pub lights: (String, usize),
    /// Method of filling holes.
    pub fill: FillMethod,
    /// Rays per texel for light of one bounce.
    pub bounces: usize,
    /// Maximum rounds of stretch-reducing reweighting.
    pub stretch_rounds: usize,
    /// Form of the flat BTF.
    pub form: Form,
    /// Target of the factors that replace all views; absent in the light form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factored: Option<FactoredTarget>,
    /// True if two-byte displacements replace the indirection map.
    #[serde(default)]
    pub compact: bool,
    /// True if files are compressed with Zstandard.
    pub supercompression: bool,
}

impl Settings {
    /// The settings of a recipe. `supercompress` is true if files are compressed with Zstandard.
    pub(super) fn new(recipe: &FlattenRecipe, supercompress: bool) -> Self {
        let header = &recipe.indirection;
        Self {
            flat_texels: recipe.flat_texels,
            texels: header.size,
            indirection: [header.zenith_samples, header.azimuth_samples],
            largest_angle: (f64::from(header.largest_angle).to_degrees() * 1e3).round() / 1e3,
            oversampling: recipe.oversampling,
            views: (recipe.views.name.clone(), recipe.views.len()),
            lights: (recipe.lights.name.clone(), recipe.lights.len()),
            fill: recipe.fill,
            bounces: recipe.bounces,
            stretch_rounds: recipe.rounds,
            form: recipe.form(),
            factored: recipe.factored,
            compact: true,
            supercompression: supercompress,
        }
    }
}

impl AssetFile {
    /// Bytes on a GPU of the values of all views without factoring; 0 for the light form.
    pub fn gpu_bytes_of_views(&self) -> u64 {
        let Settings { flat_texels, views, lights, form, .. } = &self.settings;
        if *form == Form::Full { view_gpu_bytes(*flat_texels as u32, lights.1 as u32) * views.1 as u64 } else { 0 }
    }

    /// Share of the texels that no view sees.
    pub fn unseen(&self) -> f64 {
        self.report.never_seen as f64 / (self.settings.flat_texels as f64).powi(2)
    }
}
