//! Shader side of trees of flat BTFs: `formats/src/flat_btf_trees/trees.wgsl` and its uniform block.

use super::trees::FlatTrees;
use crate::bindings::Binding;
use crate::cursor::block_bytes;
use crate::direction_mesh::DIRECTION_MESH_WGSL;
use crate::flat_btf::shader::{FLAT_BTF_WGSL, SIGHT_WGSL, VDIM_WGSL};
use crate::pwt::shader::TREE_WGSL;

/// WGSL for drawing a flat BTF of trees: rays through its relief, views and polynomials of its trees, and
/// `flat_trees_value`, which combines them.
pub fn flat_trees_wgsl() -> String {
    [FLAT_BTF_WGSL, VDIM_WGSL, SIGHT_WGSL, DIRECTION_MESH_WGSL, TREE_WGSL, include_str!("trees.wgsl")].join("\n")
}

/// The uniform block `FlatTreesParameters`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlatTreesParameters;

impl FlatTreesParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 16;

    /// The block of trees as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(trees: &FlatTrees) -> [u8; Self::SIZE] {
        block_bytes([u32::from(trees.has_shadows()), trees.lowest_light().to_bits()])
    }
}

impl FlatTrees {
    /// Bindings of the trees, without those of the relief and of the frame block.
    pub(crate) fn bindings(&self) -> Vec<Binding<'_>> {
        let block = FlatTreesParameters::to_bytes(self).to_vec();
        let mut all = self.pack().own_bindings();
        all.push(Binding::uniform(49, "flat_trees_parameters", block));
        all
    }
}
