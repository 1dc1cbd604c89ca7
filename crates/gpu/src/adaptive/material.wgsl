// What is looked up of a material besides its pack, and of the light. Group 2; its pack is group 1.

@group(2) @binding(0) var environment: texture_2d<f32>;
// The environment over the texels of its bandwidth map, and below it means of 2 x 2 and more, level by level: radiance,
// bandwidth, squares of radiance, bandwidth times squares. Not as mip levels: of those, with a level
// for each invocation, a software driver gave texels of other levels.
@group(2) @binding(1) var light: texture_2d<f32>;
