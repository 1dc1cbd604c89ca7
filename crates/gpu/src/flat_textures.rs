//! Flat BTFs on the device: the bind group that `formats/src/flat_btf/decoder.wgsl` declares, with what
//! `formats/src/flat_btf/factored/factored.wgsl` adds.

use super::device::{Gpu, GpuError};
use super::factored_textures::{self, FactoredTextures};
use super::pack::texture_format;
use super::raster::{buffer_type, entry};
use brdfc_formats::container::TexelFormat;
use brdfc_formats::flat_btf::factored::shader::FactoredFilter;
use brdfc_formats::flat_btf::shader::{FlatBtfParameters, IndirectionFilter};
use brdfc_formats::flat_btf::{Atlas, FlatBtfDecoder, Indirection, SampledDirections};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindingResource, BindingType, BufferBindingType, BufferUsages, Extent3d, FilterMode, Limits, Origin3d,
    SamplerBindingType, SamplerDescriptor, ShaderStages, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
    TextureDescriptor, TextureDimension, TextureSampleType, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension,
};

/// The binding of what blends views and lights.
const DIRECTIONS: u32 = 13;
/// What to do about views that are too large.
const ADVICE: &str = "draw the light form, or make the flat BTF with fewer texels";

/// The layout of group 1, those of [`factored_textures`] included.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> BindGroupLayout {
    let texture_of = |sample_type, binding, view_dimension| {
        entry(binding, stages, BindingType::Texture { sample_type, view_dimension, multisampled: false })
    };
    let texture = |binding, filterable, view_dimension| {
        texture_of(TextureSampleType::Float { filterable }, binding, view_dimension)
    };
    let own = [
        entry(0, stages, buffer_type(BufferBindingType::Uniform)),
        texture(1, false, TextureViewDimension::D2),
        texture(2, true, TextureViewDimension::D2),
        entry(3, stages, BindingType::Sampler(SamplerBindingType::Filtering)),
        texture(4, true, TextureViewDimension::D2),
        texture(5, true, TextureViewDimension::D2),
        texture(6, true, TextureViewDimension::D2Array),
        texture(7, true, TextureViewDimension::D2),
        texture_of(TextureSampleType::Uint, DIRECTIONS, TextureViewDimension::D2),
    ];
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("flat BTF"),
        entries: &[&own[..], &factored_textures::entries(stages)].concat(),
    })
}

/// Uploads the parts; without `values`, or where there are none, textures of the full form are one empty texel, and so is that
/// of `directions`, which only `flat_btf_value` reads. The filter is
/// that of the indirection and of what is factored.
///
/// # Errors
/// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    decoder: &FlatBtfDecoder,
    filter: IndirectionFilter,
    values: bool,
    directions: Option<&SampledDirections>,
) -> Result<BindGroup, GpuError> {
    let parts = decoder.parts();
    let packed = parts.indirection.header().extent();
    let most = gpu.device.limits().max_texture_dimension_2d;
    for (part, side) in [
        ("indirection", packed[0].max(packed[1])),
        ("reference", parts.reference.size()),
        ("diffuse", parts.diffuse.size()),
    ] {
        if side > most {
            let text = format!("the part {part} has {side} texels on a side; this adapter takes {most}");
            return Err(GpuError::TooLarge(text));
        }
    }
    let atlas = atlas(gpu, decoder, values)?;
    let factored_filter = match filter {
        IndirectionFilter::Exact => FactoredFilter::Exact,
        IndirectionFilter::Hardware => FactoredFilter::Hardware,
    };
    let factored = parts.values.factored().filter(|_| values);
    let factored = FactoredTextures::upload(gpu, factored, factored_filter)?;
    let image = |format, size, bytes: &[u8]| gpu.image(texture_format(format), size, bytes);
    let size = [parts.diffuse.size(); 2];
    let parameters = bytemuck::cast_slice(parts.reference.parameters());
    let reference = image(TexelFormat::Rg32Float, [parts.reference.size(); 2], parameters);
    let (extent, words) = directions.map_or(([1; 2], vec![0]), |some| (some.extent(), some.texels()));
    let directions = image(TexelFormat::R32Uint, extent, bytemuck::cast_slice(&words));
    let (packed, ranges) = match &parts.indirection {
        Indirection::Samples(map) => (
            image(TexelFormat::Rgba16Float, packed, &map.texel_bytes()),
            image(TexelFormat::Rgba16Float, [1; 2], &[0; 8]),
        ),
        Indirection::Compact(map) => (
            image(TexelFormat::Rg8Unorm, packed, map.texel_bytes()),
            image(TexelFormat::Rgba16Float, [map.header().blocks.size; 2], &map.range_bytes()),
        ),
    };
    let normal = image(TexelFormat::Rgba16Float, size, &parts.normal.texel_bytes());
    let diffuse = image(TexelFormat::Rgb9E5, size, bytemuck::cast_slice(parts.diffuse.texels()));
    let parameters = gpu.buffer(&FlatBtfParameters::new(decoder, filter).to_bytes(), BufferUsages::UNIFORM);
    let sampler = gpu.device.create_sampler(&SamplerDescriptor {
        address_mode_u: AddressMode::ClampToEdge,
        address_mode_v: AddressMode::ClampToEdge,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..SamplerDescriptor::default()
    });
    let own = [
        BindGroupEntry { binding: 0, resource: parameters.as_entire_binding() },
        BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&reference) },
        BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&packed) },
        BindGroupEntry { binding: 3, resource: BindingResource::Sampler(&sampler) },
        BindGroupEntry { binding: 4, resource: BindingResource::TextureView(&normal) },
        BindGroupEntry { binding: 5, resource: BindingResource::TextureView(&diffuse) },
        BindGroupEntry { binding: 6, resource: BindingResource::TextureView(&atlas) },
        BindGroupEntry { binding: 7, resource: BindingResource::TextureView(&ranges) },
        BindGroupEntry { binding: DIRECTIONS, resource: BindingResource::TextureView(&directions) },
    ];
    let entries = [&own[..], &factored.bindings()].concat();
    let group = gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries });
    gpu.check()?;
    Ok(group)
}

