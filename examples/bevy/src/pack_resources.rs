//! What is bound for a pack of any codec, as the pack itself says it: Bevy's images, blocks and samplers.

use bevy::asset::{LoadContext, RenderAssetUsages, UntypedAssetId, VisitAssetDependencies};
use bevy::prelude::*;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    AddressMode, AsBindGroupError, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry, BindingResources,
    BindingType, BufferBindingType, BufferInitDescriptor, BufferUsages, Extent3d, FilterMode, MipmapFilterMode,
    OwnedBindingResource, PreparedBindGroup, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages,
    TextureDataOrder, TextureDimension, TextureFormat, TextureSampleType, TextureViewDescriptor, TextureViewDimension,
    WgpuFeatures,
};
use bevy::render::renderer::RenderDevice;
use bevy::render::texture::GpuImage;
use brdfc_formats::FormatError;
use brdfc_formats::bindings::{Binding, Bindings, FrameBlock, Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat};

/// Why a pack was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
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

/// What is bound at a slot.
#[derive(Debug, Clone)]
enum Bound {
    Block(Vec<u8>),
    Image(Handle<Image>),
    Sampler { repeats: bool },
}

/// Everything that a pack has bound, by slots.
#[derive(Debug, Clone)]
pub struct PackResources(Vec<(BindGroupLayoutEntry, Bound)>);

impl VisitAssetDependencies for PackResources {
    fn visit_dependencies(&self, visit: &mut impl FnMut(UntypedAssetId)) {
        for (_, bound) in &self.0 {
            if let Bound::Image(image) = bound {
                visit(image.id().untyped());
            }
        }
    }
}

impl PackResources {
    /// Makes images of a pack's textures, for a device with these features.
    ///
    /// # Errors
    /// A format that the device lacks.
    pub fn load(
        bindings: Bindings<'static>,
        frame: FrameBlock,
        features: WgpuFeatures,
        context: &mut LoadContext<'_>,
    ) -> Result<Self, PackError> {
        let mut all = Vec::with_capacity(bindings.all.len());
        for Binding { slot, name, resource } in bindings.all {
            let (ty, bound) = match resource {
                Resource::Frame => (BLOCK, Bound::Block(frame.to_bytes().to_vec())),
                Resource::Uniform(bytes) => (BLOCK, Bound::Block(bytes.into_owned())),
                Resource::Sampler { repeats } => {
                    (BindingType::Sampler(SamplerBindingType::Filtering), Bound::Sampler { repeats })
                }
                Resource::Texture(texels) => {
                    let ty = texture_type(&texels);
                    let image = pack_image(texels, features)?;
                    (ty, Bound::Image(context.add_labeled_asset(name.into_owned(), image)))
                }
            };
            all.push((
                BindGroupLayoutEntry { binding: slot, visibility: ShaderStages::FRAGMENT, ty, count: None },
                bound,
            ));
        }
        Ok(Self(all))
    }

    /// The layout of its group.
    pub fn layout(&self) -> Vec<BindGroupLayoutEntry> {
        self.0.iter().map(|(entry, _)| *entry).collect()
    }

    /// A group of that layout.
    ///
    /// # Errors
    /// [`AsBindGroupError::RetryNextUpdate`] until all images are on the GPU.
    pub fn bind(
        &self,
        label: &'static str,
        layout: &BindGroupLayout,
        device: &RenderDevice,
        images: &RenderAssets<GpuImage>,
    ) -> Result<PreparedBindGroup, AsBindGroupError> {
        let mut bindings = Vec::with_capacity(self.0.len());
        for (BindGroupLayoutEntry { binding, ty, .. }, bound) in &self.0 {
            let resource = match (bound, ty) {
                (Bound::Image(image), BindingType::Texture { view_dimension, .. }) => {
                    let image = images.get(image).ok_or(AsBindGroupError::RetryNextUpdate)?;
                    OwnedBindingResource::TextureView(*view_dimension, image.texture_view.clone())
                }
                (Bound::Sampler { repeats }, _) => {
                    OwnedBindingResource::Sampler(SamplerBindingType::Filtering, sampler(device, *repeats))
                }
                (Bound::Block(contents), _) => {
                    let usage = BufferUsages::UNIFORM;
                    let descriptor = BufferInitDescriptor { label: Some(label), contents, usage };
                    OwnedBindingResource::Buffer(device.create_buffer_with_data(&descriptor))
                }
                (Bound::Image(_), _) => unreachable!("images have textures in the layout"),
            };
            bindings.push((*binding, resource));
        }
        let entries = bindings
            .iter()
            .map(|(binding, resource)| BindGroupEntry { binding: *binding, resource: resource.get_binding() })
            .collect::<Vec<_>>();
        let bind_group = device.create_bind_group(label, layout, &entries);
        drop(entries);
        Ok(PreparedBindGroup { bindings: BindingResources(bindings), bind_group })
    }
}

const BLOCK: BindingType =
    BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };

fn texture_type(texels: &Texels<'_>) -> BindingType {
    let view_dimension = match texels.extent {
        Extent::D2(_) => TextureViewDimension::D2,
        Extent::D2Array(_) => TextureViewDimension::D2Array,
        Extent::D3(_) => TextureViewDimension::D3,
    };
    let sample_type = match texels.format.is_integer() {
        true => TextureSampleType::Uint,
        false => TextureSampleType::Float { filterable: texels.sampler.is_some() },
    };
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// Linear, also between mipmap levels.
fn sampler(device: &RenderDevice, repeats: bool) -> Sampler {
    let address = if repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
    device.create_sampler(&SamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: MipmapFilterMode::Linear,
        ..default()
    })
}

/// An image of these texels, for a device with these features. Where it lacks 16-bit integers, they become floats.
///
/// # Errors
/// Where the device lacks the format, and samplers that filter floats in its place.
fn pack_image(mut texels: Texels<'_>, features: WgpuFeatures) -> Result<Image, PackError> {
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
    image.data = Some(texels.bytes.into_owned());
    // An array of one layer would be none.
    if let Extent::D2Array(_) = texels.extent {
        let dimension = Some(TextureViewDimension::D2Array);
        image.texture_view_descriptor = Some(TextureViewDescriptor { dimension, ..default() });
    }
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
        let texels = || Texels::new(TexelFormat::R16Unorm, Extent::D3([2, 1, 1]), vec![0, 0, 255, 255]);
        let format = |features| pack_image(texels(), features).map(|image| image.texture_descriptor.format);
        let (sixteen, floats) = (WgpuFeatures::TEXTURE_FORMAT_16BIT_NORM, WgpuFeatures::FLOAT32_FILTERABLE);
        assert_eq!(format(sixteen).unwrap(), TextureFormat::R16Unorm);
        assert_eq!(format(floats).unwrap(), TextureFormat::Rgba32Float);
        assert!(matches!(format(WgpuFeatures::empty()), Err(PackError::Texels(TextureFormat::R16Unorm))));
        let image = pack_image(texels(), floats).unwrap();
        assert_eq!(image.data.unwrap()[16..], [1.0f32; 4].map(f32::to_le_bytes).concat());
    }
}
