//! Shader bindings of a pack, as listed in the file. An engine can upload a pack by this list without knowing its
//! codec. Layout: `spec.md` in this folder.

mod file;
mod frame;
mod text;

pub use file::PackFile;
pub use frame::{FRAME_SLOT, FRAME_WGSL, FrameBlock};

use crate::container::{Extent, TexelFormat};
use std::borrow::Cow;

/// Maximum number of bindings of a pack.
pub const MAX_BINDINGS: usize = 32;
/// Slots are below this: WebGPU's limit for a bind group.
pub const MAX_SLOTS: u32 = 1000;
/// Maximum size of a uniform block, bytes: the minimum that WebGL 2 guarantees.
pub const MAX_UNIFORM_BYTES: u32 = 16384;
/// Maximum number of textures of a pack, and of samplers: WebGPU's guarantee for a shader stage.
pub const MAX_TEXTURES: usize = 16;
/// Maximum number of uniform blocks of a pack: WebGPU's guarantee for a shader stage.
pub const MAX_UNIFORMS: usize = 12;

/// Bindings of a pack's decoder.
#[derive(Debug, Clone, PartialEq)]
pub struct Bindings<'a> {
    /// Name of the decoder, as `brdfc shader` lists it.
    pub decoder: Cow<'a, str>,
    /// Version of the decoder's bindings, 1 or more.
    pub version: u32,
    /// Bindings in ascending order of slots.
    pub all: Vec<Binding<'a>>,
}

/// A binding of a pack's shader: slot, variable, and the resource to bind.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding<'a> {
    /// Binding number in group 1 of the WGSL decoder. No two decoders share a slot except [`FRAME_SLOT`].
    pub slot: u32,
    /// Name of the shader variable, in every shading language.
    pub name: Cow<'a, str>,
    /// Resource to bind to the slot, with its data.
    pub resource: Resource<'a>,
}

/// A resource of a binding: a uniform block, a texture or a sampler.
#[derive(Debug, Clone, PartialEq)]
pub enum Resource<'a> {
    /// The block of [`FrameBlock`], which the engine fills.
    Frame,
    /// Contents of a uniform block: a multiple of 16 bytes, at most [`MAX_UNIFORM_BYTES`].
    Uniform(Cow<'a, [u8]>),
    /// A texture, with its texels in GPU layout.
    Texture(Texels<'a>),
    /// A sampler with linear filtering within and between mipmap levels.
    Sampler {
        /// True if coordinates repeat; false if they are clamped to the edge.
        repeats: bool,
    },
}

/// Location of the texels of a binding in a pack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// The texture of the KTX2 file itself.
    File,
    /// A KTX2 file as the value of the key `brdfc.image.NAME`.
    Entry,
    /// Not stored: the decoder does not read it, and one texel of zero is bound (per face of a cube map).
    Empty,
}

/// Texels in GPU layout.
#[derive(Debug, Clone, PartialEq)]
pub struct Texels<'a> {
    /// Location in the pack.
    pub stored: Stored,
    /// Format of each texel.
    pub format: TexelFormat,
    /// Dimension and number of texels along each axis.
    pub extent: Extent,
    /// Number of mipmap levels.
    pub levels: u32,
    /// Name of the sampler that filters the texture; `None` if the shader only loads texels.
    pub sampler: Option<Cow<'a, str>>,
    /// Texels: x fastest, then y, then z, the layer or the face, then levels from the finest; little-endian components.
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> Texels<'a> {
    /// Texels of one level without a sampler, stored as key/value data.
    pub fn new(format: TexelFormat, extent: Extent, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { stored: Stored::Entry, format, extent, levels: 1, sampler: None, bytes: bytes.into() }
    }

    /// One texel of zero, for a texture that the decoder does not read. All sides of `extent` are 1; a cube map has one
    /// texel per face.
    pub fn empty(format: TexelFormat, extent: Extent) -> Self {
        let bytes = vec![0; extent.texels() as usize * format.texel_bytes()];
        Self { stored: Stored::Empty, ..Self::new(format, extent, bytes) }
    }

    /// The same texels, stored as the texture of the file itself.
    #[must_use]
    pub fn of_file(self) -> Self {
        Self { stored: Stored::File, ..self }
    }

    /// The same texels, filtered by the sampler with this name.
    #[must_use]
    pub fn sampled(self, sampler: &'a str) -> Self {
        Self { sampler: Some(sampler.into()), ..self }
    }

    /// The same texels, with `levels` mipmap levels.
    #[must_use]
    pub fn with_levels(self, levels: u32) -> Self {
        Self { levels, ..self }
    }

    /// Converts 16-bit unorm texels to four 32-bit floats, for devices without 16-bit unorm formats, such as WebGL 2.
    /// Other formats are unchanged.
    #[must_use]
    pub fn widened(self) -> Self {
        let channels = match self.format {
            TexelFormat::R16Unorm => 1,
            TexelFormat::Rgba16Unorm => 4,
            _ => return self,
        };
        let number = |two: &[u8]| f32::from(u16::from_le_bytes([two[0], two[1]])) * (1.0 / 65535.0);
        let numbers: Vec<f32> = self.bytes.chunks_exact(2).map(number).collect();
        let four = |texel: &[f32]| [0, 1, 2, 3].map(|k: usize| texel[k.min(channels - 1)]);
        let bytes: Vec<u8> = numbers.chunks_exact(channels).flat_map(four).flat_map(f32::to_le_bytes).collect();
        Self { format: TexelFormat::Rgba32Float, bytes: bytes.into(), ..self }
    }
}

