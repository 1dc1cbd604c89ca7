//! Measured appearance for GPUs: encodes materials as packs with measured errors, and scenes as folders of packs.
//!
//! ```no_run
//! # fn main() -> Result<(), brdfc::Error> {
//! let pack = brdfc::open("paint.brdf")?.encode(brdfc::Budget::default().bytes(16 << 10))?;
//! println!("ΔE {}", pack.errors().delta_e);
//! pack.write("paint.ktx2")?;
//!
//! brdfc::Build::from_manifest("scene.toml")?.out("packs").run()?;
//! # Ok(())
//! # }
//! ```
//!
//! Every failure is an [`Error`] with an [`ErrorKind`]; failed checks have a kind of their own. Long work takes a [`Progress`],
//! which observes its stages and can stop it. Work uses the threads of the current rayon pool. The library prints nothing.
//! The same input, options and version give the same bytes on any number of threads.
//!
//! The command line is a client of this library. Each verb except `generate` and `schema` has a module.
//!
//! Engines load packs with the crate `brdfc-formats`, which does not depend on this one. `docs/library.md` has examples,
//! including a `build.rs`.

#[cfg(doctest)]
#[doc = include_str!("../docs/library.md")]
mod page {}

pub mod bandwidth;
pub mod compare;
pub mod convert;
pub mod encode;
pub mod environment;
pub mod evaluate;
pub mod flatten;
pub mod inspect;
pub mod lobes;
mod material;
mod pack;
pub mod relight;
#[cfg(feature = "render")]
pub mod render;
pub mod report;
pub mod samples;
pub mod scene;
pub mod shader;
pub mod synth;
pub mod verify;
pub mod view;

pub use brdfc_core::progress::{Cancelled, Progress, Stage};
pub use brdfc_core::{Smooth, Source, Tally};
pub use brdfc_formats::direction::DirectionPair;
pub use brdfc_formats::{Brdf, BrdfPack, FormatError};
pub use brdfc_jobs::build::Build;
pub use brdfc_jobs::encode::PackRecipe;
pub use brdfc_jobs::encode::encoders::table::recipe::TableRecipe;
pub use brdfc_jobs::encode::encoders::table::search::recipe::{SearchRecipe, Tables};
pub use brdfc_jobs::encode::encoders::wavelet::recipe::Recipe as WaveletRecipe;
pub use brdfc_jobs::encode::{Budget, EncodeOptions, FitLimits};
pub use brdfc_jobs::output_folder::Changes;
pub use brdfc_jobs::report::build::BuildReport;
pub use brdfc_jobs::report::material::MaterialReport;
pub use brdfc_jobs::scene::build::Built;
pub use brdfc_jobs::scene::plan::Plan;
pub use brdfc_jobs::scene::run::{Made, Outcome, Outcomes};
pub use brdfc_jobs::{Error, ErrorKind};
pub use brdfc_metrics::fraction::Fraction;
pub use brdfc_source::open::Facts;
pub use brdfc_source::{Input, InputError, Reading};
pub use material::{Material, PackRequest, open, open_with};
pub use pack::{Errors, Pack};
