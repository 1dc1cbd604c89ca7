// Evaluates a flat BTF at a list of queries, one per item. Goes between the decoder that ends with
// `formats/src/flat_btf/value.wgsl` and `items.wgsl`.

struct FlatBtfQuery {
    place: vec4<f32>, // uv and level of detail
    view: vec4<f32>,
    light: vec4<f32>,
    surface: vec4<f32>, // curvature and height
    stretch: vec4<f32>,
}

struct FlatBtfAnswer {
    seen: vec4<f32>, // position, height, sheet
    parameters: vec4<f32>, // and the rise
    value: vec4<f32>,
}

@group(0) @binding(1) var<storage, read> queries: array<FlatBtfQuery>;
@group(0) @binding(2) var<storage, read_write> answers: array<FlatBtfAnswer>;

fn compute(at: u32) {
    let uv = queries[at].place.xy;
    let level = queries[at].place.z;
    let view = queries[at].view.xyz;
    let surface = FlatBtfSurface(queries[at].surface.xyz, queries[at].surface.w, queries[at].stretch);
    let look = flat_btf_look(uv, level, view, surface);
    let point = look.sight.point;
    let value = flat_btf_shade(look, queries[at].light.xyz);
    answers[at] = FlatBtfAnswer(
        vec4<f32>(point.at, point.height, f32(point.sheet)), vec4<f32>(look.place.uv, point.rise, 0.0), vec4<f32>(value, 0.0));
}

