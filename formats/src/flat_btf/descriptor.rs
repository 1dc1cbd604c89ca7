//! Static description of the codec.

use super::shader::{DECODER, flat_btf_value_wgsl};
use crate::descriptor::{Answer, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a flat BTF",
    plural: "flat BTFs",
    specification: "formats/src/flat_btf/spec.md",
    wgsl: flat_btf_value_wgsl,
    functions: &[
        "flat_btf_value",
        "flat_btf_look",
        "flat_btf_passes",
        "flat_btf_offset",
        "flat_btf_shade",
        "flat_btf_tile_side",
        "flat_btf_curvature",
        "flat_btf_stretch",
        "factored_mipmap_level",
    ],
    answer: Answer {
        takes: "a: uv and the level of detail; b: view; c: light",
        gives: "radiance divided by that of a white diffuser",
        body: "vec4f(flat_btf_value(a.xy, a.z, b.xyz, c.xyz), 0.0)",
        of_struct: None,
    },
    brdf: None,
};
