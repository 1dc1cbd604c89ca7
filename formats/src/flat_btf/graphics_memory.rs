//! GPU memory of flat BTFs, for the bindings in `formats/src/flat_btf/spec.md`.

use super::atlas::Atlas;
use super::decoder::{FlatBtfParts, FlatValues, Indirection};
use super::directions::SampledDirections;
use super::flat_view::FlatView;
use crate::container::{Extent, TexelFormat};

/// GPU memory of the uncompressed values of one view with `size` x `size` texels, bytes: a layer of the atlas,
/// including unused tiles.
pub fn view_gpu_bytes(size: u32, lights: u32) -> u64 {
    Atlas::new(size, lights).texels() * TexelFormat::Rgb9E5.texel_bytes() as u64
}

impl FlatBtfParts {
    /// GPU memory of all textures, bytes. Textures of values count only if there are values.
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
        // Directions that cannot be interpolated are not bound.
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
