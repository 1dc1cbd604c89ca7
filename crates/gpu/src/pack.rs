//! Packs of BRDFs on the device: one bind group for all codecs, so that one shader draws them all. Slots that a pack's
//! codec does not use are bound to zeros.

use super::bindings::{IMAGE, INTEGERS, LAYERS, SAMPLER, Slots, UNFILTERED, UNIFORM, VOLUME};
use super::device::Gpu;
use brdfc_formats::combined_wgsl;
use brdfc_formats::{BrdfShader, PackKind};
use brdfc_shaders::{BindingKind, Generated};
use std::collections::BTreeMap;
use wgpu::{BindingType, ShaderStages};

/// The codecs of BRDFs.
fn codecs() -> impl Iterator<Item = (PackKind, BrdfShader)> {
    PackKind::ALL.into_iter().filter_map(|kind| Some((kind, kind.descriptor().brdf?)))
}

/// The decoders of all codecs, and functions that call the decoder of the bound pack:
///
/// - `brdf(wi, wo, level, hardware)`: `f_r` at a level of detail; `hardware`: the sampler filters;
/// - `brdf_level_of_detail(distance)`: the level of detail at a distance from the viewer.
pub(super) fn brdf_source() -> String {
    let wgsl: Vec<String> = codecs().map(|(kind, _)| (kind.descriptor().wgsl)()).collect();
    let chosen = |of: &dyn Fn(BrdfShader) -> String| {
        let mut text = String::new();
        let mut all = codecs().peekable();
        while let Some((_, shader)) = all.next() {
            // The last codec needs no condition, since one pack is bound.
            text += &match all.peek() {
                Some(_) => format!("if {} {{\n{}}}\n", shader.is_bound, of(shader)),
                None => of(shader),
            };
        }
        text
    };
    let value = |shader: BrdfShader| format!("{}\n", shader.either);
    let level = |shader: BrdfShader| format!("return {};\n", shader.level_of_detail);
    combined_wgsl(wgsl.iter().map(String::as_str))
        + &format!(
            "\nfn brdf(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {{\n{}}}\n\
             fn brdf_level_of_detail(distance: f32) -> f32 {{\n{}}}\n",
            chosen(&value),
            chosen(&level)
        )
}

/// Slots of group 1 that the decoders of all codecs use.
pub(super) fn slot_types() -> BTreeMap<u32, BindingType> {
    let bindings = codecs().flat_map(|(kind, _)| &Generated::of(kind).interface.bindings);
    bindings.map(|binding| (binding.binding, type_of(&binding.kind))).collect()
}

fn type_of(kind: &BindingKind) -> BindingType {
    match kind {
        BindingKind::Uniform { .. } => UNIFORM,
        BindingKind::Sampler => SAMPLER,
        BindingKind::Texture { dimension, samples, filtered } => match (dimension.as_str(), samples.as_str(), filtered)
        {
            ("2d", "uint", _) => INTEGERS,
            ("2d", "float", false) => UNFILTERED,
            ("2d", "float", true) => IMAGE,
            ("2d-array", "float", true) => LAYERS,
            ("3d", "float", true) => VOLUME,
            other => unreachable!("no decoder of a BRDF has a texture of {other:?}"),
        },
    }
}

/// Layout of group 1.
pub fn slots(gpu: &Gpu, stages: ShaderStages) -> Slots {
    Slots::new(gpu, "pack", stages, slot_types())
}
