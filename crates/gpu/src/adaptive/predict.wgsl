// Bandwidth and deviation of each point. Appended to `formats/src/bandwidth/map.wgsl`,
// `formats/src/bandwidth/propagation.wgsl` and `formats/src/importance/pack.wgsl`; the CPU twins are
// `crates/render/src/adaptive/predict.rs` and `tile.rs`.

// Points are of the same piece of a surface if their normals have at least this cosine.
const SAME_PIECE: f32 = 0.95;

// Sums over some of the directions of a point.
struct Share {
    average: BandwidthAverage,
    variance: BandwidthVariance,
}

// The points of one part in a tile of 4 x 4. Each looks along its own run of directions, and reuses the results of the
// other points of the same piece.
@compute @workgroup_size(64)
fn predict(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let columns = (rendering.points.x + 3u) / 4u;
    let corner = 4u * vec2<u32>((job.first + at) % columns, (job.first + at) / columns);
    var points: array<u32, 16>;
    var own: array<Share, 16>;
    var textures: array<TexturePoint, 16>;
    for (var k = 0u; k < 16u; k += 1u) {
        points[k] = point_of_tile(corner, k);
        if points[k] != NONE {
            textures[k] = texture_point(points[k]);
            own[k] = share_of(points[k], k, textures[k].bandwidth);
        }
    }
    for (var k = 0u; k < 16u; k += 1u) {
        let point = points[k];
        if point == NONE {
            continue;
        }
        var all = Share(BandwidthAverage(Bandwidth(0.0, 0.0), 0.0), BandwidthVariance(0.0, 0.0, 0.0));
        var count = 0u;
        for (var other = 0u; other < 16u; other += 1u) {
            if other == k || is_same_piece(point, points[other]) {
                all = joined(all, own[other]);
                count += 1u;
            }
        }
        // Four shares cover all directions of a point.
        for (var step = 1u; step < 16u && count < 4u; step += 1u) {
            let next = (k + step) % 16u;
            if !is_same_piece(point, points[next]) {
                all = joined(all, share_of(point, next, textures[k].bandwidth));
                count += 1u;
            }
        }
        let angular = bandwidth_average_mean(all.average).angular;
        let albedo = job.material.albedo * texture_luminance(textures[k].colour);
        let shown = albedo * bandwidth_variance_mean(all.variance);
        let deviation = visible_deviation(bandwidth_variance_relative(all.variance, 0.0), shown);
        predicted[point] = vec4<f32>(rendering_bandwidth(angular), deviation, predicted[point].z, angular);
    }
}

// Point k of a tile, if it shows this part.
fn point_of_tile(corner: vec2<u32>, k: u32) -> u32 {
    let place = corner + vec2<u32>(k % 4u, k / 4u);
    if any(place >= rendering.points) {
        return NONE;
    }
    let point = place.y * rendering.points.x + place.x;
    return select(NONE, point, part_of(point) == job.material.part);
}

fn is_same_piece(point: u32, other: u32) -> bool {
    if other == NONE {
        return false;
    }
    return product(normal_of(point), normal_of(other)) >= SAME_PIECE;
}

// Evaluates a run of directions of a point, with the bandwidth of its texture.
fn share_of(point: u32, number: u32, spatial: f32) -> Share {
    let frame = frame_of(point);
    let viewer = viewer_of(position_of(point));
    let bend = predicted[point].z;
    let outgoing = into_frame(frame, viewer.xyz);
    let outgoing_cell = bandwidth_cell(outgoing);
    var average = BandwidthAverage(Bandwidth(0.0, 0.0), 0.0);
    var variance = BandwidthVariance(0.0, 0.0, 0.0);
    let run = (settings.directions + 3u) / 4u;
    for (var index = number * run; index < (number + 1u) * run; index += 1u) {
        let drawn = importance_sample(outgoing, index);
        if drawn.inverse_density <= 0.0 {
            variance = bandwidth_variance_add_range(variance, 0.0, 0.0, 0.0, 0.0);
            continue;
        }
        let solid_angle = drawn.inverse_density / f32(4u * run);
        let found = light_around(into_world(frame, drawn.incoming), solid_angle);
        let lobe = bandwidth_brdf_cells(bandwidth_cell(drawn.incoming), outgoing_cell);
        let surface = BandwidthSurface(drawn.incoming.z, outgoing.z, bend, lobe, spatial);
        let arrives = bandwidth_one_bounce(Bandwidth(0.0, found.y), 0.0, surface, viewer.w);
        let own = bandwidth_albedo(surface, viewer.w).angular;
        let shows = Bandwidth(arrives.spatial, max(arrives.angular, own));
        average = bandwidth_average_add(average, shows, found.x);
        variance = bandwidth_variance_add_range(variance, found.x, found.z, found.w, lobe);
    }
    return Share(average, variance);
}

// Mean light around a direction over approximately this solid angle: radiance, bandwidth, mean squares, bandwidth times
// squares.
fn light_around(direction: vec3<f32>, solid_angle: f32) -> vec4<f32> {
    var size = textureDimensions(bandwidth_environment_map);
    let covered = solid_angle * f32(size.x * size.y) / (2.0 * BANDWIDTH_PI * BANDWIDTH_PI);
    // Half the exponent is the logarithm of base 4, rounded down.
    let exponent = i32(bitcast<u32>(covered) >> 23u) - 127;
    let level = u32(clamp(exponent >> 1u, 0, i32(firstLeadingBit(max(size.x, size.y)))));
    let at = bandwidth_environment_texel(direction) >> vec2<u32>(level);
    var row = 0u;
    for (var finer = 0u; finer < level; finer += 1u) {
        row += size.y;
        size = max(size / 2u, vec2<u32>(1u));
    }
    let texel = min(at, size - 1u);
    return textureLoad(light, vec2<u32>(texel.x, row + texel.y), 0);
}

fn joined(a: Share, b: Share) -> Share {
    return Share(bandwidth_average_join(a.average, b.average), bandwidth_variance_join(a.variance, b.variance));
}

// Cycles per pixel of the rendering.
fn rendering_bandwidth(angular: f32) -> f32 {
    return pixel_bandwidth(angular, settings.field_of_view, vec2<f32>(rendering.pixels), settings.largest);
}

// Standard deviation of one sample in the display's encoded values.
fn visible_deviation(variance: f32, radiance: f32) -> f32 {
    let shown = radiance / settings.white;
    if shown < 1.0 {
        return sqrt(variance) * sqrt(shown);
    }
    return sqrt(variance) * (1.0 / (shown * shown));
}
