//! Maps of local bandwidth and their use in shading (Bagher et al. 2012, "Interactive rendering of acquired materials
//! on dynamic geometry using bandwidth prediction"). Layouts: `spec.md` and `propagation.md` in this folder.

pub(crate) mod descriptor;
mod limit;
mod map;
pub mod propagation;
pub mod shader;

pub use map::*;
