//! What is written: the list of an asset's parts and what was measured.

use super::recipe::{Form, Settings};
use brdfc_flat_btf::factored::FactoredFacts;
use brdfc_flat_btf::parameterise::SurfaceParameterisationReport;
use brdfc_flat_btf::probes::ColourErrors;
use brdfc_flat_btf::weld::WeldReport;
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

/// What was measured of an asset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetReport {
    /// What was mended in a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "mended")]
    pub repairs: Option<WeldReport>,
    /// The parameterisation.
    pub parameterisation: SurfaceParameterisationReport,
    /// Lowest and highest point of the surface, in tiles.
    pub heights: [f64; 2],
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// Texels that no view sees.
    pub never_seen: usize,
    /// Errors of what a shader sees.
    pub errors: AssetErrors,
    /// Of factors in place of all views: how many there are, and how far they are from the views.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factored: Option<FactoredFacts>,
}

/// Errors against what the surface shows, or the images that came in. Where light of one bounce was asked for there are
/// none of computed BTFs: the comparison knows direct light only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetErrors {
    /// Equation 1 at sampled views and lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_samples: Option<ColourErrors>,
    /// Equation 1 at random views and lights between the samples. Not known for measured BTFs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_samples: Option<ColourErrors>,
    /// The light form, normal map and diffuse colour, at the same views and lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light_form: Option<ColourErrors>,
    /// What `at_samples` would be with every view as it is, where factors stand for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_at_samples: Option<ColourErrors>,
    /// The same of `between_samples`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_between_samples: Option<ColourErrors>,
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
