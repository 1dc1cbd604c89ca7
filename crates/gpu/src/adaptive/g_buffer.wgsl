// Rasterises surface points: positions and orientations. Appended to `view.wgsl`, `periodic.wgsl` and `surface.wgsl`;
// the CPU twin is `crates/render/src/gbuffer.rs`.
//
// A point takes 48 bytes in three textures. `points.wgsl` recomputes what follows from them and the camera. There are
// two passes, since not every adapter writes three colours at once.

struct Placed {
    @location(0) position: vec4<f32>,  // and 1 + index of the part, 0: background
    @location(1) normal: vec4<f32>,    // and the first texture coordinate
}

@fragment
fn place(in: Varying, @builtin(front_facing) front: bool) -> Placed {
    let frame = seen_frame(in, front);
    return Placed(vec4<f32>(in.position, f32(surface.part + 1u)), vec4<f32>(frame[2], in.uv.x));
}

// The tangent and the second texture coordinate. On back faces the tangent runs along the bitangent, too.
@fragment
fn turn(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let frame = seen_frame(in, front);
    return vec4<f32>(frame[0], select(-in.uv.y, in.uv.y, front));
}

fn seen_frame(in: Varying, front: bool) -> mat3x3<f32> {
    let to_eye = view.eye.xyz - in.position;
    return shading_frame(in, front, to_eye / length(to_eye));
}
