//! Packs for the GPU: KTX2 files whose `brdfc.*` entries say what the texels mean. Layouts: `spec/container.md` and
//! one page per pack.

pub mod container;
mod decode;
pub mod haar;
pub mod wavelet;
mod wavelet_layout;
pub mod wavelet_shader;

pub use container::{TexelFormat, Texture};
pub use decode::{DEFAULT_DISTANCE_SCALE, Filter, RowScratch, WaveletDecoder, level_of_detail};
pub use wavelet::WaveletPack;
