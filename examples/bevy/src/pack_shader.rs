//! Shaders of packs: a decoder of `brdfc-formats` and Bevy's lights.

use bevy::prelude::*;

const LIGHTING: &str = include_str!("pack_lighting.wgsl");

/// The group of a decoder's bindings.
const GROUP: &str = "@group(1)";

/// Adds a shader composed of these texts, a decoder and the two functions that `pack_lighting.wgsl` needs, with all bindings in the
/// group of materials. `path` is its name in messages.
pub fn add_shader(app: &mut App, handle: &Handle<Shader>, path: &str, texts: &[&str]) {
    let text = texts.concat().replace(GROUP, "@group(#{MATERIAL_BIND_GROUP})");
    let shader = Shader::from_wgsl(text + LIGHTING, path);
    if let Err(error) = app.world_mut().resource_mut::<Assets<Shader>>().insert(handle, shader) {
        error!("{path}: {error}");
    }
}
