// Means over the points of each pixel, and the share of points on a surface. The CPU twin is `resolve` of
// `crates/render/src/adaptive/resolve.rs`.

@compute @workgroup_size(64)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let pixel = job.first + at;
    let corner = rendering.sub * vec2<u32>(pixel % rendering.pixels.x, pixel / rendering.pixels.x);
    let all = rendering.sub * rendering.sub;
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < all; k += 1u) {
        let point = (corner.y + k / rendering.sub) * rendering.points.x + corner.x + k % rendering.sub;
        if part_of(point) != NONE {
            sum += vec4<f32>(computed[point].xyz, 1.0);
        }
    }
    image[pixel] = sum / f32(all);
}
