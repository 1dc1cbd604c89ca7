// Three samples of a direction set and their weights, for any direction.
//
// The words in the buffer are described in `direction_mesh/mod.rs` of the crate `brdfc-formats`, whose
// `DirectionMesh::weights` does the same steps in the same order. `direction_mesh_wgsl` there puts names for the two
// placeholders: the function, and the storage buffer that the shader declares for the words:
//
//     @group(0) @binding(3) var<storage, read> DIRECTION_MESH_BINDING: array<u32>;

struct DIRECTION_MESH_FUNCTION_result {
    indices: vec3<u32>,  // into the set; may repeat with weight 0
    weights: vec3<f32>,  // not negative, sum 1
}

// `direction` is a unit vector in the frame x = tangent, y = bitangent, z = normal.
fn DIRECTION_MESH_FUNCTION(direction: vec3<f32>) -> DIRECTION_MESH_FUNCTION_result {
    let scale = 1.0 + max(direction.z, 0.0);
    let p = vec2<f32>(
        min(max(direction.x / scale, -1.0), 1.0),
        min(max(direction.y / scale, -1.0), 1.0),
    );
    let grid = DIRECTION_MESH_BINDING[0];
    let size = f32(grid);
    let column = u32(min((p.x + 1.0) * 0.5 * size, size - 1.0));
    let row = u32(min((p.y + 1.0) * 0.5 * size, size - 1.0));
    let candidates = 5u + grid * grid;
    let triangles = candidates + DIRECTION_MESH_BINDING[3];
    let vertices = triangles + 3u * DIRECTION_MESH_BINDING[2];
    let first = DIRECTION_MESH_BINDING[4u + row * grid + column];
    let end = DIRECTION_MESH_BINDING[5u + row * grid + column];

    var best = 3.4028234e38;
    var result = DIRECTION_MESH_FUNCTION_result(vec3<u32>(0u), vec3<f32>(1.0, 0.0, 0.0));
    for (var k = first; k < end; k += 1u) {
        let triangle = triangles + 3u * DIRECTION_MESH_BINDING[candidates + k];
        let corners = vec3<u32>(
            DIRECTION_MESH_BINDING[triangle],
            DIRECTION_MESH_BINDING[triangle + 1u],
            DIRECTION_MESH_BINDING[triangle + 2u],
        );
        let a = DIRECTION_MESH_FUNCTION_vertex(vertices + 2u * corners.x);
        let b = DIRECTION_MESH_FUNCTION_vertex(vertices + 2u * corners.y);
        let c = DIRECTION_MESH_FUNCTION_vertex(vertices + 2u * corners.z);
        let q = p - a;
        let e1 = b - a;
        var w = vec3<f32>(1.0, 0.0, 0.0);
        var distance: f32;
        if corners.y == corners.z {
            // A segment, which counts on its right side: the hull is on the left.
            let squared = e1.x * e1.x + e1.y * e1.y;
            var t = 0.0;
            if squared > 0.0 {
                t = (q.x * e1.x + q.y * e1.y) / squared;
            }
            if t >= 0.0 && t <= 1.0 {
                if e1.x * q.y - e1.y * q.x <= 0.0 {
                    return DIRECTION_MESH_FUNCTION_result(corners, vec3<f32>(1.0 - t, t, 0.0));
                }
                continue;
            }
            distance = q.x * q.x + q.y * q.y;
            if t > 1.0 {
                w = vec3<f32>(0.0, 1.0, 0.0);
                let r = p - b;
                distance = r.x * r.x + r.y * r.y;
            }
        } else {
            let e2 = c - a;
            let area = e1.x * e2.y - e1.y * e2.x;
            let w1 = (q.x * e2.y - q.y * e2.x) / area;
            let w2 = (e1.x * q.y - e1.y * q.x) / area;
            let w0 = 1.0 - w1 - w2;
            if w0 >= 0.0 && w1 >= 0.0 && w2 >= 0.0 {
                return DIRECTION_MESH_FUNCTION_result(corners, vec3<f32>(w0, w1, w2));
            }
            // Rounding may leave a point between two triangles.
            let c0 = max(w0, 0.0);
            let c1 = max(w1, 0.0);
            let c2 = max(w2, 0.0);
            let sum = c0 + c1 + c2;
            w = vec3<f32>(c0 / sum, c1 / sum, c2 / sum);
            let x = q.x - (w.y * e1.x + w.z * e2.x);
            let y = q.y - (w.y * e1.y + w.z * e2.y);
            // Outside the hull the corner of a segment is to win.
            distance = 4.0 * (x * x + y * y);
        }
        if k == first || distance < best {
            best = distance;
            result.indices = corners;
            result.weights = w;
        }
    }
    return result;
}

fn DIRECTION_MESH_FUNCTION_vertex(word: u32) -> vec2<f32> {
    return vec2<f32>(
        bitcast<f32>(DIRECTION_MESH_BINDING[word]),
        bitcast<f32>(DIRECTION_MESH_BINDING[word + 1u]),
    );
}
