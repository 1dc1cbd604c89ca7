//! Validates the WGSL of direction meshes without a graphics adapter.

use brdfc_formats::direction_mesh::DIRECTION_MESH_WGSL;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Both meshes of a BTF in one shader.
fn shader() -> String {
    DIRECTION_MESH_WGSL.to_owned()
        + "
        @group(0) @binding(2) var<storage, read_write> weights: array<vec3<f32>>;
        @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            let view: DirectionMeshWeights = direction_mesh_weights(vec3<f32>(0.0, 0.0, 1.0), 1u);
            weights[view.indices.x] = view.weights * direction_mesh_weights(vec3<f32>(0.0, 0.0, 1.0), 9u).weights;
        }"
}

/// Error of naga for a shader, with no capabilities beyond WebGPU without features.
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
fn mistakes_do_not_validate() {
    let good = shader();
    for (from, to) in [
        ("let area = e1.x", "let area = e1"),
        ("var best = 3.4028234e38;", "var best = 3u;"),
        ("texture_2d<u32>", "texture_2d<f32>"),
        ("fn direction_mesh_vertex(", "fn direction_mesh_word("),
    ] {
        let bad = good.replacen(from, to, 1);
        assert!(bad != good, "{from}");
        assert!(complaint(&bad).is_some(), "{to}");
    }
}
