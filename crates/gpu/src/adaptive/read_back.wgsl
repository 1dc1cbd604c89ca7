// Writes points in the CPU's layout: five vectors each.

@compute @workgroup_size(64)
fn read_back(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let place = place_of(job.first + at);
    let position = textureLoad(positions, place, 0);
    let normal = textureLoad(normals, place, 0);
    let tangent = textureLoad(tangents, place, 0);
    let viewer = viewer_of(position.xyz);
    computed[5u * at] = position;
    computed[5u * at + 1u] = normal;
    computed[5u * at + 2u] = tangent;
    computed[5u * at + 3u] = viewer;
    computed[5u * at + 4u] = vec4<f32>(across_of(normal.xyz), 0.0, 0.0);
}
