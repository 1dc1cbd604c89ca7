//! What is bound for packs, as Bevy has it: images and vectors of uniform blocks.

use bevy::asset::{ReadAssetBytesError, RenderAssetUsages};
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{
    Extent3d, TextureDataOrder, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension,
    WgpuFeatures,
};
use bevy::render::renderer::RenderDevice;
use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_shaders::resources::Texels;

/// Why a pack was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A file beside it cannot be read.
    #[error(transparent)]
    Part(#[from] ReadAssetBytesError),
    /// No pack of this kind, or one that breaks the rules of its kind.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A texture that this device cannot have.
    #[error("texels of {0:?}, which this device does not have; encode the pack with --bits 8")]
    Texels(TextureFormat),
}

/// What textures of this app may need. Without a device, as on a server, packs are loaded but never drawn.
pub fn features(app: &App) -> WgpuFeatures {
    app.world().get_resource::<RenderDevice>().map_or(WgpuFeatures::all(), RenderDevice::features)
}

/// The words of a uniform block, and zeros behind them.
pub fn vectors<const N: usize>(bytes: &[u8]) -> [UVec4; N] {
    let mut all = [UVec4::ZERO; N];
    for (k, word) in bytes.chunks_exact(4).take(4 * N).enumerate() {
        all[k / 4][k % 4] = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
    }
    all
}

/// An image of these texels, for a device with these features. Its sampler is linear; it repeats or is clamped to the edge. Where the
/// device lacks 16-bit integers, they become floats.
///
/// # Errors
/// Where the device lacks the format, and samplers that filter floats in its place.
pub fn pack_image(mut texels: Texels, repeats: bool, features: WgpuFeatures) -> Result<Image, PackError> {
    let stored = texture_format(texels.format);
    if !features.contains(stored.required_features()) {
        texels = texels.widened();
        if texture_format(texels.format) == stored || !features.contains(WgpuFeatures::FLOAT32_FILTERABLE) {
            return Err(PackError::Texels(stored));
        }
    }
    let format = texture_format(texels.format);
    let (dimension, [width, height, depth_or_array_layers]) = match texels.extent {
        Extent::D2([width, height]) => (TextureDimension::D2, [width, height, 1]),
        Extent::D2Array(size) => (TextureDimension::D2, size),
        Extent::D3(size) => (TextureDimension::D3, size),
    };
    let size = Extent3d { width, height, depth_or_array_layers };
    let mut image = Image::new_uninit(size, dimension, format, RenderAssetUsages::RENDER_WORLD);
    image.texture_descriptor.mip_level_count = texels.levels;
    // All layers of a level stand before the next level.
    image.data_order = TextureDataOrder::MipMajor;
    image.data = Some(texels.bytes);
    // An array of one layer would be none.
    if let Extent::D2Array(_) = texels.extent {
        let dimension = Some(TextureViewDimension::D2Array);
        image.texture_view_descriptor = Some(TextureViewDescriptor { dimension, ..default() });
    }
    let address = if repeats { ImageAddressMode::Repeat } else { ImageAddressMode::ClampToEdge };
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        ..default()
    });
    Ok(image)
}

fn texture_format(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::R8Unorm => TextureFormat::R8Unorm,
        TexelFormat::Rg8Unorm => TextureFormat::Rg8Unorm,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::R16Unorm => TextureFormat::R16Unorm,
        TexelFormat::R16Float => TextureFormat::R16Float,
        TexelFormat::Rgba16Unorm => TextureFormat::Rgba16Unorm,
        TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
        TexelFormat::Rg32Float => TextureFormat::Rg32Float,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
        TexelFormat::R32Uint => TextureFormat::R32Uint,
        TexelFormat::Rgba32Uint => TextureFormat::Rgba32Uint,
        TexelFormat::Rgb9E5 => TextureFormat::Rgb9e5Ufloat,
        TexelFormat::Rgb10A2Unorm => TextureFormat::Rgb10a2Unorm,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_of_16_bits_become_floats_where_a_device_lacks_them() {
        let texels = || Texels {
            format: TexelFormat::R16Unorm,
            extent: Extent::D3([2, 1, 1]),
            levels: 1,
            bytes: vec![0, 0, 255, 255],
        };
        let format = |features| pack_image(texels(), false, features).map(|image| image.texture_descriptor.format);
        let (sixteen, floats) = (WgpuFeatures::TEXTURE_FORMAT_16BIT_NORM, WgpuFeatures::FLOAT32_FILTERABLE);
        assert_eq!(format(sixteen).unwrap(), TextureFormat::R16Unorm);
        assert_eq!(format(floats).unwrap(), TextureFormat::Rgba32Float);
        assert!(matches!(format(WgpuFeatures::empty()), Err(PackError::Texels(TextureFormat::R16Unorm))));
        let image = pack_image(texels(), false, floats).unwrap();
        assert_eq!(image.data.unwrap()[16..], [1.0f32; 4].map(f32::to_le_bytes).concat());
    }
}
