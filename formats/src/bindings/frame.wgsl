// Per-frame values, in one block shared by the decoders of all packs.
struct BrdfcFrame {
    distance_scale: f32,   // α of the level of detail, per unit of distance; positive
    sampler_filters: u32,  // 1: samplers filter; 0: the shader filters with exact weights
    blend: u32,            // for wavelet packs: 0 nearest, 1 slices, 2 bilinear
    reserved: u32,
}

// 16 bytes, filled by the engine.
@group(1) @binding(0) var<uniform> brdfc_frame: BrdfcFrame;

