//! Settings and figures of the study.

use super::apparent::ApparentSizes;
use super::grids::GridRow;
use super::paper::PaperModel;
use serde::Serialize;

/// What the study computes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct StudySettings {
    /// Texels of ordinary BTF images per side.
    pub texels: usize,
    /// Texels of flat BTFs per side, a power of two.
    pub flat_texels: usize,
    /// Rays per texel and axis.
    pub oversampling: usize,
    /// Rounds of stretch-reducing reweighting at most.
    pub rounds: usize,
    /// Name of the set of directions, for views and lights.
    pub directions: String,
    /// How many these are.
    pub count: usize,
}

/// All figures of one model.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ModelRow {
    /// The structure's address.
    pub model: String,
    /// The paper's model that it stands for.
    pub paper_model: &'static str,
    /// Table 1.
    pub reconstruction: ReconstructionRow,
    /// Table 2.
    pub coherency: CoherencyRow,
    /// Table 3.
    pub apparent: ApparentSizes,
    /// Figure 10: both grids of views.
    pub grids: Vec<GridRow>,
    /// Stretch of the parameterisation.
    pub parameterisation: brdfc_flat_btf::parameterise::SurfaceParameterisationReport,
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// What the paper found.
    pub paper: PaperModel,
}

/// Table 1: difference in L*a*b* between BTF images computed directly and rebuilt by equation 1, at the sampled views
/// with indirections of their own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ReconstructionRow {
    /// Mean over all texels of all images, holes filled by Poisson inpainting.
    pub mean: f64,
    /// The same with holes filled by push-pull.
    pub mean_push_pull: f64,
    /// Largest mean of an image.
    pub largest_image: f64,
    /// Variance of the means of images.
    pub image_variance: f64,
    /// Largest difference of a single texel.
    pub largest_texel: f64,
}

/// Table 2: variance over the views, in L*a*b*, mean over lights.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct CoherencyRow {
    /// Ordinary BTF.
    pub btf: Spread,
    /// Flat BTF with holes filled by push-pull.
    pub push_pull: Spread,
    /// Flat BTF with holes filled by Poisson inpainting.
    pub poisson: Spread,
    /// Flat BTF, only what is seen.
    pub visible: Spread,
}

/// Mean and maximum over texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
}
