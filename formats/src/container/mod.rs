//! GPU-ready container: KTX2 files whose `brdfc.*` key/value data describes the texels. Layout: `spec.md` in this
//! folder, and one page per kind of pack.

pub(crate) mod checksum;
pub(crate) mod entries;
mod extent;
pub mod half;
mod levels;
pub mod rgb10a2;
pub mod rgb9e5;
mod texel_format;
mod texture;

pub use checksum::seal;
pub use extent::{CUBE_FACES, Extent, MAX_EXTENT, MAX_EXTENT_2D, MAX_LAYERS, ORIENTATION_2D, ORIENTATION_3D};
pub use levels::unpack_finest;
pub use texel_format::TexelFormat;
pub use texture::{MAX_TEXEL_BYTES, PackedTexture, Texture, WRITER};
