//! Static description of the codec.

use super::shader::{DECODER, TABLE_BRDF_WGSL};
use crate::descriptor::{Answer, BrdfShader, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a table pack",
    plural: "table packs",
    specification: "formats/src/table/spec.md",
    wgsl: || TABLE_BRDF_WGSL.to_owned(),
    functions: &["table_brdf", "table_brdf_exact", "table_brdf_at", "table_brdf_level_of_detail"],
    answer: Answer {
        takes: "a: wi and the level of detail; b: wo and 1 if the sampler filters, otherwise 0",
        gives: "f_r",
        body: "vec4f(table_brdf_at(a.xyz, b.xyz, a.w, b.w == 1.0), 0.0)",
        of_struct: None,
    },
    brdf: Some(BrdfShader {
        is_bound: "table_brdf_parameters.layers > 0u",
        either: "return table_brdf_at(wi, wo, level, hardware);",
        filtered: "table_brdf_at(wi, wo, level, true)",
        exact: "table_brdf_at(wi, wo, level, false)",
        may_be_wide: false,
        level_of_detail: "table_brdf_level_of_detail(distance)",
    }),
};
