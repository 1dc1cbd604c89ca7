//! Shading languages.

/// A language of engines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Language {
    /// WebGPU, wgpu, Bevy.
    Wgsl,
    /// OpenGL 3.3 and later, Vulkan by way of a compiler, Godot.
    Glsl,
    /// WebGL 2, OpenGL ES 3: three.js, Babylon.js.
    Essl300,
    /// Direct3D, Unity, Unreal.
    Hlsl,
    /// Metal.
    Msl,
    /// Vulkan: a compute shader.
    Spirv,
}

impl Language {
    /// All languages.
    pub const ALL: [Self; 6] = [Self::Wgsl, Self::Glsl, Self::Essl300, Self::Hlsl, Self::Msl, Self::Spirv];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Glsl => "glsl",
            Self::Essl300 => "essl300",
            Self::Hlsl => "hlsl",
            Self::Msl => "msl",
            Self::Spirv => "spirv",
        }
    }

    /// The language with this [`Self::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|language| language.name() == name)
    }

    /// The language and its version, for messages.
    pub fn title(self) -> &'static str {
        match self {
            Self::Wgsl => "WGSL",
            Self::Glsl => "GLSL 3.30 and later",
            Self::Essl300 => "GLSL ES 3.00 and later",
            Self::Hlsl => "HLSL, shader model 5.1 and later",
            Self::Msl => "MSL 2.0 and later",
            Self::Spirv => "SPIR-V 1.3",
        }
    }
}
