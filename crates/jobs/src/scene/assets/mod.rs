//! Assets of a build other than materials: RTI captures, ordinary BTFs and environments. Each becomes one pack.

mod cached;
mod job;
mod make;
mod report;

pub use job::{Asset, AssetJob, AssetKind, AssetRecipe, MadeAsset, files_of};
pub use report::AssetReport;
