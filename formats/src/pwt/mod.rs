//! Polynomial wavelet trees (Baril, Boubekeur, Gioia and Schlick 2008, "Polynomial wavelet trees for bidirectional
//! texture functions"): an image, or the views of a BTF, under any light from above. Byte layout: `spec.md` in this folder.
//!
//! Each texel is a polynomial of the light direction, or a sum of functions learned from photographs. Its coefficients are
//! stored in mipmapped textures; coefficients without fine detail have no fine levels.

mod basis;
mod decode;
pub(crate) mod descriptor;
mod domain;
mod header;
mod light_map;
mod pack;
pub mod shader;

pub use basis::{LightBasis, LightCoordinates, MAX_DEGREE, MAX_TERMS};
pub use decode::{PwtDecoder, UnpackedLevel};
pub use domain::{Domain, LARGEST};
pub use header::{
    Component, MAX_ARRAY_LAYERS, MAX_COMPONENTS, MAX_LEVEL, MAX_SIDE, MAX_TEXTURES, MAX_VIEWS, PWT_ENTRY, PwtErrors,
    PwtHeader, TextureHeader, Weights,
};
pub use light_map::{LightMap, MAP_SIDES};
pub use pack::{PwtPack, mesh_bytes};
