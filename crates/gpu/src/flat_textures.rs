//! Flat BTFs on the device: the bind group that `formats/src/flat_btf/decoder.wgsl` declares, with what `vdim.wgsl`, and
//! `factored/factored.wgsl` or the look-up of trees add.

use super::bindings::{IMAGE, INTEGERS, LAYERS, SAMPLER, Slots, UNIFORM, VOLUME};
use super::device::{Gpu, GpuError};
use brdfc_formats::PackKind;
use brdfc_formats::bindings::{Bindings, FRAME_SLOT, FrameBlock};
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};
use brdfc_formats::pwt::shader::TEXTURE_SLOTS;
use wgpu::{BindGroup, BindingType, Limits, ShaderStages};

/// Names of the textures in messages.
const PARTS: [(&str, &str); 6] = [
    ("flat_btf_heights", "layers"),
    ("flat_btf_displacements", "layers"),
    ("flat_btf_vdim", "indirection map"),
    ("factored_weights", "weights"),
    ("factored_basis", "basis"),
    ("pwt_texture_0", "trees"),
];
/// Images with a layer per light, which may be more than an adapter takes.
const OF_LIGHTS: [&str; 2] = ["factored_residual", "flat_btf_shadows"];

/// Layout of group 1 for a kind of flat BTF.
pub fn slots(gpu: &Gpu, kind: PackKind, stages: ShaderStages) -> Slots {
    let relief = (15..).zip([UNIFORM, IMAGE, LAYERS, SAMPLER, IMAGE, IMAGE]);
    let reflectance: Vec<(u32, BindingType)> = match kind {
        PackKind::FlatBtfTrees => {
            let trees = [(9, UNIFORM), (14, SAMPLER), (28, INTEGERS), (43, LAYERS), (44, SAMPLER), (49, UNIFORM)];
            trees.into_iter().chain(TEXTURE_SLOTS.map(|slot| (slot, LAYERS))).collect()
        }
        _ => (21..).zip([LAYERS, VOLUME, UNIFORM, LAYERS, LAYERS, INTEGERS, SAMPLER, INTEGERS]).collect(),
    };
    Slots::new(gpu, "flat BTF", stages, [(FRAME_SLOT, UNIFORM)].into_iter().chain(relief).chain(reflectance))
}

/// Uploads a flat BTF. Without `directions` their texture is one empty texel.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more than the adapter takes; any error that the driver reports.
pub fn upload(
    gpu: &Gpu,
    slots: &Slots,
    decoder: &FlatBtfDecoder,
    frame: FrameBlock,
    directions: Option<&SampledDirections>,
) -> Result<BindGroup, GpuError> {
    let bindings = decoder.bindings(directions);
    fits(&bindings, &gpu.device.limits())?;
    slots.bind(gpu, &bindings.all, frame)
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
        if OF_LIGHTS.contains(&name) && layers > most {
            let text = format!("found {layers} lights, expected at most {most} on this adapter");
            return Err(GpuError::TooLarge(text + "; make the flat BTF with fewer lights"));
        }
    }
    Ok(())
}
