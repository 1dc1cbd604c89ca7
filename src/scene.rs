//! Builds in detail: `brdfc build`, `brdfc plan` and `brdfc watch`.
//!
//! Start with [`Build`](crate::Build), which does the work of `brdfc build`. This module adds plans of a manifest
//! ([`plan()`]) and their job graphs ([`Graph`]), parts of a build for several machines ([`Shard`]), and watched
//! files ([`Watched`], [`FileEvents`]).

pub use brdfc_jobs::depfile::depfile;
pub use brdfc_jobs::encode::Predicted;
pub use brdfc_jobs::file_events::FileEvents;
pub use brdfc_jobs::report::build::{AssetEntry, MaterialEntry};
pub use brdfc_jobs::report::list::MaterialFile;
pub use brdfc_jobs::scene::assets::{AssetJob, AssetKind, AssetReport, MadeAsset};
pub use brdfc_jobs::scene::current::PackFolder;
pub use brdfc_jobs::scene::explain::{Explained, NOTHING};
pub use brdfc_jobs::scene::graph::{Graph, Places};
pub use brdfc_jobs::scene::inputs::{manifest_among, read_manifest};
pub use brdfc_jobs::scene::lobes::{LOBES, LobesReport};
pub use brdfc_jobs::scene::manifest::{Manifest, ManifestError, Use, line_of, near_miss};
pub use brdfc_jobs::scene::maps::{PARTS, Packed, TEXTURE, part_name};
pub use brdfc_jobs::scene::plan::{EnvironmentJob, Job, REPORT, pack_name, plan};
pub use brdfc_jobs::scene::render_section::{LightSection, MAX_SAMPLES, MAX_SIDE, RenderSection};
pub use brdfc_jobs::scene::textures::{TEXTURE_METRES, TextureJob};
pub use brdfc_jobs::scene::watch::{Change, Watched, What};
pub use brdfc_jobs::scene::works::{Shard, Work};

use brdfc_jobs::store::{Staging, placing};

/// Removes the unfinished files of all builds of this process, which is about to exit: for signal handlers. Waits for finished
/// files that are being moved; no files are moved while the guard lives.
#[must_use]
pub fn abandon() -> impl Sized {
    let guard = placing();
    Staging::remove_all();
    guard
}
