// Textures of a material besides its pack, and the light. Group 2; the pack is group 1.

@group(2) @binding(0) var environment: texture_2d<f32>;
// The environment at the resolution of its bandwidth map, and below it means of 2 x 2 texels and more, level by level:
// radiance, bandwidth, squares of radiance, bandwidth times squares. These are not mip levels, since a software driver
// returned texels of the wrong level where each invocation chose its own.
@group(2) @binding(1) var light: texture_2d<f32>;
// Colours of the material's texture and, below, their mipmap levels.
@group(2) @binding(2) var texture_colours: texture_2d<f32>;
