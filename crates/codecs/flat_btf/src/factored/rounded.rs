//! A basis after rounding.

use super::basis::{Basis, Squares};
use brdfc_formats::flat_btf::factored::BasisMap;

/// A quantised basis as decoders see it, with the products for solving texels.
#[derive(Debug, Clone)]
pub(super) struct Rounded {
    pub(super) map: BasisMap,
    pub(super) basis: Basis,
    pub(super) squares: Squares,
    pub(super) prior: Vec<f64>,
}
