//! Packs for the GPU: KTX2 files whose `brdfc.*` entries say what the texels mean. Layout: `spec.md` in this folder, and
//! one page per kind of pack.

pub(crate) mod entries;
pub mod half;
pub mod rgb10a2;
pub mod rgb9e5;
mod texel_format;
mod texture;

pub use texel_format::TexelFormat;
pub use texture::{
    Extent, MAX_EXTENT, MAX_EXTENT_2D, MAX_LAYERS, MAX_TEXEL_BYTES, ORIENTATION_2D, ORIENTATION_3D, PackedTexture,
    Texture, WRITER,
};
