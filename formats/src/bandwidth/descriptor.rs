//! Static description of the codec.

use super::shader::{BANDWIDTH_WGSL, DECODER};
use crate::descriptor::{Answer, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a bandwidth map",
    plural: "bandwidth maps",
    specification: "formats/src/bandwidth/spec.md",
    wgsl: || BANDWIDTH_WGSL.to_owned(),
    functions: &["bandwidth_brdf", "bandwidth_environment", "bandwidth_texture"],
    answer: Answer {
        takes: "a: wi; b: wo; c: uv",
        gives: "bandwidths of the lobe, of the environment at wi, of the texture at uv",
        body: "vec4f(bandwidth_brdf(a.xyz, b.xyz), bandwidth_environment(a.xyz), \
               bandwidth_texture(c.xy), 0.0)",
        of_struct: None,
    },
    brdf: None,
};
