//! Flat BTFs (Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions"): a BTF over the
//! parameters of its meso-geometry, and a view-dependent indirection from the reference plane to these parameters. Byte
//! layout: `spec.md` in this folder.
//!
//! One asset is one file, [`FlatBtfFile`], whose images are types of this module. Surface coordinates are in tiles: the
//! tile is the unit square, repeated. Parameters also have period 1.

mod atlas;
mod decoder;
pub(crate) mod descriptor;
mod directions;
mod displacement;
pub mod factored;
mod file;
mod flat_view;
mod graphics_memory;
mod indirection;
mod layout;
mod maps;
pub mod shader;
mod view_weights;

pub use atlas::Atlas;
pub use decoder::{FlatBtfDecoder, FlatBtfParts, FlatValues, Indirection};
pub use directions::SampledDirections;
pub(crate) use displacement::HEADER as DISPLACEMENT_ENTRY;
pub use displacement::{DisplacementHeader, DisplacementMap, MAX_TANGENT, SAME_SIDE, TANGENT_BIAS};
pub use file::FlatBtfFile;
pub use flat_view::{FlatHeader, FlatView, MAX_DIRECTIONS, VisibilityMask, unit_vectors};
pub use graphics_memory::view_gpu_bytes;
pub use indirection::{IndirectionHeader, IndirectionMap, MAX_AZIMUTH_SAMPLES, MAX_ZENITH_SAMPLES};
pub use maps::{DiffuseMap, NormalMap, ReferenceMap};
pub use view_weights::{BlendedDirection, ViewWeights};

/// Maximum absolute value of a coordinate, height or distance in a file: tiles, or periods of the parameters.
pub const MAX_COORDINATE: f32 = 1024.0;
