//! Encoder of wavelet BRDF packs: resample, log-encode, transform, threshold, quantise. Each stage has a file;
//! [`encode`] runs them in order. Paper: Claustres, Barthe, Paulin, "Wavelet Encoding of BRDFs for Real-Time
//! Rendering", Graphics Interface 2007.

mod codec;
pub mod crop;
pub mod encode;
pub mod energy;
mod facts;
pub mod fold;
pub mod haar;
pub mod log_encode;
pub mod measure;
pub mod quantise;
pub mod recipe;
pub mod resample;
pub mod table;
pub mod tabulated;
pub mod threshold;
pub mod visible;

pub use codec::WaveletReport;
pub use facts::WaveletPackFacts;
