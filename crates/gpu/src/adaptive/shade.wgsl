// Equation 2: reflected radiance by importance samples, in slices of a node's samples that are summed in order.
// Appended to the decoders of packs, `brdf.wgsl`, `formats/src/importance/pack.wgsl` and `environment.wgsl`; the CPU
// twin is `crates/render/src/adaptive/shading.rs`.

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at < job.count {
        let slice = slices[job.first + at];
        sums[job.first + at] = vec4<f32>(shade_point(slice.x, slice.y, slice.z), 0.0);
    }
}

fn shade_point(point: u32, first: u32, count: u32) -> vec3<f32> {
    let frame = frame_of(point);
    let viewer = viewer_of(position_of(point));
    let outgoing = into_frame(frame, viewer.xyz);
    var level = job.material.level;
    if level < 0.0 {
        level = brdf_level_of_detail(viewer.w);
    }
    let start = scattered(point) + first;
    var sum = vec3<f32>(0.0);
    for (var index = 0u; index < count; index += 1u) {
        let drawn = importance_sample(outgoing, start + index);
        if drawn.inverse_density <= 0.0 {
            continue;
        }
        let f_r = brdf(drawn.incoming, outgoing, level, job.material.hardware == 1u);
        let light = environment_at(into_world(frame, drawn.incoming));
        sum += (drawn.incoming.z * drawn.inverse_density) * (f_r * light);
    }
    return texture_point(point).colour * sum;
}

// A permutation of 32 bits (the finaliser of MurmurHash3 by Appleby).
fn scattered(value: u32) -> u32 {
    var h = value;
    h ^= h >> 16u;
    h *= 0x85ebca6bu;
    h ^= h >> 13u;
    h *= 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let node = gathers[job.first + at];
    var sum = vec3<f32>(0.0);
    for (var slice = node.y; slice < node.y + node.z; slice += 1u) {
        sum += sums[slice].xyz;
    }
    computed[node.x] = vec4<f32>(sum / f32(max(node.w, 1u)), 1.0);
}
