// Curvature from neighbouring points. The CPU twin is `crates/render/src/curvature.rs`.

// Value for points that have no neighbour on the same surface.
const UNKNOWN: f32 = 1e9;
const MAX_RISE_SQUARED: f32 = 0.0625;

@compute @workgroup_size(64)
fn curvatures(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at < job.count {
        predicted[job.first + at].z = curvature_at(job.first + at);
    }
}

fn curvature_at(point: u32) -> f32 {
    let part = part_of(point);
    if part == NONE {
        return 0.0;
    }
    let place = place_of(point);
    let last = min(place + vec2<u32>(1u), rendering.points - vec2<u32>(1u));
    let first = max(place, vec2<u32>(1u)) - vec2<u32>(1u);
    // Negative until a neighbour is found.
    var largest = -1.0;
    for (var row = first.y; row <= last.y; row += 1u) {
        for (var column = first.x; column <= last.x; column += 1u) {
            let neighbour = row * rendering.points.x + column;
            if neighbour != point && part_of(neighbour) == part {
                largest = max(largest, turn_squared(point, neighbour));
            }
        }
    }
    if largest < 0.0 {
        return UNKNOWN;
    }
    return sqrt(largest);
}

// |Δn|² / |Δp|² of a step to a neighbour; -1 if the step leaves the surface.
fn turn_squared(here: u32, there: u32) -> f32 {
    let length_squared = step_squared(here, there);
    if length_squared < 0.0 {
        return -1.0;
    }
    let turned = normal_of(there) - normal_of(here);
    return product(turned, turned) / length_squared;
}

// |Δp|² of a step to a neighbour, above 0; -1 if the step leaves the surface.
fn step_squared(here: u32, there: u32) -> f32 {
    let step = position_of(there) - position_of(here);
    let length_squared = product(step, step);
    let rise = product(step, normal_of(here) + normal_of(there));
    if length_squared <= 0.0 || rise * rise > MAX_RISE_SQUARED * length_squared {
        return -1.0;
    }
    return length_squared;
}
