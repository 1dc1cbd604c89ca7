//! Static description of the codec.

use super::shader::flat_trees_wgsl;
use super::trees::DECODER;
use crate::descriptor::{Answer, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a flat BTF of trees",
    plural: "flat BTFs of trees",
    specification: "formats/src/flat_btf_trees/spec.md",
    wgsl: flat_trees_wgsl,
    functions: &[
        "flat_trees_value",
        "flat_trees_shade",
        "flat_btf_sight",
        "flat_btf_sight_passes",
        "flat_btf_sight_offset",
        "flat_btf_tile_side",
        "flat_btf_curvature",
        "flat_btf_stretch",
        "flat_trees_mipmap_level",
    ],
    answer: Answer {
        takes: "a: uv and the level of detail; b: view; c: light",
        gives: "radiance divided by that of a white diffuser",
        body: "vec4f(flat_trees_value(a.xy, a.z, b.xyz, c.xyz), 0.0)",
        of_struct: None,
    },
    brdf: None,
};
