//! The error study of Hadim et al. 2009 (section 4) on our own meso-structures.

mod apparent;
pub mod coherency;
mod figures;
mod grids;
mod illustrations;
mod measure;
mod paper;
mod reconstruction;
mod rows;

pub use apparent::{ApparentSizes, TexelSizes};
pub use grids::{GridRow, grid_errors};
pub use illustrations::Illustrations;
pub use measure::{ModelFigures, StudyError, study_model};
pub use paper::{PAPER, PaperModel};
pub use rows::{AngleErrors, CoherencyRow, ImageErrors, ModelRow, ReconstructionRow, Spread, StudySettings};
