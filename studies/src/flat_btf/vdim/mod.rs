//! View-dependent indirection maps (VDIM) of Hadim et al. 2009, the CPU reference of the study: the surface point that
//! a view sees behind each texel of the reference plane.

mod look_up;
mod map;
mod measure;

pub use map::{Displacement, Vdim, VdimHeader};
pub use measure::{OVERSAMPLING, indirection, seen_through_texels};
