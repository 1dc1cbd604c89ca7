//! Values of polynomial wavelet trees and flat BTFs at texture coordinates.

use brdfc_formats::pwt::PwtDecoder;
use brdfc_formats::{Pack, PackKind};
use brdfc_readers::scan_csv::TexelQuery;
use brdfc_render::flat::FlatMaterial;
use brdfc_source::flat_btf::open_flat_btf;
use brdfc_source::pack::open_pack;
use brdfc_source::{Input, InputError, Kind};
use rayon::prelude::*;

/// A material with values at texture coordinates.
#[allow(clippy::large_enum_variant)]
pub enum Relightable {
    /// A polynomial wavelet tree of one view or several.
    Pack(PwtDecoder),
    /// A flat BTF, which has several views.
    Flat(FlatMaterial),
}

impl Relightable {
    /// Reads an input. Returns `None` if it is neither a tree nor a flat BTF.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read or is invalid.
    pub fn open(input: &Input) -> Result<Option<Self>, InputError> {
        match Kind::of(input)? {
            kind if kind.is_flat_btf() => Ok(Some(Self::Flat(open_flat_material(input)?))),
            Kind::Pack(PackKind::Pwt) => match open_pack(input)? {
                Pack::Pwt(pack) => Ok(Some(Self::Pack(PwtDecoder::new(pack)))),
                _ => Ok(None),
            },
            _ => Ok(None),
        }
    }

    /// Returns true if values depend on the viewing direction.
    pub fn has_views(&self) -> bool {
        match self {
            Self::Pack(decoder) => decoder.pack().header().view_count() > 1,
            Self::Flat(_) => true,
        }
    }

    /// Returns true if the image continues beyond texture coordinates of 0 to 1.
    pub fn repeats(&self) -> bool {
        match self {
            Self::Pack(decoder) => decoder.pack().header().repeats,
            Self::Flat(_) => true,
        }
    }

    /// Number of levels of detail coarser than the finest.
    pub fn levels(&self) -> u32 {
        match self {
            Self::Pack(decoder) => decoder.pack().header().levels,
            Self::Flat(material) => material.decoder().parts().reflectance.levels() - 1,
        }
    }

    /// Evaluates [`Self::value`] for each query.
    pub fn values(&self, queries: &[TexelQuery], level: f32) -> Vec<[f32; 3]> {
        queries.par_iter().map(|query| self.value(query, level)).collect()
    }

    /// Linear RGB at a level of detail, from 0 (the coarsest) to [`Self::levels`] (the finest).
    pub fn value(&self, query: &TexelQuery, level: f32) -> [f32; 3] {
        let single = |v: [f64; 3]| v.map(|c| c as f32);
        let coarser = (self.levels() as f32 - level).max(0.0);
        match self {
            // No view is below a surface.
            Self::Pack(_) if self.has_views() && query.outgoing[2] <= 0.0 => [0.0; 3],
            Self::Pack(decoder) => {
                let [view, light] = [query.outgoing, query.incoming].map(single);
                decoder.value(query.uv.map(|c| c as f32), coarser, view, light)
            }
            Self::Flat(material) => {
                if query.incoming[2] <= 0.0 || query.outgoing[2] <= 0.0 {
                    return [0.0; 3];
                }
                // Down in the image is backwards along the bitangent.
                let [u, v] = query.uv;
                material.value([u as f32, (1.0 - v) as f32], coarser, query.outgoing, query.incoming)
            }
        }
    }
}

/// Reads a flat BTF.
///
/// # Errors
/// Returns an error if the input cannot be read or is not a flat BTF.
pub fn open_flat_material(input: &Input) -> Result<FlatMaterial, InputError> {
    let of_file = |error| InputError::Format { name: input.to_string(), error };
    FlatMaterial::new(open_flat_btf(input)?.decoder, 1).map_err(of_file)
}
