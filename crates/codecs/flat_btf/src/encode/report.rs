//! Measurements of a flat BTF.

use crate::factored::FactoredFacts;
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
    /// Mean share of texels that a view sees, 0 to 1.
    pub seen: f64,
    /// Texels that no view sees.
    pub never_seen: usize,
    /// Colour errors of the decoded asset.
    pub errors: AssetErrors,
    /// Number of factors that replace all views, and their errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factored: Option<FactoredFacts>,
}

/// Errors against the surface or the input images. Computed BTFs with light of one bounce have none, because the
/// reference contains direct light only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetErrors {
    /// Equation 1 at sampled views and lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_samples: Option<ColourErrors>,
    /// Equation 1 at random views and lights between the samples. `None` for measured BTFs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_samples: Option<ColourErrors>,
    /// The light form, normal map and diffuse colour, at the same views and lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light_form: Option<ColourErrors>,
    /// Error at `at_samples` before factorisation, where factors replace the views.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_at_samples: Option<ColourErrors>,
    /// Error at `between_samples` before factorisation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_between_samples: Option<ColourErrors>,
}
