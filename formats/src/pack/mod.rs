//! Packs for the GPU: KTX2 files whose `brdfc.*` entries say what the texels mean. Layouts: `spec/container.md` and
//! one page per pack.

pub mod bandwidth;
mod bandwidth_limit;
pub mod bandwidth_shader;
pub mod container;
mod decode;
mod entries;
pub mod flat_btf;
pub mod flat_btf_shader;
pub mod haar;
pub mod half;
pub mod importance;
pub mod rgb9e5;
mod texel_format;
pub mod wavelet;
mod wavelet_layout;
pub mod wavelet_shader;

pub use container::{Extent, PackedTexture, Texture};
pub use decode::{DEFAULT_DISTANCE_SCALE, Filter, RowScratch, WaveletDecoder, level_of_detail};
pub use importance::{ImportanceHeader, ImportancePack};
pub use texel_format::TexelFormat;
pub use wavelet::WaveletPack;
