//! Table packs: logarithms of `f_r` over half-difference angles in one 3D texture that a sampler filters. Factored
//! packs add a curve over `θ_h`. Layout and equations: `spec.md` in this folder.

mod brdf;
mod coordinates;
mod curve;
mod decode;
pub(crate) mod descriptor;
mod header;
mod pack;
pub mod shader;

pub use coordinates::{Angles, Folded, Position, TableSymmetry};
pub use curve::Curve;
pub use decode::{LogValues, TableDecoder};
pub use header::{Axes, KNOTS, TableHeader};
pub use pack::TablePack;
