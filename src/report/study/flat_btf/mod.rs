//! The error study of Hadim et al. 2009 (section 4) on our own meso-structures.

mod apparent;
mod measure;
mod paper;

pub use apparent::{ApparentSizes, TexelSizes};
pub use measure::{CoherencyRow, ReconstructionRow, StudyError, study_model};
pub use paper::{PAPER, PaperModel};

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
    /// Stretch of the parameterisation.
    pub parameterisation: crate::btf::parameterise::ParameterisationReport,
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// What the paper found.
    pub paper: PaperModel,
}
