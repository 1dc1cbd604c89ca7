// Interpolation between sampled directions: three samples and their weights for any direction.
//
// The words are specified in `direction_mesh/mod.rs` of the crate `brdfc-formats`, whose `DirectionMesh::weights`
// performs the same steps in the same order. They are stored in a texture, row by row, which may hold several meshes,
// each starting in a row of its own.
//
// Usage: prepend this file to your own shader, move the binding as needed, and call
//
//     let samples = direction_mesh_weights(direction, row);
//
// It loads 5 texels, and up to 10 for each triangle and segment of the direction's cell.

// One channel of 32 bits, unsigned integers. Not filtered.
@group(1) @binding(28) var direction_mesh_words: texture_2d<u32>;

struct DirectionMeshWeights {
    indices: vec3<u32>,  // indices into the set; may repeat with weight 0
    weights: vec3<f32>,  // non-negative, sum 1
}

// `direction` is a unit vector in the frame x = tangent, y = bitangent, z = normal; `row` is the first row of the mesh.
fn direction_mesh_weights(direction: vec3<f32>, row: u32) -> DirectionMeshWeights {
    let scale = 1.0 + max(direction.z, 0.0);
    let p = vec2<f32>(
        min(max(direction.x / scale, -1.0), 1.0),
        min(max(direction.y / scale, -1.0), 1.0),
    );
    let grid = direction_mesh_word(row, 0u);
    let size = f32(grid);
    let column = u32(min((p.x + 1.0) * 0.5 * size, size - 1.0));
    let line = u32(min((p.y + 1.0) * 0.5 * size, size - 1.0));
    let candidates = 5u + grid * grid;
    let triangles = candidates + direction_mesh_word(row, 3u);
    let vertices = triangles + 3u * direction_mesh_word(row, 2u);
    let first = direction_mesh_word(row, 4u + line * grid + column);
    let end = direction_mesh_word(row, 5u + line * grid + column);

    var best = 3.4028234e38;
    var result = DirectionMeshWeights(vec3<u32>(0u), vec3<f32>(1.0, 0.0, 0.0));
    for (var k = first; k < end; k += 1u) {
        let triangle = triangles + 3u * direction_mesh_word(row, candidates + k);
        let corners = vec3<u32>(
            direction_mesh_word(row, triangle),
            direction_mesh_word(row, triangle + 1u),
            direction_mesh_word(row, triangle + 2u),
        );
        let a = direction_mesh_vertex(row, vertices + 2u * corners.x);
        let b = direction_mesh_vertex(row, vertices + 2u * corners.y);
        let c = direction_mesh_vertex(row, vertices + 2u * corners.z);
        let q = p - a;
        let e1 = b - a;
        var w = vec3<f32>(1.0, 0.0, 0.0);
        var distance: f32;
        if corners.y == corners.z {
            // A segment applies on its right side, because the hull is on the left.
            let squared = e1.x * e1.x + e1.y * e1.y;
            var t = 0.0;
            if squared > 0.0 {
                t = (q.x * e1.x + q.y * e1.y) / squared;
            }
            if t >= 0.0 && t <= 1.0 {
                if e1.x * q.y - e1.y * q.x <= 0.0 {
                    return DirectionMeshWeights(corners, vec3<f32>(1.0 - t, t, 0.0));
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
                return DirectionMeshWeights(corners, vec3<f32>(w0, w1, w2));
            }
            // Rounding may leave a point between two triangles.
            let c0 = max(w0, 0.0);
            let c1 = max(w1, 0.0);
            let c2 = max(w2, 0.0);
            let sum = c0 + c1 + c2;
            w = vec3<f32>(c0 / sum, c1 / sum, c2 / sum);
            let x = q.x - (w.y * e1.x + w.z * e2.x);
            let y = q.y - (w.y * e1.y + w.z * e2.y);
            // Outside the hull the corner of a segment must win.
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

fn direction_mesh_vertex(row: u32, word: u32) -> vec2<f32> {
    return vec2<f32>(
        bitcast<f32>(direction_mesh_word(row, word)),
        bitcast<f32>(direction_mesh_word(row, word + 1u)),
    );
}

fn direction_mesh_word(row: u32, word: u32) -> u32 {
    let width = textureDimensions(direction_mesh_words).x;
    return textureLoad(direction_mesh_words, vec2<u32>(word % width, row + word / width), 0).x;
}
