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
    /// Polynomial wavelet trees of sampled views (Baril et al. 2008).
    Pwt,
}

/// Form of the relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum ReliefForm {
    /// Layers, through which rays march.
    Layers,
    /// A view-dependent indirection map (Hadim et al. 2009, section 3.4).
    Vdim(VdimRecipe),
}

/// Settings of a view-dependent indirection map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct VdimRecipe {
    /// Number of polar angles of the views.
    pub polar_angles: u32,
    /// Number of rows of azimuths, of which the last repeats the first.
    pub azimuth_rows: u32,
    /// Largest polar angle of the views, degrees.
    pub largest_angle: f64,
    /// Rays per texel and axis.
    pub oversampling: u32,
    /// True to sample the shadows of the lights; false leaves shadows out.
    pub shadows: bool,
    /// True to store two bytes per view for blocks of texels, at most 128 blocks per side.
    pub compact: bool,
}

/// Settings for flattening a meso-structure.
#[derive(Debug, Clone, PartialEq)]
pub struct FlattenRecipe {
    /// Texels of the reference plane per side: a power of two.
    pub texels: u32,
    /// Form of the relief.
    pub relief: ReliefForm,
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
