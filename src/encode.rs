//! Encoding in detail: `brdfc encode`.
//!
//! Start with [`Material::encode`](crate::Material::encode), which does the work of the command. This module adds
//! [`encode()`] for any source, the packs that a search tried ([`Trial`]), times of stages ([`StageClock`]), notes on the
//! source ([`remarks`], [`repairs_summary`]), and the checks of limits that all outputs share ([`check()`]).

pub use brdfc_jobs::encode::{
    BrdfRecipe, BrdfReport, CodecReport, EncodeError, EncodedPack, ErrorLimits, OptionError, Trial, codecs, encode,
    encoders,
};
pub use brdfc_jobs::report::fit::{Found, Reliability, check, check_output, check_report, fit_error};
pub use brdfc_jobs::report::gate::GateResult;
pub use brdfc_jobs::report::material::{StageTime, remarks, repairs_summary};
pub use brdfc_jobs::stage_clock::StageClock;
