// Draws a mesh of one material under point lights and an environment, as in the scenes of `brdfc render`. It follows a decoder, the
// functions of its kind (`placed`, `level_at`, `looked`, `reflected`, `lit_by_environment`), the renderer's `shading_point.wgsl`
// and `corner.wgsl`, and `view.wgsl`.

const PI: f32 = 3.14159274;

@vertex
fn project(corner: Corner) -> Varying {
    return projected(corner, view.eye.xyz, view.right.xyz, view.up.xyz, view.forward.xyz, vec2<f32>(0.0));
}

// Linear radiance and coverage. Surfaces seen or lit from directions that the material does not cover are left out.
@fragment
fn shade(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let uv = placed(in.uv, front);
    let to_eye = view.eye.xyz - in.position;
    let distance = length(to_eye);
    let of_pixel = level_at(distance, dpdx(uv), dpdy(uv));
    let level = select(view.level, of_pixel, view.level < 0.0);
    let v = to_eye / distance;
    let n = select(-1.0, 1.0, front) * normalize(in.normal);
    let frame = turned_frame(n, in.tangent, v);
    let wo = vec3<f32>(dot(v, frame[0]), dot(v, frame[1]), dot(v, frame[2]));
    let look = looked(in, front, frame, uv, level, wo);
    if look.is_hidden {
        discard;
    }
    var seen = within(wo.z, view.sines.xy);
    var radiance = lit_by_environment(frame, wo);
    for (var k = 0u; k < view.light_count; k += 1u) {
        let to_light = view.lights[k].position.xyz - look.position;
        let distance_squared = dot(to_light, to_light);
        let l = to_light / sqrt(distance_squared);
        let wi = vec3<f32>(dot(l, frame[0]), dot(l, frame[1]), dot(l, frame[2]));
        if wi.z > 0.0 || look.is_relief {
            seen = seen && within(max(wi.z, 0.0), view.sines.zw);
            radiance += reflected(uv, level, wo, wi) * view.lights[k].intensity.rgb / distance_squared;
        }
    }
    return select(vec4<f32>(0.0), vec4<f32>(radiance, 1.0), seen);
}

// What is drawn at a point.
struct Look {
    position: vec3<f32>, // where distances to lights begin
    is_hidden: bool,
    is_relief: bool,     // it may be lit from below the horizon of the surface
}

fn within(sine: f32, sines: vec2<f32>) -> bool {
    return sine >= sines.x - 1e-5 && sine <= sines.y + 1e-5;
}
