//! Measurements of a flat BTF.

use super::recipe::Reflectance;
use crate::factored::FactoredFacts;
use crate::far::FarLevel;
use crate::layers::LayerReport;
use crate::parameterise::SurfaceParameterisationReport;
use crate::probes::ColourErrors;
use crate::weld::WeldReport;
use serde::{Deserialize, Serialize};

/// Measurements of an encoded flat BTF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetReport {
    /// Repairs of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "repaired")]
    pub repairs: Option<WeldReport>,
    /// Quality of the parameterisation.
    pub parameterisation: SurfaceParameterisationReport,
    /// Lowest and highest point of the surface, in tiles.
    pub heights: [f64; 2],
    /// Sheets of the layers, and what they leave out; absent for an indirection map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<LayerReport>,
    /// Form of the reflectance that was chosen: `brdf`, `factors` or `pwt`.
    pub reflectance: Reflectance,
    /// Mean share of texels that a view sees, 0 to 1; absent for `brdf`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seen: Option<f64>,
    /// Texels that no view sees; absent for `brdf`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub never_seen: Option<usize>,
    /// Colour errors of the decoded asset.
    pub errors: AssetErrors,
    /// Mipmap levels with tables of their own; empty for `factors` and `pwt`.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub far: Vec<FarLevel>,
    /// Number of components, and their errors; absent for `pwt`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub factored: Option<FactoredFacts>,
}

/// Errors against the surface or the input images. Computed BTFs with light of one bounce have none, because the
/// reference contains direct light only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetErrors {
    /// The surface itself at random views and lights. `None` for measured BTFs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_surface: Option<ColourErrors>,
    /// Images of a measured BTF, at its views and lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_images: Option<ColourErrors>,
}
