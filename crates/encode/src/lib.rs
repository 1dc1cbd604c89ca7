//! Source to pack of a BRDF: the list of codecs, and the search for the smallest pack that meets a budget.

mod auto;
mod codecs;
mod options;
pub mod recipe;
mod run;
mod within;

pub use brdfc_codec::{
    AveragingCost, BrdfRecipe, BrdfReport, Encode, EncodeError, Encoded, GridCache, Predicted, Trial,
};
pub use codecs::{CodecReport, EncodedPack, PackFacts, PackRecipe, encoders};
pub use options::{codec_names, options_over};
pub use run::{encode, encode_cached};
