//! Encoding of BRDFs: the list of codecs, and the choice of a codec from options.

mod codecs;
mod options;
mod run;

pub use brdfc_codec::{
    AveragingCost, BrdfRecipe, BrdfReport, Encode, EncodeError, Encoded, GridCache, Predicted, Trial,
};
pub use codecs::{CodecReport, EncodedPack, PackFacts, PackRecipe, encoders};
pub use options::{codec_names, codecs, options_over};
pub use run::{encode, encode_cached};
