//! Everything that decides a flat BTF besides the surface and its appearance.

use crate::factored::FactoredTarget;
use crate::fill::FillMethod;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::IndirectionHeader;
use serde::{Deserialize, Serialize};

/// Which parts are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Everything: equation 1.
    Full,
    /// Without the flat BTF itself: normal map and diffuse colour.
    Light,
}

/// How a meso-structure is flattened.
#[derive(Debug, Clone, PartialEq)]
pub struct FlattenRecipe {
    /// Texels of the flat BTF per side: a power of two.
    pub flat_texels: usize,
    /// Size and views of the indirection map.
    pub indirection: IndirectionHeader,
    /// Rays per texel and axis for the indirection map.
    pub oversampling: usize,
    /// Views.
    pub views: DirectionSet,
    /// Lights.
    pub lights: DirectionSet,
    /// How holes are filled.
    pub fill: FillMethod,
    /// Rays per texel that gather the light of one bounce; 0: none.
    pub bounces: usize,
    /// Rounds of stretch-reducing reweighting at most.
    pub rounds: usize,
    /// What the factors of the full form are to be like, which replace all views; `None` makes the light form.
    pub factored: Option<FactoredTarget>,
}

impl FlattenRecipe {
    /// Which parts are made.
    pub fn form(&self) -> Form {
        if self.factored.is_some() { Form::Full } else { Form::Light }
    }
}
