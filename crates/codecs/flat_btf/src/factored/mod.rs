//! Flat BTFs as a product, `value = S(t, l)³ rgb(Σ_k w_k(t) b_k(v, l))` with texel t, view v, light l: shadows, weights and a
//! basis, found by alternating least squares in the scale of `brdfc_formats::flat_btf::factored::to_opponent`. Layout:
//! `formats/src/flat_btf/factored/spec.md`.
//!
//! Stages: texels are drawn (`sample`), bases of several sizes fitted to some of them (`train`) and tried on others
//! (`candidate`, `choose`), the chosen one is fitted to more; one pass over the views gathers what every texel needs
//! (`accumulate`), which is then solved by itself (`local`), rounded (`quantise`), and measured (`measure`).

mod accumulate;
mod assemble;
mod basis;
mod candidate;
mod choose;
mod encode;
mod local;
mod masks;
mod matrix;
mod measure;
mod mipmaps;
mod quantise;
mod sample;
#[cfg(test)]
mod tests;
mod train;

use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::{FactoredErrors, FactoredFlatBtf};
use brdfc_source::progress::Cancelled;
pub use encode::factor;

/// What a factored flat BTF is to be like.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FactoredTarget {
    /// The fewest bytes whose mean error, ΔE where texels are seen, is at most this.
    Error(f64),
    /// The least error that takes at most so many bytes on a GPU.
    Bytes(u64),
    /// So many components, rounded up to a multiple of four.
    Components {
        /// 1 to 64.
        components: u32,
        /// Whether each texel and light has a factor of its own.
        shadowed: bool,
    },
}

/// Everything that decides the asset besides the views.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FactoredRecipe {
    /// What is asked for.
    pub target: FactoredTarget,
    /// Texels that the basis is fitted to, as far as `training_bytes` allows.
    pub training_texels: usize,
    /// Most bytes of values of the fit.
    pub training_bytes: usize,
    /// Most bytes of sums in memory: where all texels take more, the views are gone over several times.
    pub slab_bytes: usize,
}

impl FactoredRecipe {
    /// The usual settings: 2500 texels, 384 MiB, 768 MiB.
    pub fn new(target: FactoredTarget) -> Self {
        Self { target, training_texels: 2500, training_bytes: 384 << 20, slab_bytes: 768 << 20 }
    }
}

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
