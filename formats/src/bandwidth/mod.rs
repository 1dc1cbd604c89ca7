//! Maps of local bandwidth and their use in shading (Bagher et al. 2012, "Interactive rendering of acquired materials on
//! dynamic geometry using bandwidth prediction"). Layouts: `spec.md` and `propagation.md` in this folder.

mod limit;
mod map;
pub mod propagation;
pub mod shader;

pub use map::*;
