// Input and output of `compute(at)` as numbers. Goes between the shader that defines it and `items.wgsl`.

@group(0) @binding(1) var<storage, read> input: array<f32>;
@group(0) @binding(2) var<storage, read_write> output: array<f32>;

