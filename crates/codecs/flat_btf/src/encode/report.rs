//! What is measured of a flat BTF.

use crate::factored::FactoredFacts;
use crate::parameterise::SurfaceParameterisationReport;
use crate::probes::ColourErrors;
use crate::weld::WeldReport;
use serde::{Deserialize, Serialize};

/// What was measured of an asset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetReport {
    /// Repairs of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "repaired")]
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
    /// What `at_samples` would be with every view as it is, where factors replace them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_at_samples: Option<ColourErrors>,
    /// The same of `between_samples`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub views_between_samples: Option<ColourErrors>,
}
