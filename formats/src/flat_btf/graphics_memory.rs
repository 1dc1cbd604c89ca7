//! What the parts take in graphics memory, as the bindings of `formats/src/flat_btf/spec.md` hold them.

use super::atlas::Atlas;
use super::decoder::{FlatBtfParts, FlatValues, Indirection};
use super::directions::SampledDirections;
use super::flat_view::FlatView;
use crate::container::{Extent, TexelFormat};

/// Bytes of texels that the part of this name takes in graphics memory, by the extent and mipmap levels of its file.
///
/// A view is a layer of the atlas, with the tiles of the layer that no light has. `position` and `mask` take nothing: no
/// shader reads them.
pub fn gpu_bytes(part: &str, extent: Extent, levels: u32) -> u64 {
    let (texels, format) = match (part, extent) {
        ("position" | "mask", _) => return 0,
        ("reference", _) => (extent.texels(), TexelFormat::Rg32Float),
        ("directions", _) => (extent.texels(), TexelFormat::R32Uint),
        ("basis", _) => (extent.texels(), TexelFormat::Rgba32Uint),
        ("weights", _) => (extent.texels_of_levels(levels), TexelFormat::Rgba8Unorm),
        ("shadow", _) => (extent.texels_of_levels(levels), TexelFormat::R8Unorm),
        // Without the ranges of blocks, whose number the extent does not tell: see `DisplacementMap::gpu_bytes`.
        ("displacement", _) => (extent.texels(), TexelFormat::Rg8Unorm),
        ("indirection" | "normal", _) => (extent.texels(), TexelFormat::Rgba16Float),
        (_, Extent::D2Array([width, _, lights])) => (Atlas::new(width, lights).texels(), TexelFormat::Rgb9E5),
        _ => (extent.texels(), TexelFormat::Rgb9E5),
    };
    texels * format.texel_bytes() as u64
}

impl FlatBtfParts {
    /// Bytes of texels in graphics memory: [`gpu_bytes`] of all parts, those of values only where there are some.
    pub fn gpu_bytes(&self) -> u64 {
        let square = |size: u32| Extent::D2([size, size]);
        let values = match &self.values {
            FlatValues::None => 0,
            FlatValues::Views(views) => {
                let of_view = |view: &FlatView| {
                    let header = view.header();
                    gpu_bytes("flat", Extent::D2Array([header.size, header.size, header.lights.len() as u32]), 1)
                };
                views.iter().map(of_view).sum()
            }
            FlatValues::Factored(asset) => asset.gpu_bytes(),
        };
        // Directions that cannot be blended have no such part.
        let directions = SampledDirections::of(&self.values).ok().flatten();
        let directions = directions.map_or(0, |directions| gpu_bytes("directions", Extent::D2(directions.extent()), 1));
        gpu_bytes("reference", square(self.reference.size()), 1)
            + match &self.indirection {
                Indirection::Samples(map) => gpu_bytes("indirection", Extent::D2(map.header().extent()), 1),
                Indirection::Compact(map) => map.gpu_bytes(),
            }
            + gpu_bytes("normal", square(self.normal.size()), 1)
            + gpu_bytes("diffuse", square(self.diffuse.size()), 1)
            + directions
            + values
    }
}
