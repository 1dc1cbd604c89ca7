// Properties of a surface besides its BRDF, and its local frame. Appended to `view.wgsl` and `periodic.wgsl`; the CPU
// twin is `crates/render/src/shading_point.rs` with `environment.rs`.

struct Surface {
    mirror: f32,      // reflectance of the mirrored environment at normal incidence
    bump_size: u32,   // texels per side of the height map, 0: none
    part: u32,        // its index in the scene
    reserved: u32,
}

@group(2) @binding(0) var<uniform> surface: Surface;
@group(2) @binding(1) var heights: texture_2d<f32>;

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

// Share of the light that the mirror of the surface reflects, by the cosine of the view angle.
fn mirror_share(cosine: f32) -> f32 {
    if surface.mirror > 0.0 {
        let grazing = 1.0 - cosine;
        return surface.mirror + (1.0 - surface.mirror) * (grazing * grazing * grazing * grazing * grazing);
    }
    return 0.0;
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
