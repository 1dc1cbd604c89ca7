//! Values for texels that a view does not see.

mod poisson;
mod push_pull;

pub use poisson::Poisson;
pub use push_pull::PushPull;

/// How texels that a view does not see get their values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FillMethod {
    /// From coarser and coarser means of what is seen around them: fast, as in Hadim et al. 2009.
    PushPull,
    /// As differences of the texel's own values in the view that sees it most from above (Pérez et al. 2003): the
    /// gradients of that view, fitted at the border of the hole. Better and slower.
    Poisson,
}

impl FillMethod {
    /// The names that scripts use.
    pub const NAMES: [(&'static str, Self); 2] = [("push-pull", Self::PushPull), ("poisson", Self::Poisson)];

    /// The name that scripts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::PushPull => "push-pull",
            Self::Poisson => "poisson",
        }
    }
}
