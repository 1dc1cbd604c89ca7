//! A codec that exists only here, for tests of loaders, which must bind its pack by its metadata alone.

use crate::engines::{Query, SIDE};
use crate::packs::Numbers;
use brdfc_formats::bindings::{Binding, Bindings, FRAME_WGSL, FrameBlock, Texels};
use brdfc_formats::container::{Extent, TexelFormat, half};
use brdfc_formats::wavelet::Filter;
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// Texels of the ramp, and of the shade's finest level: columns, rows.
const RAMP: u32 = 8;
const SHADE: [u32; 2] = [16, 8];
const LEVELS: u32 = 4;
/// Colours at both ends of the gradient.
const LOW: [f32; 4] = [0.1, 0.2, 0.3, 0.0];
const HIGH: [f32; 4] = [0.9, 0.6, 0.2, 0.0];
/// Maximum error of answers: samplers of GPUs have weights of 8 bits.
const BOUND: f32 = 4e-3;

/// Frame-dependent parameters. The scale differs from the default.
pub const FRAME: FrameBlock = FrameBlock { distance_scale: 2.0, sampler_filters: true, blend: Filter::Bilinear };

/// Code that evaluates a query, as returned by [`call`](crate::engines::call).
pub const CALL: &str = "vec4f(gradient(a.xy, a.z), 0.0)";

const WGSL: &str = "
struct GradientParameters { low: vec4<f32>, high: vec4<f32> }
@group(1) @binding(40) var<uniform> gradient_parameters: GradientParameters;
@group(1) @binding(41) var gradient_ramp: texture_2d<f32>;
@group(1) @binding(42) var gradient_shade: texture_2d<f32>;
@group(1) @binding(43) var gradient_sampler: sampler;
fn gradient(uv: vec2<f32>, level: f32) -> vec3<f32> {
    let ramp = textureLoad(gradient_ramp, vec2<i32>(i32(fract(uv.x) * 8.0), 0), 0).x;
    let shade = textureSampleLevel(gradient_shade, gradient_sampler, uv, level).x;
    let colour = mix(gradient_parameters.low, gradient_parameters.high, ramp * shade);
    return colour.xyz * brdfc_frame.distance_scale;
}
";

/// The decoder in GLSL ES 3.00.
pub const ESSL300: &str = "precision highp float;
precision highp int;
struct BrdfcFrame { float distance_scale; uint sampler_filters; uint blend; uint reserved; };
struct GradientParameters { vec4 low; vec4 high; };
layout(std140) uniform BrdfcFrameBlock { BrdfcFrame brdfc_frame; };
layout(std140) uniform GradientParametersBlock { GradientParameters gradient_parameters; };
uniform highp sampler2D gradient_ramp;
uniform highp sampler2D gradient_shade;
vec3 gradient(vec2 uv, float level) {
    float ramp = texelFetch(gradient_ramp, ivec2(int(fract(uv.x) * 8.0), 0), 0).x;
    float shade = textureLod(gradient_shade, uv, level).x;
    return mix(gradient_parameters.low, gradient_parameters.high, ramp * shade).xyz * brdfc_frame.distance_scale;
}
";

/// The decoder in WGSL.
pub fn wgsl() -> String {
    FRAME_WGSL.to_owned() + WGSL
}

fn ramp() -> Vec<u8> {
    (0..RAMP).map(|k| (255 * k / (RAMP - 1)) as u8).collect()
}

/// A level of the shade: smooth, periodic, and brighter than the finer one.
fn shade(level: u32) -> ([u32; 2], Vec<u16>) {
    let [width, height] = SHADE.map(|side| (side >> level).max(1));
    let share = |k: u32, side: u32| (k as f32 + 0.5) / side as f32 * TAU;
    let value = |k: u32| {
        let (x, y) = (share(k % width, width), share(k / width, height));
        0.4 + 0.1 * x.sin() * y.cos() + 0.2 * level as f32
    };
    ([width, height], (0..width * height).map(|k| half::encode(value(k))).collect())
}

