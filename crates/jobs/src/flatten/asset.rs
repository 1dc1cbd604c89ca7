//! The list of an asset's parts, with its settings and what was measured.

use brdfc_flat_btf::encode::{AssetReport, FlattenRecipe, Form};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::{FlatPart, gpu_bytes};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The contents of `NAME.json`.
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
    /// Files by part; see `formats/src/flat_btf/spec.md`.
    pub parts: BTreeMap<String, PartFile>,
    /// What was measured.
    pub report: AssetReport,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PartFile {
    /// Its name.
    pub file: String,
    /// Its bytes.
    pub bytes: u64,
    /// Bytes of texels on a GPU, as `formats/src/flat_btf/spec.md` counts them: with the unused tiles of a view's layer, and 0
    /// of a part that no shader reads.
    pub gpu_bytes: u64,
    /// BLAKE3 hash of its bytes, hexadecimal: a part of another asset is not taken for this one.
    pub blake3: String,
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
    /// Which parts were made.
    pub form: Form,
    /// What was asked of the factors that stand for all views; nothing where views are stored as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factored: Option<FactoredTarget>,
    /// Whether displacements of two bytes stand for the indirection map.
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
            form: recipe.form,
            factored: recipe.factored(),
            compact: recipe.compact,
            supercompression: supercompress,
        }
    }
}

impl AssetFile {
    /// Bytes of all files.
    pub fn bytes(&self) -> u64 {
        self.parts.values().map(|part| part.bytes).sum()
    }

    /// Bytes of all texels on a GPU, in the full form where there are views.
    pub fn gpu_bytes(&self) -> u64 {
        self.parts.values().map(|part| part.gpu_bytes).sum()
    }

    /// Bytes that the values of all views would take on a GPU, stored as they are; 0 of the light form.
    pub fn gpu_bytes_of_views(&self) -> u64 {
        let Settings { flat_texels, views, lights, form, .. } = &self.settings;
        let extent = Extent::D2Array([*flat_texels as u32, *flat_texels as u32, lights.1 as u32]);
        if *form == Form::Full { gpu_bytes(FlatPart::View.name(), extent, 1) * views.1 as u64 } else { 0 }
    }

    /// Share of the texels that no view sees.
    pub fn unseen(&self) -> f64 {
        self.report.never_seen as f64 / (self.settings.flat_texels as f64).powi(2)
    }
}
