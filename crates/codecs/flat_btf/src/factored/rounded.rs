//! A basis after rounding.

use super::basis::{Basis, Squares};
use brdfc_formats::flat_btf::factored::BasisMap;

/// A basis as decoders see it, ready to be solved for texels.
#[derive(Debug, Clone)]
pub(super) struct Rounded {
    pub(super) map: BasisMap,
    pub(super) basis: Basis,
    pub(super) squares: Squares,
    pub(super) prior: Vec<f64>,
    pub(super) shadowed: bool,
}
