//! Flat BTFs as a product of small textures, some hundredths of what all views take. Byte layout: `spec.md` in this folder.
//!
//! A value is a shadow of its texel and light times a base, a diffuse and a glossy reflection under the texel's normal, and a
//! sum: weights of the texel, components of the view and the light. The sum is in cube roots of tristimulus values, shadows are
//! in linear light, so that both may be filtered.

mod base;
mod basis;
mod decode;
mod domain;
mod header;
mod maps;
pub mod shader;

pub use base::{BaseAngles, BaseTable, BaseTexel, MAX_BASE, slope_ranges, slope_texel, slope_words};
pub use basis::BasisMap;
pub use decode::{FactoredFlatBtf, FactoredTexel};
pub use domain::{ChromaRange, cube_root, from_opponent, to_opponent};
pub(crate) use header::FACTORED as FACTORED_ENTRY;
pub use header::{
    BASE_LAYERS, DIFFERENCE_ANGLES, FactoredErrors, FactoredHeader, GROUP, HALF_ANGLES, MAX_GROUPS, ShadowFormat,
};
pub use maps::{ShadowMap, WeightMap, WeightRange};
