// Look-up in an environment, a texture `environment` that the shader declares. Appended to
// `formats/src/wavelet/decode.wgsl` and `periodic.wgsl`; the CPU twin is `crates/render/src/environment.rs`.

// Latitude-longitude image: row 0 is up, columns follow the azimuth and wrap.
fn environment_at(direction: vec3<f32>) -> vec3<f32> {
    let size = textureDimensions(environment);
    let half_turn = wavelet_brdf_atan2(abs(direction.z), direction.x);
    let azimuth = select(half_turn, 2.0 * WAVELET_BRDF_PI - half_turn, direction.z < 0.0);
    let colatitude = wavelet_brdf_atan2(sqrt(direction.x * direction.x + direction.z * direction.z), direction.y);
    let x = azimuth / (2.0 * WAVELET_BRDF_PI) * f32(size.x) - 0.5;
    let y = clamp(colatitude / WAVELET_BRDF_PI * f32(size.y) - 0.5, 0.0, f32(size.y - 1u));
    let column = floor(x);
    let row = floor(y);
    let a = wrapped(i32(column), i32(size.x));
    let b = wrapped(i32(column) + 1, i32(size.x));
    let c = i32(row);
    let d = min(c + 1, i32(size.y) - 1);
    let top = mix(environment_texel(a, c), environment_texel(b, c), x - column);
    let bottom = mix(environment_texel(a, d), environment_texel(b, d), x - column);
    return mix(top, bottom, y - row);
}

fn environment_texel(column: i32, row: i32) -> vec3<f32> {
    return textureLoad(environment, vec2<i32>(column, row), 0).rgb;
}
