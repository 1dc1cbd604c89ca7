//! What a flat BTF's file says of itself: how it was made and what was measured.

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
    /// The asset's name.
    pub name: String,
    /// What it was made from: an address with all parameters, or names of files without folders.
    pub source: String,
    /// Materials of a computed BTF.
    pub materials: Vec<String>,
    /// Whether images over the tile coloured the materials or mixed them.
    pub images_over_the_tile: bool,
    /// How it was made.
    pub settings: Settings,
    /// What was measured.
    pub report: AssetReport,
}

/// A flat BTF: the report in its file, and how large it is.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FlatAsset {
    /// What the file says.
    #[serde(flatten)]
    pub about: AssetFile,
    /// Bytes of the file.
    pub bytes: u64,
    /// Bytes of its textures on a GPU.
    pub gpu_bytes: u64,
    /// Of each texture that a shader has bound, by its name in the shader: bytes on a GPU.
    pub images: BTreeMap<String, u64>,
}

impl FlatAsset {
    /// A flat BTF of this report, in a file of so many bytes.
    pub fn new(about: AssetFile, file: &FlatBtfFile, bytes: u64) -> Self {
        let bindings = file.bindings();
        let stored = bindings.textures().filter(|(_, texels)| texels.stored != Stored::Empty);
        let images = stored.map(|(name, texels)| (name.to_owned(), texels.bytes.len() as u64)).collect();
        Self { about, bytes, gpu_bytes: bindings.gpu_bytes(), images }
    }
}

/// The settings as reports hold them.
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
    /// Set and number of the views: the set as it was named, a file without its folder.
    pub views: (String, usize),
    /// Set and number of the lights.
    pub lights: (String, usize),
    /// How holes were filled.
    pub fill: FillMethod,
    /// Rays per texel of the light of one bounce.
    pub bounces: usize,
    /// Rounds of stretch-reducing reweighting at most.
    pub stretch_rounds: usize,
    /// Which form was made.
    pub form: Form,
    /// Target of the factors that replace all views; none in the light form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factored: Option<FactoredTarget>,
    /// Whether displacements of two bytes replace the indirection map.
    #[serde(default)]
    pub compact: bool,
    /// Whether files are compressed with Zstandard.
    pub supercompression: bool,
}

impl Settings {
    /// The settings of a recipe; `supercompress`: whether files are compressed with Zstandard.
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
    /// Bytes that the values of all views would take on a GPU, stored as they are; 0 of the light form.
    pub fn gpu_bytes_of_views(&self) -> u64 {
        let Settings { flat_texels, views, lights, form, .. } = &self.settings;
        if *form == Form::Full { view_gpu_bytes(*flat_texels as u32, lights.1 as u32) * views.1 as u64 } else { 0 }
    }

    /// Share of the texels that no view sees.
    pub fn unseen(&self) -> f64 {
        self.report.never_seen as f64 / (self.settings.flat_texels as f64).powi(2)
    }
}
