//! Encoding with all its parts: recipes, what was tried, how long stages took. [`Material::encode`](crate::Material::encode) is
//! `brdfc encode`.

pub use brdfc_jobs::encode::{
    BrdfRecipe, BrdfReport, CodecReport, EncodeError, EncodedPack, OptionError, Trial, encode, encoders,
};
pub use brdfc_jobs::report::gate::GateResult;
pub use brdfc_jobs::report::material::{StageTime, remarks, repairs_in_words};
pub use brdfc_jobs::stage_clock::StageClock;
