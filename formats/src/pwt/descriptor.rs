//! Static description of the codec.

use super::shader::{DECODER, PWT_WGSL};
use crate::descriptor::{Answer, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a polynomial wavelet tree",
    plural: "polynomial wavelet trees",
    specification: "formats/src/pwt/spec.md",
    wgsl: || PWT_WGSL.to_owned(),
    functions: &["pwt_value", "pwt_mipmap_level"],
    answer: Answer {
        takes: "a: uv and the level of detail; b: wi; c: wo",
        gives: "linear RGB",
        body: "vec4f(pwt_value(a.xy, a.z, c.xyz, b.xyz), 0.0)",
        of_struct: None,
    },
    brdf: None,
};
