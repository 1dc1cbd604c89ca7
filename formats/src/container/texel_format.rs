//! Texel formats of packs and their KTX2 data format descriptors. Layout: `formats/src/container/spec.md`.

/// Texel formats that packs use. The 16-bit unorm formats are optional in all graphics APIs. All others are core, and
/// filterable except 32-bit floats and integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TexelFormat {
    /// One component of 8 bits, `VK_FORMAT_R8_UNORM`.
    R8Unorm,
    /// Two components of 8 bits, `VK_FORMAT_R8G8_UNORM`.
    Rg8Unorm,
    /// Four components of 8 bits, `VK_FORMAT_R8G8B8A8_UNORM`.
    Rgba8Unorm,
    /// One component of 16 bits, `VK_FORMAT_R16_UNORM`.
    R16Unorm,
    /// One 16-bit float, `VK_FORMAT_R16_SFLOAT`.
    R16Float,
    /// Four components of 16 bits, `VK_FORMAT_R16G16B16A16_UNORM`.
    Rgba16Unorm,
    /// Four 16-bit floats, `VK_FORMAT_R16G16B16A16_SFLOAT`.
    Rgba16Float,
    /// Two 16-bit floats, `VK_FORMAT_R16G16_SFLOAT`.
    Rg16Float,
    /// Four 32-bit floats, `VK_FORMAT_R32G32B32A32_SFLOAT`.
    Rgba32Float,
    /// One unsigned integer of 32 bits, `VK_FORMAT_R32_UINT`.
    R32Uint,
    /// Four unsigned integers of 32 bits, `VK_FORMAT_R32G32B32A32_UINT`.
    Rgba32Uint,
    /// Three 9-bit mantissas with a shared exponent in one word, `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`. See
    /// [`super::rgb9e5`].
    Rgb9E5,
    /// Three components of 10 bits and one of 2 in one word, red in the lowest bits,
    /// `VK_FORMAT_A2B10G10R10_UNORM_PACK32`. See [`super::rgb10a2`].
    Rgb10A2Unorm,
}

impl TexelFormat {
    /// All texel formats that this crate reads and writes.
    pub const ALL: [Self; 13] = [
        Self::R8Unorm,
        Self::Rg8Unorm,
        Self::Rgba8Unorm,
        Self::R16Unorm,
        Self::R16Float,
        Self::Rgba16Unorm,
        Self::Rgba16Float,
        Self::Rg16Float,
        Self::Rgba32Float,
        Self::R32Uint,
        Self::Rgba32Uint,
        Self::Rgb9E5,
        Self::Rgb10A2Unorm,
    ];

    /// Name of the format in WebGPU, such as `r8unorm`.
    pub fn name(self) -> &'static str {
        match self {
            Self::R8Unorm => "r8unorm",
            Self::Rg8Unorm => "rg8unorm",
            Self::Rgba8Unorm => "rgba8unorm",
            Self::R16Unorm => "r16unorm",
            Self::R16Float => "r16float",
            Self::Rgba16Unorm => "rgba16unorm",
            Self::Rgba16Float => "rgba16float",
            Self::Rg16Float => "rg16float",
            Self::Rgba32Float => "rgba32float",
            Self::R32Uint => "r32uint",
            Self::Rgba32Uint => "rgba32uint",
            Self::Rgb9E5 => "rgb9e5ufloat",
            Self::Rgb10A2Unorm => "rgb10a2unorm",
        }
    }

    /// Format with this WebGPU name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Returns true for integer formats, which samplers cannot filter.
    pub fn is_integer(self) -> bool {
        matches!(self, Self::R32Uint | Self::Rgba32Uint)
    }

    /// Words per texel: one per component, or one for packed formats.
    pub fn components(self) -> usize {
        match self {
            Self::R8Unorm | Self::R16Unorm | Self::R16Float | Self::R32Uint | Self::Rgb9E5 | Self::Rgb10A2Unorm => 1,
            Self::Rg8Unorm | Self::Rg16Float => 2,
            Self::Rgba8Unorm | Self::Rgba16Unorm | Self::Rgba16Float | Self::Rgba32Float | Self::Rgba32Uint => 4,
        }
    }

    /// Bytes per word: 1, 2 or 4.
    pub fn component_bytes(self) -> usize {
        match self {
            Self::R8Unorm | Self::Rg8Unorm | Self::Rgba8Unorm => 1,
            Self::R16Unorm | Self::R16Float | Self::Rg16Float | Self::Rgba16Unorm | Self::Rgba16Float => 2,
            Self::Rgba32Float | Self::R32Uint | Self::Rgba32Uint => 4,
            Self::Rgb9E5 | Self::Rgb10A2Unorm => 4,
        }
    }

    /// Bytes per texel, a power of two.
    pub fn texel_bytes(self) -> usize {
        self.components() * self.component_bytes()
    }

    pub(super) fn vulkan(self) -> ktx2::Format {
        match self {
            Self::R8Unorm => ktx2::Format::R8_UNORM,
            Self::Rg8Unorm => ktx2::Format::R8G8_UNORM,
            Self::Rgba8Unorm => ktx2::Format::R8G8B8A8_UNORM,
            Self::R16Unorm => ktx2::Format::R16_UNORM,
            Self::R16Float => ktx2::Format::R16_SFLOAT,
            Self::Rgba16Unorm => ktx2::Format::R16G16B16A16_UNORM,
            Self::Rgba16Float => ktx2::Format::R16G16B16A16_SFLOAT,
            Self::Rg16Float => ktx2::Format::R16G16_SFLOAT,
            Self::Rgba32Float => ktx2::Format::R32G32B32A32_SFLOAT,
            Self::R32Uint => ktx2::Format::R32_UINT,
            Self::Rgba32Uint => ktx2::Format::R32G32B32A32_UINT,
            Self::Rgb9E5 => ktx2::Format::E5B9G9R9_UFLOAT_PACK32,
            Self::Rgb10A2Unorm => ktx2::Format::A2B10G10R10_UNORM_PACK32,
        }
    }

    /// Data format descriptor, with its length in front. Values are linear and have no colour semantics.
    pub(super) fn descriptor(self) -> Vec<u8> {
        let linear = Some(ktx2::TransferFunction::Linear);
        let (block, type_size) = ktx2::dfd::Basic::from_format_with(self.vulkan(), false, linear, None, None)
            .expect("every texel format has a descriptor");
        debug_assert_eq!(type_size as usize, self.component_bytes());
        let block = ktx2::dfd::Block::Basic(block).to_vec();
        let mut bytes = ((block.len() + 4) as u32).to_le_bytes().to_vec();
        bytes.extend_from_slice(&block);
        bytes
    }
}
