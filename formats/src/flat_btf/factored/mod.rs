//! Flat BTFs as a product of small textures, a few hundredths of the size of all views. Byte layout: `spec.md` in this
//! folder.
//!
//! A value is the colour of a base plus a sum, where light arrives. The base is a diffuse and a glossy reflection under
//! the texel's normal. The sum combines weights of the texel with components of the view and the light, in cube roots of
//! tristimulus values. Rays through the layers determine where light arrives; where values are not those of direct light
//! alone, a coarse residual corrects them.

mod base;
mod basis;
mod decode;
mod domain;
mod header;
mod maps;
pub mod shader;

pub use base::{
    Axis, BaseAngles, BaseMaterial, BaseTable, BaseTexel, LevelTable, MAX_ENTRY, TablePlace, slope_ranges, slope_texel,
    slope_words,
};
pub use basis::BasisMap;
pub(super) use decode::Place;
pub use decode::{FactoredFlatBtf, FactoredTexel};
pub use domain::{ChromaRange, cube_root, from_opponent, to_opponent};
pub use header::{
    BASE_LAYERS, DIFFERENCE_ANGLES, FactoredErrors, FactoredHeader, GROUP, HALF_ANGLES, MAX_BASE, MAX_GROUPS,
    MAX_MATERIALS,
};
pub(super) use header::{FACTORED, RESIDUAL_FORMAT};
pub(super) use maps::ByteLayers;
pub use maps::{ResidualMap, WeightMap, WeightRange};
