//! Bidirectional texture functions: meso-geometry, its flattening, its layers and its indirection maps (Hadim et al.
//! 2009, "Flat Bidirectional Texture Functions").
//!
//! Lengths are in tiles. The surface has period 1 along x and y, z points up, and the reference plane is `z = 0`.

pub mod caster;
pub mod compact;
pub mod encode;
pub mod factored;
pub mod far;
pub mod fill;
pub mod interreflection;
pub mod layers;
pub mod light_field;
pub mod measured;
pub mod mesh;
pub mod model;
pub mod parameterise;
pub mod probes;
pub mod project;
pub mod rebuild;
pub mod sparse;
pub mod stretch;
pub mod structures;
pub mod surface;
#[cfg(test)]
mod testing;
pub mod texels;
pub mod tile_image;
pub mod triangle_tree;
pub mod vdim;
pub mod weld;
