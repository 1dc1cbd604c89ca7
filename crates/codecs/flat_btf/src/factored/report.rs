//! Reports and errors of the factorisation.

use brdfc_core::progress::Cancelled;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::{FactoredErrors, FactoredFlatBtf};

/// A trial of a number of components, fitted to fewer texels than the asset.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FactoredTrial {
    /// Number of components.
    pub components: u32,
    /// Cells per side of the residual of shadows, 0 without one.
    pub residual: u32,
    /// Bytes that the asset would take on a GPU, mipmaps included.
    pub gpu_bytes: u64,
    /// Errors at held-out texels.
    pub errors: FactoredErrors,
}

/// Facts about a factored flat BTF.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct FactoredFacts {
    /// Number of components.
    pub components: u32,
    /// Cells per side of the residual of shadows, 0 without one.
    pub residual: u32,
    /// Bytes of texels on a GPU, mipmaps included.
    pub gpu_bytes: u64,
    /// Errors of the asset at held-out texels.
    pub errors: FactoredErrors,
    /// All trials by which the number of components was chosen.
    pub tried: Vec<FactoredTrial>,
}

/// A factored flat BTF with its facts.
#[derive(Debug, Clone, PartialEq)]
pub struct Factored {
    /// Parts of the asset.
    pub asset: FactoredFlatBtf,
    /// Facts about the asset: components, errors and trials.
    pub facts: FactoredFacts,
}

/// Errors of the factorisation.
#[derive(Debug, thiserror::Error)]
pub enum FactorError<E> {
    /// A view cannot be read.
    #[error("{0}")]
    View(E),
    /// Views that do not match, or a target out of range.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The work was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
