//! Uploads a pack of any codec, using its own list of bindings.

use bevy::image::{ImageAddressMode, ImageSamplerDescriptor};
use bevy::render::render_resource::*;
use bevy::render::renderer::{RenderDevice, RenderQueue};
use brdfc_formats::FormatError;
use brdfc_formats::bindings::{Binding, FrameBlock, Resource, Texels};
use serde::de::value::{Error, StrDeserializer};

/// Uploads the resources of packs, and makes a bind group of them by slots.
///
/// # Errors
/// Returns an error for a texture that the device cannot filter.
pub fn upload(
    bindings: Vec<Binding<'_>>,
    frame: FrameBlock,
    device: &RenderDevice,
    queue: &RenderQueue,
) -> Result<(Vec<BindGroupLayoutEntry>, BindGroup), FormatError> {
    let block = |contents: &[u8]| {
        let descriptor = BufferInitDescriptor { label: None, contents, usage: BufferUsages::UNIFORM };
        let buffer = device.create_buffer_with_data(&descriptor);
        (binding_types::uniform_buffer_sized(false, None), OwnedBindingResource::Buffer(buffer))
    };
    let (mut layout, mut resources) = (Vec::new(), Vec::new());
    for binding in bindings {
        let (ty, resource) = match binding.resource {
            Resource::Frame => block(&frame.to_bytes()),
            Resource::Uniform(bytes) => block(&bytes),
            Resource::Sampler { repeats } => {
                let mode = if repeats { ImageAddressMode::Repeat } else { ImageAddressMode::ClampToEdge };
                let sampler = device.create_sampler(&ImageSamplerDescriptor::linear().set_address_mode(mode).as_wgpu());
                let ty = SamplerBindingType::Filtering;
                (binding_types::sampler(ty), OwnedBindingResource::Sampler(ty, sampler))
            }
            Resource::Texture(texels) => {
                let texels = supported(&binding.name, texels, device.features())?;
                let dimension: TextureViewDimension = webgpu(texels.extent.dimension());
                let [width, height, depth_or_array_layers] = texels.extent.size();
                let descriptor = TextureDescriptor {
                    label: None,
                    size: Extent3d { width, height, depth_or_array_layers },
                    mip_level_count: texels.levels,
                    sample_count: 1,
                    dimension: dimension.compatible_texture_dimension(),
                    format: webgpu(texels.format.name()),
                    usage: TextureUsages::TEXTURE_BINDING,
                    view_formats: &[],
                };
                let order = TextureDataOrder::MipMajor;
                let texture = device.create_texture_with_data(queue, &descriptor, order, &texels.bytes);
                let view = TextureViewDescriptor { dimension: Some(dimension), ..Default::default() };
                let float = TextureSampleType::Float { filterable: texels.sampler.is_some() };
                let sample_type = if texels.format.is_integer() { TextureSampleType::Uint } else { float };
                let ty = BindingType::Texture { sample_type, view_dimension: dimension, multisampled: false };
                let view = OwnedBindingResource::TextureView(dimension, texture.create_view(&view));
                (ty.into_bind_group_layout_entry_builder(), view)
            }
        };
        layout.push(ty.build(binding.slot, ShaderStages::FRAGMENT));
        resources.push(resource);
    }
    let entries = layout.iter().zip(&resources);
    let entries = entries.map(|(ty, made)| BindGroupEntry { binding: ty.binding, resource: made.get_binding() });
    let group_layout = device.create_bind_group_layout(None, &layout);
    let group = device.create_bind_group(None, &group_layout, &entries.collect::<Vec<_>>());
    Ok((layout, group))
}

