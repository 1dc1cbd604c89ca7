//! Static description of the codec.

use super::pack::{DECODER, ENVIRONMENT_WGSL};
use crate::descriptor::{Answer, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a prefiltered environment",
    plural: "prefiltered environments",
    specification: "formats/src/environment/spec.md",
    wgsl: || ENVIRONMENT_WGSL.to_owned(),
    functions: &["environment_radiance"],
    answer: Answer {
        takes: "a: a direction and the sharpness",
        gives: "filtered radiance",
        body: "vec4f(environment_radiance(a.xyz, a.w), 0.0)",
        of_struct: None,
    },
    brdf: None,
};
