//! Flat BTFs on the device: the bind group that `formats/src/flat_btf/decoder.wgsl` declares, with what
//! `formats/src/flat_btf/factored/factored.wgsl` adds.

use super::bindings::{IMAGE, INTEGERS, LAYERS, SAMPLER, Slots, UNFILTERED, UNIFORM, texture_format};
use super::device::{Gpu, GpuError};
use brdfc_formats::bindings::{Bindings, FRAME_SLOT, FrameBlock};
use brdfc_formats::container::TexelFormat;
use brdfc_formats::flat_btf::shader::VALUES_SLOT;
use brdfc_formats::flat_btf::{Atlas, FlatBtfDecoder, FlatView, SampledDirections};
use wgpu::{
    BindGroup, Extent3d, Limits, Origin3d, ShaderStages, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
    TextureDescriptor, TextureDimension, TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension,
};

/// Names of the textures in messages. The texture of shadows has the most layers, one per light.
const PARTS: [(&str, &str); 5] = [
    ("flat_btf_reference", "reference plane"),
    ("flat_btf_packed_indirection", "indirection"),
    ("flat_btf_diffuse", "diffuse colours"),
    ("factored_weights", "weights"),
    ("factored_basis", "basis"),
];
const SHADOW: &str = "factored_shadow";
/// Advice for views that are too large.
const ADVICE: &str = "draw the light form, or make the flat BTF with fewer texels";

/// Layout of group 1.
pub fn slots(gpu: &Gpu, stages: ShaderStages) -> Slots {
    let own = [UNIFORM, UNFILTERED, IMAGE, SAMPLER, IMAGE, IMAGE, LAYERS, IMAGE];
    let factored = [UNIFORM, LAYERS, LAYERS, INTEGERS, SAMPLER];
    let types = (15..).zip(own.into_iter().chain(factored).chain([INTEGERS]));
    Slots::new(gpu, "flat BTF", stages, [(FRAME_SLOT, UNIFORM)].into_iter().chain(types))
}

/// Uploads a flat BTF. Without `values`, textures of the full form are one empty texel. So is the texture of
/// `directions`, which only `flat_btf_value` reads.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more than the adapter takes; any error that the driver reports.
pub fn upload(
    gpu: &Gpu,
    slots: &Slots,
    decoder: &FlatBtfDecoder,
    frame: FrameBlock,
    values: bool,
    directions: Option<&SampledDirections>,
) -> Result<BindGroup, GpuError> {
    let views = if values { decoder.parts().values.views() } else { &[] };
    let bindings = decoder.bindings(values, directions);
    fits(&bindings, &gpu.device.limits())?;
    let views = atlas(gpu, decoder, views)?;
    slots.bind(gpu, &bindings.all, frame, &[(VALUES_SLOT, &views)])
}

/// Returns an error unless an adapter takes the textures.
fn fits(bindings: &Bindings<'_>, limits: &Limits) -> Result<(), GpuError> {
    for (name, texels) in bindings.textures() {
        let ([width, height, layers], most) = (texels.extent.size(), limits.max_texture_dimension_2d);
        let (side, part) = (width.max(height), PARTS.iter().find(|(of, _)| *of == name));
        if let Some((_, part)) = part
            && side > most
        {
            let text = format!("{part}: found {side} texels per side, expected at most {most} on this adapter");
            return Err(GpuError::TooLarge(text));
        }
        let most = limits.max_texture_array_layers;
        if name == SHADOW && layers > most {
            let text = format!("found {layers} lights, expected at most {most} on this adapter");
            return Err(GpuError::TooLarge(text + "; draw the light form, or make the flat BTF with fewer lights"));
        }
    }
    Ok(())
}

/// Uploads all views and lights as one 2D array.
fn atlas(gpu: &Gpu, decoder: &FlatBtfDecoder, views: &[FlatView]) -> Result<TextureView, GpuError> {
    let (atlas, count) = (decoder.atlas(), views.len() as u32);
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
        GpuError::TooLarge(format!("the views take {megabytes} MiB of graphics memory ({error}); {ADVICE}"))
    })?;
    // One layer at a time, to avoid a second copy of everything in memory.
    for (layer, view) in (0..count).zip(views) {
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

/// Width and height of the array of `views` layers. Returns an error if the adapter does not take it.
fn atlas_extent(atlas: Atlas, views: u32, limits: &Limits) -> Result<[u32; 2], GpuError> {
    let [width, height] = if views == 0 { [1, 1] } else { atlas.extent() };
    let (most, most_layers) = (limits.max_texture_dimension_2d, limits.max_texture_array_layers);
    if width > most || height > most {
        let (size, lights) = (atlas.size, atlas.lights);
        return Err(GpuError::TooLarge(format!(
            "found a texture of {width} x {height} for {lights} lights of {size} x {size} texels, expected at most \
             {most} per side on this adapter; {ADVICE}"
        )));
    }
    if views > most_layers {
        let text = format!("found {views} views, expected at most {most_layers} on this adapter");
        return Err(GpuError::TooLarge(text + "; draw the light form, or make the flat BTF with fewer views"));
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
            "found a texture of 2560 x 2304 for 82 lights of 256 x 256 texels, expected at most 2304 per side on this \
             adapter; draw the light form, or make the flat BTF with fewer texels"
        );
        assert!(extent(257, 81, 81).is_err() && extent(256, 81, 82).is_err());
        // Without views, the array is one empty texel.
        assert_eq!(extent(4096, 81, 0), Ok([1, 1]));
    }
}
