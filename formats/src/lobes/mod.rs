//! Lobes of a BRDF: a few look-ups in a prefiltered environment that replace the integral over all directions. Layout:
//! `spec.md` in this folder.

mod decode;
pub(crate) mod descriptor;
mod header;
mod pack;

pub use decode::{LobeLookup, plane_of_view, view_azimuth, view_position};
pub use header::{
    Anchor, LOBES_ENTRY, Lobe, LobesHeader, MAX_AZIMUTHS, MAX_LOBES, MAX_NODES, MAX_SCALE, MAX_SHARPNESS,
};
pub use pack::{LOBES_WGSL, LobesPack};
