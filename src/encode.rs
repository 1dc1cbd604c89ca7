//! Encoding in detail: recipes, candidates, duration of stages. [`Material::encode`](crate::Material::encode) does the work of
//! `brdfc encode`.

pub use brdfc_jobs::encode::{
    BrdfRecipe, BrdfReport, CodecReport, EncodeError, EncodedPack, OptionError, Trial, encode, encoders,
};
pub use brdfc_jobs::report::gate::GateResult;
pub use brdfc_jobs::report::material::{StageTime, remarks, repairs_summary};
pub use brdfc_jobs::stage_clock::StageClock;
