//! Shaders of packs: a decoder of `brdfc-formats` and Bevy's lights.

use bevy::prelude::*;

const LIGHTING: &str = include_str!("pack_lighting.wgsl");

/// Adds the shader of a decoder, its bindings in the group of materials under the numbers that `moved` says. `calls` are the two
/// functions that `pack_lighting.wgsl` asks for; `path` is what messages call the whole.
pub fn add_shader(
    app: &mut App,
    handle: &Handle<Shader>,
    path: &str,
    [decoder, calls]: [&str; 2],
    moved: impl Fn(u32) -> u32,
) {
    let mut text = String::new();
    for line in decoder.lines() {
        match binding(line) {
            Some((number, rest)) => {
                text += &format!("@group(#{{MATERIAL_BIND_GROUP}}) @binding({}){rest}", moved(number));
            }
            None => text += line,
        }
        text.push('\n');
    }
    let shader = Shader::from_wgsl(text + calls + LIGHTING, path);
    if let Err(error) = app.world_mut().resource_mut::<Assets<Shader>>().insert(handle, shader) {
        error!("{path}: {error}");
    }
}

/// The number of a decoder's binding, and what stands behind it.
fn binding(line: &str) -> Option<(u32, &str)> {
    let (number, rest) = line.strip_prefix("@group(1) @binding(")?.split_once(')')?;
    Some((number.parse().ok()?, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bindings_of_decoders() {
        assert_eq!(binding("@group(1) @binding(12) var s: sampler;"), Some((12, " var s: sampler;")));
        assert_eq!(binding("@group(0) @binding(1) var s: sampler;"), None);
        assert_eq!(binding("fn table_brdf_levels() -> u32 {"), None);
    }
}
