//! Flat BTFs as a product, `value = s(t, l)³ rgb(o(t, v, l) + Σ_k w_k(t) b_k(v, l)) + a(t, l) d(t)` with texel t, view v,
//! light l: a base o of diffuse and glossy reflection with the diffuse albedo d, weights and a basis; s³ is the share of the
//! value where light arrives, a the share of the albedo in shadow. The base is fitted first, then s and a to it, then weights and basis by
//! alternating least squares in the scale of `brdfc_formats::flat_btf::factored::to_opponent`. Layout:
//! `formats/src/flat_btf/factored/spec.md`.
//!
//! Stages: texels are sampled (`sample`); the base is fitted to some of them and, in a pass over the views, to every
//! texel (`gloss`, `base`), and with it the residual of shadows (`residual`); sets of components of several sizes are
//! fitted to some texels (`train`) and tested on others (`candidate`, `choose`); the chosen one is fitted to more texels.
//! One more pass accumulates the sums of every texel (`accumulate`), from which each texel is solved independently
//! (`local`). The result is rounded (`quantise`) and measured (`measure`). Where materials are known, the base is fitted
//! to them alone (`known`).

mod accumulate;
mod assemble;
mod base;
mod basis;
mod candidate;
mod choose;
mod chroma;
mod encode;
mod gloss;
mod known;
mod local;
mod masks;
mod matrix;
mod measure;
mod mipmaps;
mod quantise;
mod recipe;
mod report;
mod residual;
mod rounded;
mod sample;
#[cfg(test)]
mod tests;
mod train;
mod words;

pub use encode::factor;
pub use known::{known, least_bytes};
pub(crate) use mipmaps::with_mipmaps;
pub use recipe::{FactoredRecipe, FactoredTarget};
pub use report::{FactorError, Factored, FactoredFacts, FactoredTrial};
pub use residual::max_cells;
