// Outcomes of the nodes of a level. Appended to `upsample.wgsl`; the CPU twin is
// `crates/render/src/adaptive/passes.rs`.

const LEFT_OUT: u32 = 0u;
const TAKEN: u32 = 1u;
const SHADED: u32 = 2u;

@compute @workgroup_size(64)
fn decide(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let index = job.first + at;
    let node = nodes[rendering.levels[job.level].z + index];
    let point = stands_for(job.level, index);
    computed[rendering.levels[job.level].z + index] = vec4<f32>(0.0);
    outcomes[index] = vec4<u32>(LEFT_OUT, 0u, point, NONE);
    if point == NONE || node.finest < i32(job.level) {
        return;
    }
    if node.finest > i32(job.level) && job.level < rendering.coarsest {
        let value = upsampled(point, index, job.level);
        if value.w > 0.0 {
            computed[rendering.levels[job.level].z + index] = value;
            outcomes[index].x = TAKEN;
            return;
        }
    }
    outcomes[index] = vec4<u32>(SHADED, raised(node.samples, job.level), point, part_of(point));
}

// `samples` times 2^level / 2 above level 0, up to the maximum. The error of a coarse pixel shows in 4^level points, of
// which means over the surrounding pixels leave a quarter.
fn raised(samples: u32, level: u32) -> u32 {
    let doublings = max(level, 1u) - 1u;
    if samples > (NONE >> doublings) {
        return settings.most;
    }
    return min(samples << doublings, settings.most);
}
