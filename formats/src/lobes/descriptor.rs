//! Static description of the codec.

use super::pack::{DECODER, LOBES_WGSL};
use crate::descriptor::{Answer, Descriptor, StructAnswer};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "lobes of a BRDF",
    plural: "lobes of BRDFs",
    specification: "formats/src/lobes/spec.md",
    wgsl: || LOBES_WGSL.to_owned(),
    functions: &["lobes_lookup", "lobes_count"],
    answer: Answer {
        takes: "a: wo and the number of the lobe; b.x: 0 for the direction and the sharpness, 1 for the weight",
        gives: "direction and sharpness, or weight",
        body: "lobes_lookup(a.xyz, u32(a.w))",
        of_struct: Some(StructAnswer {
            name: "LobeLookup",
            numbers: "select(vec4f($answer.direction, $answer.sharpness), vec4f($answer.weight, 0.0), b.x == 1.0)",
        }),
    },
    brdf: None,
};
