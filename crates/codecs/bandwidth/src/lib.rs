//! Maps of the local bandwidth of materials, environments and textures, precomputed as by Bagher et al. 2012, section
//! 2.4 and appendix A.
//!
//! [`daubechies`] transforms, [`local`] finds the bandwidth around each pixel, [`lobe`], [`environment`] and
//! [`texture`] convert it to cycles per radian or per metre, and [`map`] stores it in the packs of
//! `brdfc_formats::bandwidth`.

pub mod daubechies;
pub mod environment;
pub mod facts;
pub mod image;
pub mod lobe;
pub mod local;
pub mod map;
pub mod resolution;
pub mod texture;

/// `ε` of the paper: coefficients whose sum is below this share of the largest one are ignored.
pub const DEFAULT_EPSILON: f64 = 0.01;
/// Range of `ε`: the rule requires small values.
pub const EPSILON_RANGE: [f64; 2] = [1e-4, 0.1];