/// Resources of the decoder.
pub fn bindings() -> Bindings<'static> {
    let block: Vec<u8> = [LOW, HIGH].as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    let texels: Vec<u8> = (0..LEVELS).flat_map(|level| shade(level).1).flat_map(u16::to_le_bytes).collect();
    let shade = Texels::new(TexelFormat::R16Float, Extent::D2(SHADE), texels).with_levels(LEVELS);
    Bindings::new(
        "gradient",
        1,
        [
            Binding::frame(),
            Binding::uniform(40, "gradient_parameters", block),
            Binding::texture(
                41,
                "gradient_ramp",
                Texels::new(TexelFormat::R8Unorm, Extent::D2([RAMP, 1]), ramp()).of_file(),
            ),
            Binding::texture(42, "gradient_shade", shade.sampled("gradient_sampler")),
            Binding::sampler(43, "gradient_sampler", true),
        ],
    )
}

/// A file of its pack.
pub fn file() -> Vec<u8> {
    bindings().to_file(BTreeMap::from([("brdfc.gradient".to_owned(), b"of no other".to_vec())]), true)
}

/// Places, including some outside the tile, and levels.
pub fn queries() -> Vec<Query> {
    let mut numbers = Numbers::new(17);
    let query = |k: usize| {
        // Avoid the boundaries of the ramp's texels.
        let column = f64::from(numbers.bits() % (3 * RAMP)) + numbers.between(0.01, 0.99);
        let u = (column / f64::from(RAMP) - 1.0) as f32;
        [[u, numbers.between(-1.0, 2.0) as f32, (k % 13) as f32 / 4.0, 0.0], [0.0; 4], [0.0; 4]]
    };
    (0..SIDE * SIDE).map(query).collect()
}

/// Expected answer of a shader.
fn answer([[u, v, level, _], ..]: &Query) -> [f32; 4] {
    let at = |level: u32| {
        let ([width, height], texels) = shade(level);
        let axis = |place: f32, side: u32| {
            let place = place * side as f32 - 0.5;
            let texel = |k: f32| k.rem_euclid(side as f32) as u32 % side;
            ([texel(place.floor()), texel(place.floor() + 1.0)], place - place.floor())
        };
        let ((columns, right), (rows, down)) = (axis(*u, width), axis(*v, height));
        let of_row = |row: u32| {
            let [a, b] = columns.map(|column| half::decode(texels[(row * width + column) as usize]));
            a + right * (b - a)
        };
        let [a, b] = rows.map(of_row);
        a + down * (b - a)
    };
    let (fine, coarse) = (at(level.floor() as u32), at((level.floor() as u32 + 1).min(LEVELS - 1)));
    let shade = fine + level.fract() * (coarse - fine);
    let ramp = f32::from(ramp()[(u.rem_euclid(1.0) * RAMP as f32) as usize]) / 255.0;
    let channel = |k: usize| (LOW[k] + ramp * shade * (HIGH[k] - LOW[k])) * FRAME.distance_scale;
    [channel(0), channel(1), channel(2), 0.0]
}

/// Compares answers to [`queries`] with the CPU's.
///
/// # Panics
/// If an answer is beyond the bound, or if the check could not detect answers to other queries.
pub fn check(what: &str, found: &[[f32; 4]]) {
    let expected: Vec<[f32; 4]> = queries().iter().map(answer).collect();
    let largest = |found: &[[f32; 4]]| {
        let errors = found.iter().zip(&expected).flat_map(|(a, b)| (0..4).map(|k| (a[k] - b[k]).abs()));
        errors.map(|error| if error.is_nan() { f32::INFINITY } else { error }).fold(0.0, f32::max)
    };
    assert_eq!(found.len(), expected.len());
    let error = largest(found);
    println!("agrees: {what}, a codec that exists only in tests: {error:.1e}");
    assert!(error < BOUND, "{what}: {error}");
    let mut shifted = found.to_vec();
    shifted.rotate_left(1);
    assert!(largest(&shifted) > 10.0 * BOUND, "{what}");
}
