// Flat BTFs: sampled shadows, for reliefs of indirection maps.
//
// After section 3.3 of Hadim, Pacanowski, Granier and Schlick 2009, "Flat bidirectional texture functions". The CPU version
// is `ShadowMap` of the crate `brdfc-formats`.
//
// Usage: append this file and `factored/factored.wgsl` to `decoder.wgsl`. With the sampler a shadow takes at most 3 fetches.

// Share of each sampled light that reaches the texels of the flat BTF, a layer per light. With mipmaps.
@group(1) @binding(21) var flat_btf_shadows: texture_2d_array<f32>;

// Share of a sampled light, 0 to 1, that reaches parameters of the flat BTF, between 0 and 1. level and blend are its mipmap
// levels.
fn flat_btf_shadow(at: vec2<f32>, level: u32, blend: f32, light: u32) -> f32 {
    if brdfc_frame.sampler_filters == 1u {
        let detail = f32(level) + blend;
        return textureSampleLevel(flat_btf_shadows, flat_btf_sampler, at, light, detail).x;
    }
    let fine = flat_btf_shadow_of_level(at, level, light);
    if blend > 0.0 {
        return fine + blend * (flat_btf_shadow_of_level(at, level + 1u, light) - fine);
    }
    return fine;
}

fn flat_btf_shadow_of_level(at: vec2<f32>, level: u32, light: u32) -> f32 {
    let side = factored_side(level);
    let column = flat_btf_periodic_tap(at.x, side);
    let row = flat_btf_periodic_tap(at.y, side);
    var share = 0.0;
    for (var k = 0u; k < 4u; k += 1u) {
        let texel = vec2<u32>(flat_btf_tap_sample(column, k & 1u), flat_btf_tap_sample(row, k >> 1u));
        let weight = flat_btf_tap_weight(row, k >> 1u) * flat_btf_tap_weight(column, k & 1u);
        share = share + weight * textureLoad(flat_btf_shadows, texel, light, level).x;
    }
    return share;
}
