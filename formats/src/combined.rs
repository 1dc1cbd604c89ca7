//! Shaders that use several decoders.

use crate::bindings::FRAME_WGSL;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::flat_btf::shader::{RELIEF_WGSL, SIGHT_WGSL, VDIM_WGSL};
use crate::pwt::shader::TREE_WGSL;

/// Parts of several decoders: the mesh of directions of flat BTFs and trees, their look-ups, and the relief of flat BTFs.
const SHARED_PARTS: [&str; 5] = [DIRECTION_MESH_WGSL, TREE_WGSL, RELIEF_WGSL, VDIM_WGSL, SIGHT_WGSL];

/// Concatenates several decoders into one source, with shared declarations only once: the frame block, and parts of flat BTFs and
/// trees, which one bind group holds for one of them.
pub fn combined_wgsl<'a>(decoders: impl IntoIterator<Item = &'a str>) -> String {
    let mut source = FRAME_WGSL.to_owned();
    for decoder in decoders {
        let mut own = decoder.strip_prefix(FRAME_WGSL).unwrap_or(decoder).to_owned();
        for part in SHARED_PARTS.into_iter().filter(|part| source.contains(part)) {
            own = own.replace(part, "");
        }
        source += &own;
        source.push('\n');
    }
    source
}
