// Bandwidth and deviation of each point. Pasted behind `bandwidth.wgsl`, `bandwidth_propagation.wgsl`, `importance.wgsl`
// and `environment.wgsl`; the CPU twin is `render/adaptive/predict.rs`.

@compute @workgroup_size(64)
fn predict(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = within_job(id);
    if at >= job.count {
        return;
    }
    let point = job.first + at;
    if part_of(point) != material.part {
        return;
    }
    let found = predict_at(point, predicted[point].z);
    predicted[point] = vec4<f32>(picture_bandwidth(found.x), found.y, predicted[point].z, found.x);
}

// Angular bandwidth and deviation.
fn predict_at(point: u32, bend: f32) -> vec2<f32> {
    let frame = frame_of(point);
    let viewer = viewer_of(position_of(point));
    let outgoing = into_frame(frame, viewer.xyz);
    var average = BandwidthAverage(Bandwidth(0.0, 0.0), 0.0);
    var variance = BandwidthVariance(0.0, 0.0, 0.0);
    var light_sum = 0.0;
    for (var index = 0u; index < settings.directions; index += 1u) {
        let drawn = importance_sample(outgoing, index);
        if drawn.inverse_density <= 0.0 {
            variance = bandwidth_variance_add(variance, 0.0, 0.0, 0.0);
            continue;
        }
        let direction = into_world(frame, drawn.incoming);
        let light = bandwidth_environment(direction);
        let lobe = bandwidth_brdf(drawn.incoming, outgoing);
        let contribution = max(luminance(environment_at(direction)), 0.0);
        let surface = BandwidthSurface(drawn.incoming.z, outgoing.z, bend, lobe, 0.0);
        let arrives = bandwidth_one_bounce(Bandwidth(0.0, light), 0.0, surface, viewer.w);
        light_sum += contribution;
        average = bandwidth_average_add(average, arrives, contribution);
        variance = bandwidth_variance_add(variance, light, lobe, contribution);
    }
    let shown = material.albedo * light_sum / f32(max(settings.directions, 1u));
    let angular = bandwidth_average_mean(average).angular;
    return vec2<f32>(angular, visible_deviation(bandwidth_variance_relative(variance, 0.0), shown));
}

// Cycles per pixel of the picture.
fn picture_bandwidth(angular: f32) -> f32 {
    return bandwidth_pixel(angular, settings.field_of_view, vec2<f32>(picture.pixels), settings.largest);
}

// Standard deviation of one sample in units of the display's codes.
fn visible_deviation(variance: f32, radiance: f32) -> f32 {
    let shown = radiance / settings.white;
    if shown < 1.0 {
        return sqrt(variance) * sqrt(shown);
    }
    return sqrt(variance) * (1.0 / (shown * shown));
}

// Rec. 709.
fn luminance(colour: vec3<f32>) -> f32 {
    return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b;
}
