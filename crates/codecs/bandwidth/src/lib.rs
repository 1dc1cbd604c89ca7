//! How fast materials, environments and textures vary: precomputed maps of local bandwidth (Bagher et al. 2012,
//! section 2.4 and appendix A).
//!
//! [`daubechies`] transforms, [`local`] finds the bandwidth around each pixel, [`lobe`], [`environment`] and [`texture`]
//! turn it into cycles per radian or per metre, and [`map`] puts that into the packs of `brdfc_formats::bandwidth`.

pub mod daubechies;
pub mod environment;
pub mod facts;
pub mod image;
pub mod lobe;
pub mod local;
pub mod map;
pub mod resolution;
pub mod texture;

/// `ε` of the paper: coefficients whose sum is below this share of the largest one do not count.
pub const DEFAULT_EPSILON: f64 = 0.01;
/// Range of `ε`: the rule needs small values.
pub const EPSILON_RANGE: [f64; 2] = [1e-4, 0.1];
