//! What is asked of a factored flat BTF.

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
