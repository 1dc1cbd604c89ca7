//! What a shader that decodes a pack has bound, as the pack itself says it: an engine uploads a pack by this list, without
//! knowing its codec. Layout: `spec.md` in this folder.

mod file;
mod frame;
mod text;

pub use file::PackFile;
pub use frame::{FRAME_SLOT, FRAME_WGSL, FrameBlock, combined_wgsl};

use crate::container::{Extent, TexelFormat};
use std::borrow::Cow;

/// Most bindings of a pack.
pub const MAX_BINDINGS: usize = 32;
/// Slots are below this, as WebGPU allows in a bind group.
pub const MAX_SLOTS: u32 = 1000;
/// Most bytes of a uniform block: what WebGL 2 promises.
pub const MAX_UNIFORM_BYTES: u32 = 16384;
/// Most textures of a pack, and most samplers: what WebGPU promises a shader stage.
pub const MAX_TEXTURES: usize = 16;
/// Most uniform blocks of a pack: what WebGPU promises a shader stage.
pub const MAX_UNIFORMS: usize = 12;

/// What the decoder of a pack has bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Bindings<'a> {
    /// Which decoder: the name that `brdfc shader` has for it.
    pub decoder: Cow<'a, str>,
    /// Version of the decoder's bindings, 1 or more.
    pub version: u32,
    /// By ascending slots.
    pub all: Vec<Binding<'a>>,
}

/// One binding.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding<'a> {
    /// Its number in group 1 of the WGSL decoder; no two decoders share one but [`FRAME_SLOT`].
    pub slot: u32,
    /// The name of the variable in the shader, in every language.
    pub name: Cow<'a, str>,
    /// What is bound.
    pub resource: Resource<'a>,
}

/// What is bound.
#[derive(Debug, Clone, PartialEq)]
pub enum Resource<'a> {
    /// The block of [`FrameBlock`], which the engine fills.
    Frame,
    /// The bytes of a uniform block: a multiple of 16, at most [`MAX_UNIFORM_BYTES`].
    Uniform(Cow<'a, [u8]>),
    /// A texture.
    Texture(Texels<'a>),
    /// A sampler with a linear filter, also between mipmap levels.
    Sampler {
        /// Whether coordinates repeat; else they are clamped to the edge.
        repeats: bool,
    },
}

/// Where a pack has the texels of a binding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// The texture of the KTX2 file itself.
    File,
    /// A KTX2 file in an entry of the file, `brdfc.image.NAME`.
    Entry,
    /// Nowhere: one texel of zero is bound, as the decoder does not read it.
    Empty,
}

/// Texels as a GPU takes them.
#[derive(Debug, Clone, PartialEq)]
pub struct Texels<'a> {
    /// Where they are stored.
    pub stored: Stored,
    /// How a texel is stored.
    pub format: TexelFormat,
    /// 2D, 2D array or 3D, and the number of texels along each axis.
    pub extent: Extent,
    /// Mipmap levels.
    pub levels: u32,
    /// The sampler that filters it; a texture without one is only loaded from.
    pub sampler: Option<Cow<'a, str>>,
    /// x fastest, then y, then z or the layer, then the level from the finest; little-endian components.
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> Texels<'a> {
    /// Texels of one level that are only loaded from, in an entry.
    pub fn new(format: TexelFormat, extent: Extent, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { stored: Stored::Entry, format, extent, levels: 1, sampler: None, bytes: bytes.into() }
    }

    /// One texel of zero, for a texture that the decoder does not read: `extent` has ones.
    pub fn empty(format: TexelFormat, extent: Extent) -> Self {
        let bytes = vec![0; format.texel_bytes()];
        Self { stored: Stored::Empty, ..Self::new(format, extent, bytes) }
    }

    /// The same texels as the texture of the file itself.
    #[must_use]
    pub fn of_file(self) -> Self {
        Self { stored: Stored::File, ..self }
    }

    /// The same texels filtered by the sampler of this name.
    #[must_use]
    pub fn sampled(self, sampler: &'a str) -> Self {
        Self { sampler: Some(sampler.into()), ..self }
    }

    /// The same texels with so many mipmap levels.
    #[must_use]
    pub fn with_levels(self, levels: u32) -> Self {
        Self { levels, ..self }
    }

    /// Texels of 16-bit integers as 32-bit floats of four components, for devices that have such integers only as a feature,
    /// or not at all, as WebGL 2. All others as they are.
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
    /// The block of [`FrameBlock`].
    pub fn frame() -> Self {
        Self { slot: FRAME_SLOT, name: "brdfc_frame".into(), resource: Resource::Frame }
    }

    /// A uniform block of these bytes.
    pub fn uniform(slot: u32, name: &'a str, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { slot, name: name.into(), resource: Resource::Uniform(bytes.into()) }
    }

    /// A texture of these texels.
    pub fn texture(slot: u32, name: &'a str, texels: Texels<'a>) -> Self {
        Self { slot, name: name.into(), resource: Resource::Texture(texels) }
    }

    /// A sampler.
    pub fn sampler(slot: u32, name: &'a str, repeats: bool) -> Self {
        Self { slot, name: name.into(), resource: Resource::Sampler { repeats } }
    }
}

impl Binding<'_> {
    /// The same with bytes of its own.
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
    /// The same with bytes of their own.
    pub fn into_owned(self) -> Vec<Binding<'static>> {
        self.all.into_iter().map(Binding::into_owned).collect()
    }

    /// The bindings of a version of a decoder, by ascending slots.
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

    /// Bytes of its textures on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        let stored = self.textures().filter(|(_, texels)| texels.stored != Stored::Empty);
        stored.map(|(_, texels)| texels.bytes.len() as u64).sum()
    }

    /// The texture of the file itself.
    pub(crate) fn of_file(&self) -> Option<&Texels<'a>> {
        self.textures().map(|(_, texels)| texels).find(|texels| texels.stored == Stored::File)
    }
}