/// Converts texels to a format that a device with these features supports, and filters if a sampler does: 16-bit integers may become
/// 32-bit floats. Every device loads these, but only one with `FLOAT32_FILTERABLE` filters them.
///
/// # Errors
/// Returns an error for a texture that the device cannot filter.
fn supported<'a>(name: &str, mut texels: Texels<'a>, features: WgpuFeatures) -> Result<Texels<'a>, FormatError> {
    let stored = texels.format.name();
    let is_supported = |texels: &Texels<'_>| {
        let format: TextureFormat = webgpu(texels.format.name());
        let filters = format.sample_type(None, Some(features)) == Some(TextureSampleType::Float { filterable: true });
        features.contains(format.required_features()) && (filters || texels.sampler.is_none())
    };
    if !is_supported(&texels) {
        texels = texels.widened();
    }
    if !is_supported(&texels) {
        let allowed = "a device with FLOAT32_FILTERABLE, or a pack encoded with --bits 8";
        return Err(FormatError::whole(format!("texture {name}"), format!("{stored} to filter"), allowed));
    }
    Ok(texels)
}

/// Converts a word of WebGPU to its wgpu type; packs use these words for formats and dimensions.
fn webgpu<T: serde::Deserialize<'static>>(word: &'static str) -> T {
    T::deserialize(StrDeserializer::<Error>::new(word)).expect("a word of WebGPU")
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::container::{Extent, TexelFormat};

    const SIXTEEN: WgpuFeatures = WgpuFeatures::TEXTURE_FORMAT_16BIT_NORM;
    const FILTERABLE: WgpuFeatures = WgpuFeatures::FLOAT32_FILTERABLE;

    fn texels(format: TexelFormat) -> Texels<'static> {
        Texels::new(format, Extent::D3([2, 1, 1]), vec![255; 2 * format.texel_bytes()])
    }

    #[test]
    fn textures_need_features_for_what_samplers_filter() {
        use TexelFormat::{R8Unorm, R16Unorm, R32Uint, Rgba32Float};
        let none = WgpuFeatures::empty();
        for (stored, features, expected) in [
            (R16Unorm, none, Rgba32Float),
            (R16Unorm, FILTERABLE, Rgba32Float),
            (R16Unorm, SIXTEEN, R16Unorm),
            (Rgba32Float, none, Rgba32Float),
            (R32Uint, none, R32Uint),
        ] {
            assert_eq!(supported("it", texels(stored), features).unwrap().format, expected, "{features:?}");
        }
        for (stored, features, expected) in [
            (R8Unorm, none, Some(R8Unorm)),
            (R16Unorm, none, None),
            (R16Unorm, SIXTEEN, Some(R16Unorm)),
            (R16Unorm, FILTERABLE, Some(Rgba32Float)),
            (Rgba32Float, none, None),
            (Rgba32Float, SIXTEEN, None),
            (Rgba32Float, FILTERABLE, Some(Rgba32Float)),
        ] {
            let found = supported("it", texels(stored).sampled("s"), features);
            let refused = format!(
                "texture it: found {} to filter, expected a device with FLOAT32_FILTERABLE, or a pack encoded with --bits 8",
                stored.name()
            );
            let found = found.map(|texels| texels.format).map_err(|error| error.to_string());
            assert_eq!(found, expected.ok_or(refused), "{features:?}");
        }
    }

    #[test]
    fn wgpu_has_the_words_of_packs() {
        for format in TexelFormat::ALL {
            let found: TextureFormat = webgpu(format.name());
            assert_eq!(found.block_copy_size(None), Some(format.texel_bytes() as u32), "{found:?}");
        }
        let dimension = |extent: Extent| -> TextureViewDimension { webgpu(extent.dimension()) };
        assert_eq!(dimension(Extent::D2([1; 2])), TextureViewDimension::D2);
        assert_eq!(dimension(Extent::D2Array([1; 3])), TextureViewDimension::D2Array);
        assert_eq!(dimension(Extent::D3([1; 3])), TextureViewDimension::D3);
        let cube = dimension(Extent::Cube(1));
        assert_eq!((cube, cube.compatible_texture_dimension()), (TextureViewDimension::Cube, TextureDimension::D2));
    }
}
