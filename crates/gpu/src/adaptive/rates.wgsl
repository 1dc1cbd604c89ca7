// Converts bandwidths and deviations to levels and samples: the finest nodes. The CPU twin is
// `crates/render/src/adaptive/predict.rs`.

// Points that one invocation adds up.
const STRETCH: u32 = 256u;

// Sums the deviations of a stretch of points in order, as two numbers that together have twice the digits, and counts
// the points on a surface.
@compute @workgroup_size(64)
fn deviations(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let points = rendering.points.x * rendering.points.y;
    let last = min((job.first + at + 1u) * STRETCH, points);
    var high = 0.0;
    var low = 0.0;
    var covered = 0u;
    for (var point = (job.first + at) * STRETCH; point < last; point += 1u) {
        if part_of(point) == NONE {
            continue;
        }
        // The rounding error of a sum is itself a float (Knuth, The Art of Computer Programming 2, 4.2.2).
        let added = predicted[point].y;
        let sum = high + added;
        let share = sum - high;
        low += (high - (sum - share)) + (added - share);
        high = sum;
        covered += 1u;
    }
    sums[job.first + at] = vec4<f32>(high, low, f32(covered), 0.0);
}

@compute @workgroup_size(64)
fn rates(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let point = job.first + at;
    if part_of(point) == NONE {
        nodes[point] = Node(ANY_LEVEL, 0u, NONE);
        return;
    }
    // Level 0 is the buffer's resolution, which with antialiasing is finer than the rendering's.
    let coarsest = i32(rendering.coarsest);
    // Points with detail beyond the pixel's limit still have the most, so the limit applies after the factor.
    let level = bandwidth_pyramid_level(rendering_bandwidth(settings.caution * predicted[point].w), coarsest);
    let finest = clamp(level + i32(settings.antialiasing_levels), 0, coarsest);
    let samples = bandwidth_sample_count(predicted[point].y, settings.scale, settings.fewest, settings.most);
    nodes[point] = Node(finest, samples, point);
}

// Every point at the finest level, with `fewest` samples: a forward renderer.
@compute @workgroup_size(64)
fn even(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let point = job.first + at;
    if part_of(point) == NONE {
        nodes[point] = Node(ANY_LEVEL, 0u, NONE);
    } else {
        nodes[point] = Node(0, settings.fewest, point);
    }
}
