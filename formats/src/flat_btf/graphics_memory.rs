//! What flat BTFs take in graphics memory, as the bindings of `formats/src/flat_btf/spec.md` hold them.

use super::atlas::Atlas;
use super::decoder::{FlatBtfParts, FlatValues, Indirection};
use super::directions::SampledDirections;
use super::flat_view::FlatView;
use crate::container::{Extent, TexelFormat};

/// Bytes of the values of one view as they are, `size` x `size` texels under so many lights: a layer of the atlas, with the tiles
/// that no light has.
pub fn view_gpu_bytes(size: u32, lights: u32) -> u64 {
    Atlas::new(size, lights).texels() * TexelFormat::Rgb9E5.texel_bytes() as u64
}

impl FlatBtfParts {
    /// Bytes of texels in graphics memory, those of values only where there are some.
    pub fn gpu_bytes(&self) -> u64 {
        let bytes = |extent: [u32; 2], format: TexelFormat| Extent::D2(extent).texels() * format.texel_bytes() as u64;
        let values = match &self.values {
            FlatValues::None => 0,
            FlatValues::Views(views) => {
                let of_view = |view: &FlatView| view_gpu_bytes(view.header().size, view.header().lights.len() as u32);
                views.iter().map(of_view).sum()
            }
            FlatValues::Factored(asset) => asset.gpu_bytes(),
        };
        // Nothing is bound of directions that cannot be blended.
        let directions = SampledDirections::of(&self.values).ok().flatten();
        bytes([self.reference.size(); 2], TexelFormat::Rg32Float)
            + match &self.indirection {
                Indirection::Samples(map) => bytes(map.header().extent(), TexelFormat::Rgba16Float),
                Indirection::Compact(map) => map.gpu_bytes(),
            }
            + bytes([self.normal.size(); 2], TexelFormat::Rgba16Float)
            + bytes([self.diffuse.size(); 2], TexelFormat::Rgb9E5)
            + directions.map_or(0, |directions| bytes(directions.extent(), TexelFormat::R32Uint))
            + values
    }
}
