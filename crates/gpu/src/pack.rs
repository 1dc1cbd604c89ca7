//! Packs on the device: one bind group for either codec, so that one shader draws both.
//!
//! Bindings 0 to 3 are those of `formats/src/wavelet/decode.wgsl`, 4 to 7 those of `formats/src/table/decode.wgsl`; what the codec of a
//! pack does not use is empty.

use super::bindings::{self, IMAGE, SAMPLER, UNFILTERED, UNIFORM, VOLUME};
use super::device::{Gpu, GpuError};
use brdfc_formats::BrdfPack;
use brdfc_formats::container::Extent;
use brdfc_formats::table::shader::{TABLE_BRDF_WGSL, TableBrdfParameters};
use brdfc_formats::wavelet::Filter;
use brdfc_formats::wavelet::shader::{WAVELET_BRDF_WGSL, WaveletBrdfParameters};
use brdfc_shaders::resources::{self, Contents, Resource, no_texture};
use wgpu::{BindGroup, BindGroupLayout, ShaderStages};

/// Chooses the decoder of a pack, behind both.
const BRDF_WGSL: &str = include_str!("brdf.wgsl");

/// First binding of tables.
const FIRST_OF_TABLE: u32 = 4;

/// Both decoders and what chooses between them, in this group.
pub(super) fn brdf_source(group: u32) -> String {
    [moved(WAVELET_BRDF_WGSL, group, 0), table_source(group), BRDF_WGSL.to_owned()].join("\n")
}

/// The decoder of tables alone, with its bindings where the layout has them.
pub(super) fn table_source(group: u32) -> String {
    moved(TABLE_BRDF_WGSL, group, FIRST_OF_TABLE)
}

/// A decoder with the bindings of its group 1 in another group, from `first` on.
pub(super) fn moved(source: &str, group: u32, first: u32) -> String {
    // From the last one, so that none is moved twice.
    (0..4).rev().fold(source.to_owned(), |source, binding| {
        let (from, to) = (binding, binding + first);
        source.replace(&format!("@group(1) @binding({from})"), &format!("@group({group}) @binding({to})"))
    })
}

/// Resources with their bindings from `first` on.
pub(super) fn moved_resources(mut resources: Vec<Resource>, first: u32) -> Vec<Resource> {
    resources.iter_mut().for_each(|resource| resource.binding += first);
    resources
}

/// The layout of group 1.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> BindGroupLayout {
    let of_wavelet = [(0, UNIFORM), (1, VOLUME), (2, UNFILTERED), (3, SAMPLER)];
    let of_table = [(0, UNIFORM), (1, VOLUME), (2, SAMPLER), (3, IMAGE)];
    let of_table = of_table.map(|(binding, ty)| (FIRST_OF_TABLE + binding, ty));
    bindings::layout(gpu, "pack", stages, of_wavelet.into_iter().chain(of_table))
}

/// Uploads a pack. `filter` is that of wavelet packs.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    pack: &BrdfPack,
    filter: Filter,
    distance_scale: f64,
) -> Result<BindGroup, GpuError> {
    let uniform = |bytes| Contents::Uniform(vec![0; bytes]);
    let [image, volume] = [Extent::D2([1; 2]), Extent::D3([1; 3])].map(no_texture);
    let (sampler, scale) = (Contents::Sampler { repeats: false }, distance_scale as f32);
    let (own, first, empty) = match pack {
        BrdfPack::Wavelet(pack) => {
            let empty = [(4, uniform(TableBrdfParameters::SIZE)), (5, volume), (6, sampler), (7, image)];
            (resources::wavelet(pack, filter, scale), 0, empty)
        }
        BrdfPack::Table(pack) => {
            let empty = [(0, uniform(WaveletBrdfParameters::SIZE)), (1, volume), (2, image), (3, sampler)];
            (resources::table(pack, scale), FIRST_OF_TABLE, empty)
        }
    };
    let mut resources = moved_resources(own, first);
    resources.extend(empty.map(|(binding, contents)| Resource { binding, contents }));
    bindings::bind(gpu, layout, resources, &[])
}