/// All views and lights in one 2D array.
fn atlas(gpu: &Gpu, decoder: &FlatBtfDecoder, views: bool) -> Result<TextureView, GpuError> {
    let count = if views { decoder.parts().values.views().len() as u32 } else { 0 };
    let atlas = decoder.atlas();
    let [width, height] = atlas_extent(atlas, count, &gpu.device.limits())?;
    let size = Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d { depth_or_array_layers: count.max(1), ..size },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: texture_format(TexelFormat::Rgb9E5),
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.check().map_err(|error| {
        let megabytes = (u64::from(width) * u64::from(height) * u64::from(count) * 4) >> 20;
        GpuError::TooLarge(format!("the views take {megabytes} MiB of graphics memory ({error}): {ADVICE}"))
    })?;
    // One layer at a time: no second copy of everything in memory.
    for (layer, view) in (0..count).zip(decoder.parts().values.views()) {
        let origin = Origin3d { x: 0, y: 0, z: layer };
        let target = TexelCopyTextureInfo { texture: &texture, mip_level: 0, origin, aspect: TextureAspect::All };
        let rows = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: Some(height) };
        gpu.queue.write_texture(target, bytemuck::cast_slice(&atlas.layer(view)), rows, size);
        gpu.queue.submit([]);
    }
    gpu.wait()?;
    let dimension = Some(TextureViewDimension::D2Array);
    Ok(texture.create_view(&TextureViewDescriptor { dimension, ..TextureViewDescriptor::default() }))
}

/// Width and height of the array of `views` layers, or why an adapter does not take it.
fn atlas_extent(atlas: Atlas, views: u32, limits: &Limits) -> Result<[u32; 2], GpuError> {
    let [width, height] = if views == 0 { [1, 1] } else { atlas.extent() };
    let (most, most_layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    if width > most || height > most {
        let (size, lights) = (atlas.size, atlas.lights);
        return Err(GpuError::TooLarge(format!(
            "{lights} lights of {size} x {size} texels take a texture of {width} x {height}; this adapter takes {most} \
             on a side: {ADVICE}"
        )));
    }
    if views > most_layers {
        let text =
            format!("{views} views; this adapter takes {most_layers} layers: draw the light form, or make fewer");
        return Err(GpuError::TooLarge(text));
    }
    Ok([width, height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_layers_within_limits() {
        let limits = Limits { max_texture_dimension_2d: 2304, max_texture_array_layers: 81, ..Limits::default() };
        let extent = |size, lights, views| atlas_extent(Atlas::new(size, lights), views, &limits);
        assert_eq!(extent(256, 81, 81), Ok([2304, 2304]));
        let Err(GpuError::TooLarge(text)) = extent(256, 82, 81) else { panic!("too wide") };
        assert_eq!(
            text,
            "82 lights of 256 x 256 texels take a texture of 2560 x 2304; this adapter takes 2304 on a side: draw the \
             light form, or make the flat BTF with fewer texels"
        );
        assert!(extent(257, 81, 81).is_err() && extent(256, 81, 82).is_err());
        // Nothing is uploaded without views.
        assert_eq!(extent(4096, 81, 0), Ok([1, 1]));
    }
}
