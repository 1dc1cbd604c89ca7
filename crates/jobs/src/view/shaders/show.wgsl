// Displays renderings side by side (means of a pixel's samples, exposed and sRGB-encoded), or their difference.
// RAMP and FULL_SCALE, the colours of differences, precede it.

struct Show {
    background: vec3<f32>, // linear RGB of the display, 0 to 1
    exposure: f32,
    split: f32,            // in pixels: the first rendering is left of it
    what: u32,
    samples: u32,          // along a pixel's side
    pair: u32,             // 1: there is a second rendering
    step: u32,             // distance between displayed pixels
    environment: u32,      // bits: 1 it is behind the first rendering, 2 behind the second
    reserved_0: u32,
    reserved_1: u32,
}

const RENDERINGS: u32 = 0u;
const COLOURS: u32 = 1u; // of the difference, on the background where not both show a surface
const DELTA_E: u32 = 2u; // in red; in alpha 1 where both show a surface
const RADIANCE: u32 = 3u; // of the last rendering; in alpha its coverage, 0 where not all show a surface

@group(0) @binding(0) var<uniform> parameters: Show;
@group(0) @binding(1) var first: texture_2d<f32>;
@group(0) @binding(2) var second: texture_2d<f32>;
@group(0) @binding(3) var behind: texture_2d<f32>; // radiance of the environment, one sample a pixel

@vertex
fn cover(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(select(-1.0, 3.0, corner == 1u), select(-1.0, 3.0, corner == 2u), 0.0, 1.0);
}

@fragment
fn show(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(at.xy) * i32(parameters.step);
    var a = vec4<f32>(0.0);
    var b = vec4<f32>(0.0);
    let side = i32(parameters.samples);
    let is_pair = parameters.pair == 1u;
    for (var y = 0; y < side; y += 1) {
        for (var x = 0; x < side; x += 1) {
            let sample = pixel * side + vec2<i32>(x, y);
            a += textureLoad(first, sample, 0);
            if is_pair {
                b += textureLoad(second, sample, 0);
            }
        }
    }
    let share = 1.0 / f32(side * side);
    a *= share;
    b *= share;
    if parameters.what == RADIANCE {
        let last = select(a, b, is_pair);
        return vec4<f32>(last.rgb, select(last.a, min(a.a, b.a), is_pair));
    }
    if parameters.what == RENDERINGS {
        let is_first = at.x < parameters.split;
        let rendering = select(b, a, is_first);
        let surface = min(rendering.rgb * parameters.exposure, vec3<f32>(1.0));
        var background = parameters.background;
        if (parameters.environment & select(2u, 1u, is_first)) != 0u {
            background = min(textureLoad(behind, pixel, 0).rgb * parameters.exposure, vec3<f32>(1.0));
        }
        return vec4<f32>(encoded(surface + background * (1.0 - rendering.a)), 1.0);
    }
    // On the same surface both have the same coverage. Pixels with a sample that one of the materials does not cover are not
    // compared.
    let is_both = a.a > 0.0 && abs(a.a - b.a) < 0.5 * share;
    let apart = distance(lab(a.rgb * parameters.exposure), lab(b.rgb * parameters.exposure));
    let delta_e = select(0.0, apart, is_both);
    if parameters.what == DELTA_E {
        return vec4<f32>(delta_e, 0.0, select(0.0, 1.0, a.a > 0.0 || b.a > 0.0), select(0.0, 1.0, is_both));
    }
    return vec4<f32>(select(encoded(parameters.background), heat(delta_e / FULL_SCALE), is_both), 1.0);
}

// The transfer curve of sRGB.
fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
    let steep = 1.055 * pow(max(c, vec3<f32>(1e-6)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(steep, 12.92 * c, c <= vec3<f32>(0.0031308));
}

// CIE L*a*b* (D65) of linear RGB; the CPU twin is `lab` of the crate `brdfc-metrics`.
fn lab(colour: vec3<f32>) -> vec3<f32> {
    let c = clamp(colour, vec3<f32>(0.0), vec3<f32>(1.0));
    let x = dot(c, vec3<f32>(0.433953, 0.3762194, 0.1898276));
    let y = dot(c, vec3<f32>(0.2126729, 0.7151522, 0.072175));
    let z = dot(c, vec3<f32>(0.0177566, 0.10946796, 0.8727754));
    let t = vec3<f32>(x, y, z);
    let root = pow(max(t, vec3<f32>(1e-6)), vec3<f32>(1.0 / 3.0));
    let f = select(t * 7.787037 + 16.0 / 116.0, root, t > vec3<f32>(0.008856452));
    return vec3<f32>(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z));
}

fn heat(share: f32) -> vec3<f32> {
    let position = clamp(share, 0.0, 1.0) * 4.0;
    let lower = min(i32(position), 3);
    var ramp = RAMP;
    return mix(ramp[lower], ramp[lower + 1], position - f32(lower));
}
