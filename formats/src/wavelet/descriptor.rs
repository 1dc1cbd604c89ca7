//! Static description of the codec.

use super::layout::DECODER;
use super::shader::WAVELET_BRDF_WGSL;
use crate::descriptor::{Answer, BrdfShader, Descriptor};

pub(crate) const DESCRIPTOR: Descriptor = Descriptor {
    name: DECODER.0,
    version: DECODER.1,
    summary: "a wavelet pack",
    plural: "wavelet packs",
    specification: "formats/src/wavelet/spec.md",
    wgsl: || WAVELET_BRDF_WGSL.to_owned(),
    functions: &["wavelet_brdf", "wavelet_brdf_exact", "wavelet_brdf_level_of_detail"],
    answer: Answer {
        takes: "a: wi and the level of detail; b: wo and 1 if the sampler filters, otherwise 0",
        gives: "f_r",
        body: "vec4f(select(wavelet_brdf_exact(a.xyz, b.xyz, a.w), wavelet_brdf(a.xyz, b.xyz, a.w), \
               b.w == 1.0), 0.0)",
        of_struct: None,
    },
    brdf: Some(BrdfShader {
        is_bound: "wavelet_brdf_parameters.levels > 0u",
        either: "if hardware {\n        return wavelet_brdf(wi, wo, level);\n    }\n    return wavelet_brdf_exact(wi, wo, level);",
        filtered: "wavelet_brdf(wi, wo, level)",
        exact: "wavelet_brdf_exact(wi, wo, level)",
        may_be_wide: true,
        level_of_detail: "wavelet_brdf_level_of_detail(distance)",
    }),
};
