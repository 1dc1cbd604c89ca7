//! Static description of the codec.

use super::IMPORTANCE_WGSL;
use super::pack::DECODER;
use crate::descriptor::{Answer, Descriptor, StructAnswer};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "an importance-sample pack",
    plural: "importance samples",
    specification: "formats/src/importance/spec.md",
    wgsl: || IMPORTANCE_WGSL.to_owned(),
    functions: &["importance_sample"],
    answer: Answer {
        takes: "a: wo and the index of the sample",
        gives: "wi and 1 / density",
        body: "importance_sample(a.xyz, u32(a.w))",
        of_struct: Some(StructAnswer {
            name: "ImportanceSample",
            numbers: "vec4f($answer.incoming, $answer.inverse_density)",
        }),
    },
    brdf: None,
};
