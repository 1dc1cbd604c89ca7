// Calls of the scenes of flat BTFs for a base and components. Appended to the decoder that ends with
// `formats/src/flat_btf/value.wgsl`; `trees.wgsl` has the same calls for trees.

alias ReliefLook = FlatBtfLook;

fn relief_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    return factored_mipmap_level(right, below);
}

fn relief_look(uv: vec2<f32>, level: f32, wo: vec3<f32>, surface: FlatBtfSurface) -> ReliefLook {
    return flat_btf_look(uv, level, wo, surface);
}

fn relief_sight(look: ReliefLook) -> FlatBtfSight {
    return look.sight;
}

fn relief_shade(look: ReliefLook, wi: vec3<f32>) -> vec3<f32> {
    return flat_btf_shade(look, wi);
}
