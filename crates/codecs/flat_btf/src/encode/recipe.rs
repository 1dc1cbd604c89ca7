//! Settings of a flat BTF other than the surface and its appearance.

use crate::factored::FactoredTarget;
use crate::fill::FillMethod;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::IndirectionHeader;
use serde::{Deserialize, Serialize};

/// Parts to encode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// All parts: equation 1.
    Full,
    /// Without the flat BTF itself: normal map and diffuse colour.
    Light,
}

/// Settings for flattening a meso-structure.
#[derive(Debug, Clone, PartialEq)]
pub struct FlattenRecipe {
    /// Texels of the flat BTF per side: a power of two.
    pub flat_texels: usize,
    /// Size and views of the indirection map.
    pub indirection: IndirectionHeader,
    /// Rays per texel and axis for the indirection map.
    pub oversampling: usize,
    /// Sampled directions to the viewer.
    pub views: DirectionSet,
    /// Sampled directions to the light.
    pub lights: DirectionSet,
    /// Method for filling holes.
    pub fill: FillMethod,
    /// Rays per texel that gather the light of one bounce; 0 disables it.
    pub bounces: usize,
    /// Maximum rounds of stretch-reducing reweighting.
    pub rounds: usize,
    /// Target of the factors that replace all views in the full form; `None` selects the light form.
    pub factored: Option<FactoredTarget>,
}

impl FlattenRecipe {
    /// Parts to encode: the full form if there is a target of factors, otherwise the light form.
    pub fn form(&self) -> Form {
        if self.factored.is_some() { Form::Full } else { Form::Light }
    }
}
