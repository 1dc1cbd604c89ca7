//! The error study of Hadim et al. 2009 (section 4) on our own meso-structures.

mod apparent;
mod grids;
mod measure;
mod paper;

pub use apparent::{ApparentSizes, TexelSizes};
pub use grids::{GridRow, grid_errors};
pub use measure::{CoherencyRow, ReconstructionRow, StudyError, study_model};
pub use paper::{PAPER, PaperModel};

use brdfc_formats::flat_btf::IndirectionHeader;
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
    /// Polar angles and azimuths of the indirection map; it has as many texels as the images.
    pub indirection: [u32; 2],
    /// Its largest polar angle, degrees.
    pub largest_angle: f64,
    /// Rounds of stretch-reducing reweighting at most.
    pub rounds: usize,
    /// Name of the set of directions, for views and lights.
    pub directions: String,
    /// How many these are.
    pub count: usize,
}

impl StudySettings {
    fn map_header(&self) -> IndirectionHeader {
        let [zenith_samples, azimuth_samples] = self.indirection;
        let largest_angle = self.largest_angle.to_radians() as f32;
        IndirectionHeader { size: self.texels as u32, zenith_samples, azimuth_samples, largest_angle }
    }
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
    pub parameterisation: brdfc_flat_btf::parameterise::ParameterisationReport,
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// What the paper found.
    pub paper: PaperModel,
}
