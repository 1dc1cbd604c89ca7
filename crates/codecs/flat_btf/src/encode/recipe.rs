//! Settings of a flat BTF other than the surface and its appearance.

use crate::factored::FactoredTarget;
use crate::fill::FillMethod;
use brdfc_formats::direction_set::DirectionSet;
use serde::{Deserialize, Serialize};

/// Form of the reflectance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reflectance {
    /// The smaller form that meets the target.
    Auto,
    /// A normal, a tint and a share of the second material for each texel, with a table of gloss and a diffuse albedo for
    /// each of at most two known materials.
    Brdf,
    /// Components of sampled views and lights in addition.
    Factors,
}

/// Settings for flattening a meso-structure.
#[derive(Debug, Clone, PartialEq)]
pub struct FlattenRecipe {
    /// Texels of the layers per side: a power of two.
    pub texels: u32,
    /// Texels of the flat BTF per side: a power of two.
    pub flat_texels: usize,
    /// Sampled directions to the viewer.
    pub views: DirectionSet,
    /// Sampled directions to the light.
    pub lights: DirectionSet,
    /// Method for filling holes.
    pub fill: FillMethod,
    /// Rays per texel that gather the light of one bounce; 0 disables it.
    pub bounces: usize,
    /// Form of the reflectance.
    pub reflectance: Reflectance,
    /// Target of the reflectance.
    pub target: FactoredTarget,
}

impl FlattenRecipe {
    /// Maximum rounds of reweighting, which gives stretched areas more texels.
    pub(super) const ROUNDS: usize = 5;
}
