//! Whole programs that draw.

use brdfc_shaders::Named;
use brdfc_translate::program;

const DRAWN: &str = "
@group(0) @binding(0) var<uniform> place: vec4<f32>; // where
@group(1) @binding(3) var colours: texture_2d<f32>;
@group(1) @binding(4) var smooth_: sampler;
@vertex fn corner(@location(2) at: vec2<f32>) -> @builtin(position) vec4<f32> { return vec4<f32>(at, 0.0, 1.0) + place; }
@fragment fn colour() -> @location(0) vec4<f32> { return textureSampleLevel(colours, smooth_, place.xy, 0.0); }
";

#[test]
fn bindings_are_identified_by_their_names() {
    let made = program(DRAWN, "corner", "colour").unwrap();
    let contains = |lines: &[String], text: &str| lines.iter().any(|line| line.contains(text));
    let bound = |all: &[Named]| all.iter().map(|one| (one.group, one.binding)).collect::<Vec<_>>();
    // A block has a name in each shader.
    assert_eq!((bound(&made.blocks), bound(&made.textures)), (vec![(0, 0), (0, 0)], vec![(1, 3)]));
    assert_eq!(made.textures[0].sampler, Some(4));
    for Named { name, .. } in &made.blocks {
        assert!(contains(&made.vertex, name) || contains(&made.fragment, name), "{name}");
    }
    assert!(contains(&made.fragment, &format!("uniform highp sampler2D {};", made.textures[0].name)));
    assert!(contains(&made.vertex, "layout(location = 2) in vec2"));
    assert_eq!(made, program(DRAWN, "corner", "colour").unwrap());
}

#[test]
fn wrong_sources_are_reported() {
    assert!(program(DRAWN, "nothing", "colour").is_err());
    assert!(program("fn f() -> f32 { return 1u; }", "f", "f").unwrap_err().contains("return"));
}
