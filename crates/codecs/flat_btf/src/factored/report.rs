//! What is told of a factored flat BTF, and what can go wrong.

use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::{FactoredErrors, FactoredFlatBtf};

/// A number of components that was tried, fitted to fewer texels than the asset.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FactoredTrial {
    /// Components.
    pub components: u32,
    /// Whether each texel and light has a factor of its own.
    pub shadowed: bool,
    /// Bytes that the asset would take on a GPU, mipmaps included.
    pub gpu_bytes: u64,
    /// Errors at texels that were left out.
    pub errors: FactoredErrors,
}

/// What is worth knowing of a factored flat BTF.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FactoredFacts {
    /// Components.
    pub components: u32,
    /// Whether each texel and light has a factor of its own.
    pub shadowed: bool,
    /// Bytes of texels on a GPU, mipmaps included.
    pub gpu_bytes: u64,
    /// Errors of the asset at texels that were left out of the fit.
    pub errors: FactoredErrors,
    /// What was tried.
    pub tried: Vec<FactoredTrial>,
}

/// An asset and what is worth knowing of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Factored {
    /// The parts.
    pub asset: FactoredFlatBtf,
    /// Its facts.
    pub facts: FactoredFacts,
}

/// Why there is no asset.
#[derive(Debug, thiserror::Error)]
pub enum FactorError<E> {
    /// A view could not be had.
    #[error("{0}")]
    View(E),
    /// Views that do not fit together, or a target out of range.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The work was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
