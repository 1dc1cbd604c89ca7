//! One source to one pack: which codec, how large, and what was tried.

pub(crate) mod auto;
mod averaged;
pub(crate) mod byte_count;
mod error;
pub mod options;
mod pack;
pub mod recipe;
mod run;
mod tables;
mod trial;
mod within;

pub use averaged::AveragingCost;
pub use byte_count::bytes_from_text;
pub use error::PackError;
pub use pack::{CodecReport, EncodedPack, TableReport, WaveletReport};
pub use run::{encode, encode_with};
pub use tables::TableShelf;
pub use trial::Trial;
