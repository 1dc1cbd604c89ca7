// Prefiltered environments: radiance from all directions, at several sharpnesses.
//
// Layout: `formats/src/environment/spec.md`. The CPU decoder `EnvironmentDecoder::radiance` of the crate `brdfc-formats`
// computes the same.
//
// Usage: prepend this file to your own shader, move the four bindings as needed, and call
//
//     let light = environment_radiance(direction, sharpness);
//
// direction is a vector of any length but 0 in the frame of the environment (y up). A sharpness of 0 gives the
// irradiance over pi, for matte surfaces; 1 a Gaussian kernel with a standard deviation of 15.75 degrees, and each
// further step half of it, up to the unfiltered environment. It takes one filtered fetch, and between 0 and 1 two.

// 16 bytes: `EnvironmentHeader::uniform` of `brdfc-formats`.
struct EnvironmentParameters {
    sharpest: f32,  // sharpness of the finest mipmap level
    scale: f32,     // factor of texel values
    reserved_0: u32,
    reserved_1: u32,
}

@group(1) @binding(37) var<uniform> environment_parameters: EnvironmentParameters;
// Cube map of the KTX2 file, with mipmaps.
@group(1) @binding(38) var environment_map: texture_cube<f32>;
// Irradiance over pi, without mipmaps.
@group(1) @binding(39) var environment_irradiance: texture_cube<f32>;
@group(1) @binding(40) var environment_sampler: sampler;

// Filtered radiance, W/(m^2 sr).
fn environment_radiance(direction: vec3<f32>, sharpness: f32) -> vec3<f32> {
    let sharpest = environment_parameters.sharpest;
    var radiance = vec3<f32>(0.0);
    if sharpness > 0.0 {
        let level = clamp(sharpest - sharpness, 0.0, sharpest - 1.0);
        radiance = textureSampleLevel(environment_map, environment_sampler, direction, level).rgb;
    }
    if sharpness < 1.0 {
        let irradiance = textureSampleLevel(environment_irradiance, environment_sampler, direction, 0.0).rgb;
        radiance = irradiance + max(sharpness, 0.0) * (radiance - irradiance);
    }
    return radiance * environment_parameters.scale;
}
