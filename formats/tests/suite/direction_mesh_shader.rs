//! The WGSL of direction meshes without a graphics adapter: it validates, under any names, several times in one shader.

use brdfc_formats::direction_mesh::direction_mesh_wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Both meshes of a BTF in one shader.
fn shader() -> String {
    let mut text = String::new();
    for (binding, (function, words)) in
        [("view_samples", "view_words"), ("light_samples", "light_words")].iter().enumerate()
    {
        text += &format!("@group(0) @binding({binding}) var<storage, read> {words}: array<u32>;\n");
        text += &direction_mesh_wgsl(function, words);
    }
    text + "
        @group(0) @binding(2) var<storage, read_write> weights: array<vec3<f32>>;
        @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            let view: view_samples_result = view_samples(vec3<f32>(0.0, 0.0, 1.0));
            weights[view.indices.x] = view.weights * light_samples(vec3<f32>(0.0, 0.0, 1.0)).weights;
        }"
}

/// What naga says against a shader; no capability beyond those that WebGPU has without features.
fn complaint(text: &str) -> Option<String> {
    let module = match naga::front::wgsl::parse_str(text) {
        Ok(module) => module,
        Err(error) => return Some(error.emit_to_string(text)),
    };
    let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    result.err().map(|error| error.emit_to_string(text))
}

#[test]
fn it_validates() {
    assert_eq!(complaint(&shader()), None);
}

#[test]
fn no_placeholder_is_left() {
    let text = direction_mesh_wgsl("samples", "words");
    assert!(!text.contains("DIRECTION_MESH") && text.contains("fn samples(direction: vec3<f32>) -> samples_result"));
    assert!(text.contains("words[3]"));
}

#[test]
fn mistakes_do_not_validate() {
    let good = shader();
    for (from, to) in [
        ("let area = e1.x", "let area = e1"),
        ("var best = 3.4028234e38;", "var best = 3u;"),
        ("var<storage, read> view_words: array<u32>", "var<storage, read> view_words: array<f32>"),
        ("fn light_samples(", "fn view_samples("),
    ] {
        let bad = good.replacen(from, to, 1);
        assert!(bad != good, "{from}");
        assert!(complaint(&bad).is_some(), "{to}");
    }
}
