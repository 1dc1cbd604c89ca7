//! Flat BTFs (Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions"): a BTF over the
//! parameters of its meso-geometry, and a relief that leads to these parameters: layers of the meso-geometry, through which
//! rays march, or the paper's view-dependent indirection map. Byte layout: `spec.md` in this folder.
//!
//! One asset is one file, [`FlatBtfFile`], whose images are types of this module. Surface coordinates are in tiles: the
//! tile is the unit square, repeated. Parameters also have period 1.

mod compact;
mod decoder;
pub(crate) mod descriptor;
mod directions;
pub mod factored;
mod file;
mod flat_view;
mod layers;
mod layout;
mod march;
mod relief;
pub mod shader;
mod shadows;
mod vdim;
mod vdim_header;
mod view_weights;

pub use compact::CompactSamples;
pub use decoder::{FlatBtfDecoder, FlatBtfLook};
pub use directions::SampledDirections;
pub use file::FlatBtfFile;
pub use flat_view::{FlatHeader, FlatView, MAX_DIRECTIONS, VisibilityMask, unit_vectors};
pub use layers::{Column, LayerHeader, LayerMap, MAX_HEIGHT, Sheet};
pub use layout::MAX_DISPLACEMENT;
pub use march::{MAX_SLOPE, MacroSurface, MarchSteps, ReliefPoint};
pub use relief::{FlatBtfParts, Relief, StoredReflectance};
pub use shadows::ShadowMap;
pub use vdim::{SeenPoint, Vdim, VdimSamples};
pub use vdim_header::{AZIMUTH_ROWS, MAX_VDIM_SIZE, POLAR_ANGLES, VdimHeader};
pub(crate) use view_weights::raised;
pub use view_weights::{BlendedDirection, ViewWeights};
