//! Packs on the device: one bind group for either codec, so that one shader draws both.
//!
//! Bindings 0 to 3 are those of `formats/src/wavelet/decode.wgsl`, 4 to 7 those of `formats/src/table/decode.wgsl`; what the codec of a
//! pack does not use is empty.

use super::device::{Gpu, GpuError};
use brdfc_formats::BrdfPack;
use brdfc_formats::container::TexelFormat;
use brdfc_formats::table::shader::{TABLE_BRDF_WGSL, TableBrdfParameters};
use brdfc_formats::wavelet::Filter;
use brdfc_formats::wavelet::shader::{WAVELET_BRDF_WGSL, WaveletBrdfParameters, index_texels};
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    AddressMode, BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingResource,
    BindingType, BufferBindingType, BufferUsages, Extent3d, FilterMode, SamplerBindingType, SamplerDescriptor,
    ShaderStages, TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
    TextureViewDimension,
};

/// Chooses the decoder of a pack, behind both.
const BRDF_WGSL: &str = include_str!("brdf.wgsl");

/// First binding of tables.
const FIRST_OF_TABLE: u32 = 4;

/// Both decoders and what chooses between them, in this group.
pub(super) fn brdf_source(group: u32) -> String {
    [moved(WAVELET_BRDF_WGSL, group, 0), table_source(group), BRDF_WGSL.to_owned()].join("\n")
}

/// The decoder of tables alone, with its bindings where the layout has them.
pub(super) fn table_source(group: u32) -> String {
    moved(TABLE_BRDF_WGSL, group, FIRST_OF_TABLE)
}

/// A decoder with the bindings of its group 1 in another group, from `first` on.
pub(super) fn moved(source: &str, group: u32, first: u32) -> String {
    // From the last one, so that none is moved twice.
    (0..4).rev().fold(source.to_owned(), |source, binding| {
        let (from, to) = (binding, binding + first);
        source.replace(&format!("@group(1) @binding({from})"), &format!("@group({group}) @binding({to})"))
    })
}

/// How the device calls a texel format.
pub(super) fn texture_format(format: TexelFormat) -> TextureFormat {
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

/// The layout of group 1.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| BindGroupLayoutEntry { binding, visibility: stages, ty, count: None };
    let texture = |filterable, view_dimension| BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    let uniform =
        BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("pack"),
        entries: &[
            entry(0, uniform),
            entry(1, texture(true, TextureViewDimension::D3)),
            entry(2, texture(false, TextureViewDimension::D2)),
            entry(3, BindingType::Sampler(SamplerBindingType::Filtering)),
            entry(FIRST_OF_TABLE, uniform),
            entry(FIRST_OF_TABLE + 1, texture(true, TextureViewDimension::D3)),
            entry(FIRST_OF_TABLE + 2, BindingType::Sampler(SamplerBindingType::Filtering)),
            entry(FIRST_OF_TABLE + 3, texture(true, TextureViewDimension::D2)),
        ],
    })
}

/// What the decoders look up.
struct Contents<'a> {
    wavelet: [u8; WaveletBrdfParameters::SIZE],
    slices: (TexelFormat, [u32; 3], &'a [u8]),
    index: (u32, Vec<[f32; 4]>),
    table: [u8; TableBrdfParameters::SIZE],
    texels: (TexelFormat, [u32; 3], &'a [u8]),
    curve: (TexelFormat, [u32; 2], &'a [u8]),
}

impl<'a> Contents<'a> {
    fn new(pack: &'a BrdfPack, filter: Filter, distance_scale: f64) -> Self {
        let mut contents = Self {
            wavelet: [0; WaveletBrdfParameters::SIZE],
            slices: (TexelFormat::R8Unorm, [1; 3], &[0]),
            index: (1, vec![[0.0; 4]]),
            table: [0; TableBrdfParameters::SIZE],
            texels: (TexelFormat::R8Unorm, [1; 3], &[0]),
            curve: (TexelFormat::R8Unorm, [1; 2], &[0]),
        };
        match pack {
            BrdfPack::Wavelet(pack) => {
                let grid = pack.header.grid() as u32;
                contents.wavelet = WaveletBrdfParameters::new(pack, filter, distance_scale as f32).to_bytes();
                contents.slices = (pack.header.texel_format(), pack.extent(), &pack.texels);
                contents.index = (grid, index_texels(pack));
            }
            BrdfPack::Table(pack) => {
                let header = pack.header();
                contents.table = TableBrdfParameters::new(pack, distance_scale as f32).to_bytes();
                contents.texels = (header.texel_format(), pack.extent(), pack.texels());
                if let Some(curve) = pack.curve() {
                    let size = [curve.nodes() as u32, curve.levels() + 1];
                    contents.curve = (curve.texel_format(), size, curve.texels());
                }
            }
        }
        contents
    }
}

/// Uploads a pack. `filter` is that of wavelet packs.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    pack: &BrdfPack,
    filter: Filter,
    distance_scale: f64,
) -> Result<wgpu::BindGroup, GpuError> {
    let contents = Contents::new(pack, filter, distance_scale);
    let texture = |dimension, format, [width, height, depth_or_array_layers]: [u32; 3], bytes: &[u8]| {
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension,
            format,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    };
    let volume = |(format, size, bytes): (TexelFormat, [u32; 3], &[u8])| {
        texture(TextureDimension::D3, texture_format(format), size, bytes)
    };
    let (slices, texels) = (volume(contents.slices), volume(contents.texels));
    let (format, [nodes, rows], bytes) = contents.curve;
    let curve = texture(TextureDimension::D2, texture_format(format), [nodes, rows, 1], bytes);
    let (side, index) = contents.index;
    let index = bytemuck::cast_slice(&index);
    let index = texture(TextureDimension::D2, TextureFormat::Rgba32Float, [side, side, 1], index);
    let wavelet = gpu.buffer(&contents.wavelet, BufferUsages::UNIFORM);
    let table = gpu.buffer(&contents.table, BufferUsages::UNIFORM);
    let sampler = gpu.device.create_sampler(&SamplerDescriptor {
        address_mode_u: AddressMode::ClampToEdge,
        address_mode_v: AddressMode::ClampToEdge,
        address_mode_w: AddressMode::ClampToEdge,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..SamplerDescriptor::default()
    });
    let resources = [
        wavelet.as_entire_binding(),
        BindingResource::TextureView(&slices),
        BindingResource::TextureView(&index),
        BindingResource::Sampler(&sampler),
        table.as_entire_binding(),
        BindingResource::TextureView(&texels),
        BindingResource::Sampler(&sampler),
        BindingResource::TextureView(&curve),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
    let group = gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries });
    gpu.check()?;
    Ok(group)
}
