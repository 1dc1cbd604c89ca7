//! Values for texels that a view does not see.

mod poisson;
mod push_pull;

pub use poisson::Poisson;
pub use push_pull::PushPull;

/// Method for filling texels that a view does not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FillMethod {
    /// Fills from successively coarser means of the seen texels around them: fast, as in Hadim et al. 2009.
    PushPull,
    /// Fills by Poisson editing (Pérez et al. 2003): takes the gradients of the most vertical view that sees the texel,
    /// fitted at the border of the hole. Better and slower.
    Poisson,
}

impl FillMethod {
    /// Names in scripts.
    pub const NAMES: [(&'static str, Self); 2] = [("push-pull", Self::PushPull), ("poisson", Self::Poisson)];

    /// Name in scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::PushPull => "push-pull",
            Self::Poisson => "poisson",
        }
    }
}
