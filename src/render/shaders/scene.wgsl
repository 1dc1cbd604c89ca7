// Draws a scene of materials under point lights. Pasted behind `wavelet_brdf.wgsl` and `view.wgsl`; the CPU twin is
// `render/shade.rs` with `surface_point.rs` and `environment.rs`, step by step.

struct Surface {
    mirror: f32,      // reflectance of the mirrored environment at normal incidence
    bump_size: u32,   // texels per side of the height map, 0: none
    reserved_0: u32,
    reserved_1: u32,
}

@group(2) @binding(0) var<uniform> surface: Surface;
@group(2) @binding(1) var heights: texture_2d<f32>;
@group(2) @binding(2) var environment: texture_2d<f32>;

@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = view.eye.xyz - in.position;
    let distance = length(to_eye);
    let v = to_eye / distance;
    let frame = shading_frame(in, front, v);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    var level = view.level;
    if level < 0.0 {
        level = wavelet_brdf_level(distance);
    }

    // Equation 1 of Claustres et al. 2007.
    var radiance = vec3<f32>(0.0);
    for (var k = 0u; k < view.light_count; k += 1u) {
        let to_light = lights[k].position.xyz - in.position;
        let distance_squared = dot(to_light, to_light);
        let l = to_light / sqrt(distance_squared);
        let wi = vec3<f32>(dot(l, frame[0]), dot(l, frame[1]), dot(l, frame[2]));
        if wi.z > 0.0 {
            var f_r: vec3<f32>;
            if view.hardware == 1u {
                f_r = wavelet_brdf(wi, wo, level);
            } else {
                f_r = wavelet_brdf_exact(wi, wo, level);
            }
            radiance += f_r * lights[k].intensity.rgb * (wi.z / distance_squared);
        }
    }

    if surface.mirror > 0.0 {
        let grazing = 1.0 - wo.z;
        let fresnel = surface.mirror + (1.0 - surface.mirror) * (grazing * grazing * grazing * grazing * grazing);
        let mirrored = 2.0 * dot(frame[2], v) * frame[2] - v;
        radiance = (1.0 - fresnel) * radiance + fresnel * environment_at(mirrored);
    }
    return vec4<f32>(radiance, 1.0);
}

// Tangent, bitangent and normal: two-sided, bumped, and turned towards the viewer at outlines.
fn shading_frame(in: Varying, front: bool, v: vec3<f32>) -> mat3x3<f32> {
    var n = normalize(in.normal);
    if !front {
        n = -n;
    }
    if surface.bump_size > 0u {
        let t = normalize(in.tangent - n * dot(n, in.tangent));
        let b = cross(n, t);
        let slope = height_gradient(in.uv);
        n = normalize(n - slope.x * t - slope.y * b);
    }
    return turned_frame(n, in.tangent, v);
}

// Central differences of the height map over one texel.
fn height_gradient(uv: vec2<f32>) -> vec2<f32> {
    let size = f32(surface.bump_size);
    let half = 0.5 / size;
    let du = height_at(uv + vec2<f32>(half, 0.0)) - height_at(uv - vec2<f32>(half, 0.0));
    let dv = height_at(uv + vec2<f32>(0.0, half)) - height_at(uv - vec2<f32>(0.0, half));
    return vec2<f32>(du, dv) * size;
}

// Bilinear; texel centres at (i + 1/2) / size; periodic.
fn height_at(uv: vec2<f32>) -> f32 {
    let size = i32(surface.bump_size);
    let position = uv * f32(size) - 0.5;
    let lower = floor(position);
    let weight = position - lower;
    let a = wrapped(i32(lower.x), size);
    let b = wrapped(i32(lower.x) + 1, size);
    let c = wrapped(i32(lower.y), size);
    let d = wrapped(i32(lower.y) + 1, size);
    let top = mix(textureLoad(heights, vec2<i32>(a, c), 0).r, textureLoad(heights, vec2<i32>(b, c), 0).r, weight.x);
    let bottom = mix(textureLoad(heights, vec2<i32>(a, d), 0).r, textureLoad(heights, vec2<i32>(b, d), 0).r, weight.x);
    return mix(top, bottom, weight.y);
}

fn wrapped(index: i32, size: i32) -> i32 {
    let rest = index % size;
    return select(rest, rest + size, rest < 0);
}

// Latitude-longitude image: row 0 is up, columns go round by azimuth and wrap.
fn environment_at(direction: vec3<f32>) -> vec3<f32> {
    let size = textureDimensions(environment);
    let half_turn = wavelet_brdf_atan2(abs(direction.z), direction.x);
    let azimuth = select(half_turn, 2.0 * WAVELET_BRDF_PI - half_turn, direction.z < 0.0);
    let colatitude = wavelet_brdf_atan2(sqrt(direction.x * direction.x + direction.z * direction.z), direction.y);
    let x = azimuth / (2.0 * WAVELET_BRDF_PI) * f32(size.x) - 0.5;
    let y = clamp(colatitude / WAVELET_BRDF_PI * f32(size.y) - 0.5, 0.0, f32(size.y - 1u));
    let column = floor(x);
    let row = floor(y);
    let a = wrapped(i32(column), i32(size.x));
    let b = wrapped(i32(column) + 1, i32(size.x));
    let c = i32(row);
    let d = min(c + 1, i32(size.y) - 1);
    let top = mix(environment_texel(a, c), environment_texel(b, c), x - column);
    let bottom = mix(environment_texel(a, d), environment_texel(b, d), x - column);
    return mix(top, bottom, y - row);
}

fn environment_texel(column: i32, row: i32) -> vec3<f32> {
    return textureLoad(environment, vec2<i32>(column, row), 0).rgb;
}
