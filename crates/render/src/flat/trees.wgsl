// Calls of the scenes of flat BTFs for trees. Appended to the decoder that ends with
// `formats/src/flat_btf_trees/trees.wgsl`; `factors.wgsl` has the same calls for a base and components.

alias ReliefLook = FlatBtfSight;

fn relief_level(right: vec2<f32>, below: vec2<f32>) -> f32 {
    return flat_trees_mipmap_level(right, below);
}

fn relief_look(uv: vec2<f32>, level: f32, wo: vec3<f32>, surface: FlatBtfSurface) -> ReliefLook {
    return flat_btf_sight(uv, level, wo, surface);
}

fn relief_sight(look: ReliefLook) -> FlatBtfSight {
    return look;
}

fn relief_shade(look: ReliefLook, wi: vec3<f32>) -> vec3<f32> {
    return flat_trees_shade(look, wi);
}
