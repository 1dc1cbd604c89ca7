//! Device features and limits that textures require.

use brdfc_formats::container::{Extent, TexelFormat};
use schemars::JsonSchema;
use serde::Serialize;

/// Maximum sides and layers that every device with WebGPU supports by default.
const WEBGPU: Limits = Limits { side: 8192, depth: 2048, layers: 256 };
/// Maximum sides and layers of WebGL 2. Except for old phones, its devices support as much as devices with WebGPU.
const WEBGL_2: Limits = Limits { side: 2048, depth: 256, layers: 256 };

#[derive(Clone, Copy)]
struct Limits {
    /// Limit for 2D textures, arrays and cube maps.
    side: u32,
    /// Limit for each side of a 3D texture.
    depth: u32,
    layers: u32,
}

/// Requirements of textures beyond the guaranteed features and limits. All fields are empty if there are none.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DeviceNeeds {
    /// Optional features of WebGPU. A loader may instead unpack such texels to 32-bit floats. Samplers filter those
    /// only with the feature 'float32-filterable', shaders without it.
    pub webgpu_features: Vec<&'static str>,
    /// Extensions of WebGL 2, with the same alternative.
    pub webgl_2_extensions: Vec<&'static str>,
    /// Sizes beyond the default limits of WebGPU.
    pub beyond_webgpu: Vec<String>,
    /// Sizes beyond the minimum limits of WebGL 2.
    pub beyond_webgl_2: Vec<String>,
}

impl DeviceNeeds {
    /// Requirements of one texture.
    pub fn of(format: TexelFormat, extent: Extent) -> Self {
        let is_wide = matches!(format, TexelFormat::R16Unorm | TexelFormat::Rgba16Unorm);
        Self {
            webgpu_features: if is_wide { vec!["texture-formats-tier1"] } else { Vec::new() },
            webgl_2_extensions: if is_wide { vec!["EXT_texture_norm16"] } else { Vec::new() },
            beyond_webgpu: beyond(extent, WEBGPU),
            beyond_webgl_2: beyond(extent, WEBGL_2),
        }
    }

    /// Requirements of both.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        let add = |all: &mut Vec<String>, more: Vec<String>| {
            for one in more {
                if !all.contains(&one) {
                    all.push(one);
                }
            }
        };
        add(&mut self.beyond_webgpu, other.beyond_webgpu);
        add(&mut self.beyond_webgl_2, other.beyond_webgl_2);
        for feature in other.webgpu_features {
            if !self.webgpu_features.contains(&feature) {
                self.webgpu_features.push(feature);
            }
        }
        for extension in other.webgl_2_extensions {
            if !self.webgl_2_extensions.contains(&extension) {
                self.webgl_2_extensions.push(extension);
            }
        }
        self
    }

    /// Summary in one line.
    pub fn summary(&self) -> String {
        let mut words = Vec::new();
        if !self.webgpu_features.is_empty() {
            let features = self.webgpu_features.join(", ");
            let extensions = self.webgl_2_extensions.join(", ");
            words.push(format!("{features} of WebGPU, {extensions} of WebGL 2, or texels unpacked to 32-bit floats"));
        }
        if !self.beyond_webgpu.is_empty() {
            words.push(format!("more than WebGPU's default limits: {}", self.beyond_webgpu.join(", ")));
        } else if !self.beyond_webgl_2.is_empty() {
            words.push(format!("more than WebGL 2 guarantees: {}", self.beyond_webgl_2.join(", ")));
        }
        if words.is_empty() { "any with WebGPU or WebGL 2".to_owned() } else { words.join("; ") }
    }
}

fn beyond(extent: Extent, limits: Limits) -> Vec<String> {
    let mut all = Vec::new();
    let mut hold = |found: u32, allowed: u32, what: &str| {
        if found > allowed {
            all.push(format!("{found} {what} (limit {allowed})"));
        }
    };
    match extent {
        Extent::D2([width, height]) => hold(width.max(height), limits.side, "texels along a side"),
        Extent::D2Array([width, height, layers]) => {
            hold(width.max(height), limits.side, "texels along a side");
            hold(layers, limits.layers, "layers");
        }
        Extent::Cube(side) => hold(side, limits.side, "texels along a side"),
        Extent::D3(sides) => hold(sides.into_iter().max().unwrap_or(0), limits.depth, "texels along a side in 3D"),
    }
    all
}
