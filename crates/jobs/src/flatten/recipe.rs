//! What is made of a meso-structure, resolved from flags before any work.

use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
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

impl Form {
    /// The names that scripts use.
    pub const NAMES: [(&'static str, Self); 2] = [("full", Self::Full), ("light", Self::Light)];
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
    /// Which parts are made.
    pub form: Form,
    /// What factors of the full form are to be like; `None` keeps every view as it is.
    pub factor: Option<FactoredTarget>,
    /// Whether displacements stand for the indirection map.
    pub compact: bool,
    /// Whether files are compressed with Zstandard.
    pub supercompress: bool,
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

impl FlattenRecipe {
    /// The settings for reports.
    pub fn settings(&self) -> Settings {
        let header = &self.indirection;
        Settings {
            flat_texels: self.flat_texels,
            texels: header.size,
            indirection: [header.zenith_samples, header.azimuth_samples],
            largest_angle: (f64::from(header.largest_angle).to_degrees() * 1e3).round() / 1e3,
            oversampling: self.oversampling,
            views: (self.views.name.clone(), self.views.len()),
            lights: (self.lights.name.clone(), self.lights.len()),
            fill: self.fill,
            bounces: self.bounces,
            stretch_rounds: self.rounds,
            form: self.form,
            factored: self.factor.filter(|_| self.form == Form::Full),
            compact: self.compact,
            supercompression: self.supercompress,
        }
    }
}
