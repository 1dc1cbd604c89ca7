// What changes with the frame rather than with the pack: one block for the decoders of all packs.
struct BrdfcFrame {
    distance_scale: f32,   // α of levels of detail, per unit of distance; positive
    sampler_filters: u32,  // 1: samplers filter, 0: the shader, with exact weights
    blend: u32,            // of wavelet packs: 0 nearest, 1 slices, 2 bilinear
    reserved: u32,
}

// 16 bytes, which the engine fills.
@group(1) @binding(0) var<uniform> brdfc_frame: BrdfcFrame;