impl<'a> Binding<'a> {
    /// Binding of the block of [`FrameBlock`].
    pub fn frame() -> Self {
        Self { slot: FRAME_SLOT, name: "brdfc_frame".into(), resource: Resource::Frame }
    }

    /// Binding of a uniform block with these bytes.
    pub fn uniform(slot: u32, name: &'a str, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { slot, name: name.into(), resource: Resource::Uniform(bytes.into()) }
    }

    /// Binding of a texture with these texels.
    pub fn texture(slot: u32, name: &'a str, texels: Texels<'a>) -> Self {
        Self { slot, name: name.into(), resource: Resource::Texture(texels) }
    }

    /// Binding of a sampler.
    pub fn sampler(slot: u32, name: &'a str, repeats: bool) -> Self {
        Self { slot, name: name.into(), resource: Resource::Sampler { repeats } }
    }
}

impl Binding<'_> {
    /// Converts to an owned binding; copies bytes that are borrowed.
    pub fn into_owned(self) -> Binding<'static> {
        let own = |name: Cow<'_, str>| Cow::Owned(name.into_owned());
        let bytes = |bytes: Cow<'_, [u8]>| Cow::Owned(bytes.into_owned());
        let resource = match self.resource {
            Resource::Frame => Resource::Frame,
            Resource::Uniform(block) => Resource::Uniform(bytes(block)),
            Resource::Sampler { repeats } => Resource::Sampler { repeats },
            Resource::Texture(Texels { stored, format, extent, levels, sampler, bytes: texels }) => {
                Resource::Texture(Texels {
                    stored,
                    format,
                    extent,
                    levels,
                    sampler: sampler.map(own),
                    bytes: bytes(texels),
                })
            }
        };
        Binding { slot: self.slot, name: own(self.name), resource }
    }
}

impl<'a> Bindings<'a> {
    /// Converts to owned bindings; copies bytes that are borrowed.
    pub fn into_owned(self) -> Vec<Binding<'static>> {
        self.all.into_iter().map(Binding::into_owned).collect()
    }

    /// Bindings of a version of a decoder, in ascending order of slots.
    pub fn new(decoder: &'a str, version: u32, all: impl IntoIterator<Item = Binding<'a>>) -> Self {
        Self { decoder: decoder.into(), version, all: all.into_iter().collect() }
    }

    /// All textures, with the names of their bindings.
    pub fn textures(&self) -> impl Iterator<Item = (&str, &Texels<'a>)> {
        self.all.iter().filter_map(|binding| match &binding.resource {
            Resource::Texture(texels) => Some((&*binding.name, texels)),
            _ => None,
        })
    }

    /// Size of the textures on a GPU, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        let stored = self.textures().filter(|(_, texels)| texels.stored != Stored::Empty);
        stored.map(|(_, texels)| texels.bytes.len() as u64).sum()
    }

    /// Texels that are stored as the texture of the file itself.
    pub(crate) fn of_file(&self) -> Option<&Texels<'a>> {
        self.textures().map(|(_, texels)| texels).find(|texels| texels.stored == Stored::File)
    }
}
