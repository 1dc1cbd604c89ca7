//! Bidirectional texture functions: meso-geometry, its flattening, and view-dependent indirection maps (Hadim et al.
//! 2009, "Flat Bidirectional Texture Functions").
//!
//! Lengths are in tiles: the surface repeats after 1 along x and y; z is up, and the reference plane is `z = 0`.

pub mod mesh;
pub mod weld;
