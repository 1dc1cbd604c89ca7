// A part and its material, besides its maps. Environment and material of a part are group 3, its pack is group 2.

struct Material {
    part: u32,       // index
    albedo: f32,
    level: f32,      // of detail of the wavelet pack; negative: follows the distance
    hardware: u32,   // 1: the sampler filters slices of the wavelet pack
}

@group(3) @binding(6) var<uniform> material: Material;
@group(3) @binding(7) var environment: texture_2d<f32>;
// The environment over the texels of its bandwidth map, and below it means of 2 x 2 and more, level by level: radiance,
// bandwidth, squares of radiance, bandwidth times squares. Not as mip levels: of those, with a level
// for each invocation, a software driver gave texels of other levels.
@group(3) @binding(8) var light: texture_2d<f32>;
