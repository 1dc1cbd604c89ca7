//! File of a flat BTF: shader bindings, and headers of the images.

use super::decoder::FlatBtfDecoder;
use super::directions::SampledDirections;
use super::factored::{BasisMap, FACTORED, FactoredFlatBtf, ResidualMap, WeightMap};
use super::layers::{LAYERS, LayerMap};
use super::relief::{FlatBtfParts, Relief, StoredReflectance};
use super::shader::{BASIS, DIRECTIONS, DISPLACEMENTS, HEIGHTS, INDIRECTION, REFERENCE, RESIDUAL, SHADOWS, TABLES};
use super::shadows::ShadowMap;
use super::vdim::Vdim;
use super::vdim_header::VDIM;
use crate::FormatError;
use crate::bindings::{Bindings, PackFile};
use crate::container::Texture;
use crate::flat_btf_trees::{FlatTrees, TREES_ENTRY};
use std::collections::BTreeMap;

/// Key of the encoder's report: settings and measured errors, JSON. Shaders do not read it.
const REPORT: &str = "brdfc.flat-btf.report";

/// A flat BTF as stored in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfFile {
    /// Decoder with the parts of the asset.
    pub decoder: FlatBtfDecoder,
    /// Meshes that interpolate sampled views and lights; `None` without components and sampled shadows.
    pub directions: Option<SampledDirections>,
    /// Report of the encoder, as JSON text; empty if there is none.
    pub report: String,
}

impl FlatBtfFile {
    /// Creates a file without a report.
    ///
    /// # Errors
    /// Returns an error if views or lights cannot be interpolated, or if sampled shadows do not match the reflectance.
    pub fn new(decoder: FlatBtfDecoder) -> Result<Self, FormatError> {
        check_shadows(decoder.parts())?;
        let directions = SampledDirections::of(decoder.parts())?;
        Ok(Self { decoder, directions, report: String::new() })
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let FlatBtfParts { relief, reflectance } = self.decoder.parts();
        let mut entries: BTreeMap<String, Vec<u8>> = match reflectance {
            StoredReflectance::Factors(factors) => {
                let mut entries = factors.basis().header().entries();
                entries.extend([factors.weights().entry()]);
                entries.extend(factors.residual().map(ResidualMap::entry));
                entries
            }
            StoredReflectance::Trees(trees) => trees.entries().into(),
        };
        entries.extend(match relief {
            Relief::Layers(layers) => vec![layers.entry()],
            Relief::Vdim(map, shadows) => {
                map.entries().into_iter().chain(shadows.as_ref().map(ShadowMap::entry)).collect()
            }
        });
        if !self.report.is_empty() {
            entries.insert(REPORT.to_owned(), self.report.clone().into_bytes());
        }
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the file's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        self.decoder.bindings(self.directions.as_ref())
    }

    /// GPU memory of the textures, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        self.bindings().gpu_bytes()
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/flat_btf/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/flat_btf/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let report = file.entries.remove(REPORT).unwrap_or_default();
        let report = String::from_utf8(report)
            .map_err(|error| FormatError::whole(REPORT, format!("invalid UTF-8: {error}"), "JSON").problem())?;
        let form = [FACTORED, TREES_ENTRY].map(|key| file.entries.contains_key(key));
        let reflectance = match form {
            [true, true] => return Err(both("reflectance", [FACTORED, TREES_ENTRY])),
            [false, true] => FlatTrees::take_from(&mut file)?.into(),
            [_, false] => factors(&mut file)?.into(),
        };
        let relief = relief(&mut file)?;
        let directions = file.take_texture(DIRECTIONS).filter(|_| form == [true, false]);
        let stored = directions.map(|texture| SampledDirections::from_texture(&texture)).transpose()?;
        let made = Self::new(FlatBtfDecoder::new(FlatBtfParts { relief, reflectance }))?;
        // Triangulations may differ if more than three points are on a circle; the stored ones are used.
        let counts = |some: &SampledDirections| [some.views.directions(), some.lights.directions()];
        let [found, allowed] = [&stored, &made.directions].map(|some| some.as_ref().map(counts));
        if found != allowed {
            let summary = |counts: Option<[usize; 2]>| match counts {
                Some([views, lights]) => format!("meshes of {views} views and {lights} lights"),
                None => "no meshes".to_owned(),
            };
            return Err(FormatError::whole(DIRECTIONS, summary(found), summary(allowed)));
        }
        let read = Self { directions: stored, report, ..made };
        file.check_same(&read.bindings())?;
        Ok(read)
    }
}

/// An image that a file must have.
fn image(file: &mut PackFile, name: &'static str) -> Result<Texture, FormatError> {
    file.take_texture(name).ok_or_else(|| FormatError::whole(name, "no texels", "texels of a flat BTF").problem())
}

/// Error of a file with the headers of two forms.
fn both(part: &'static str, [a, b]: [&str; 2]) -> FormatError {
    FormatError::whole(part, format!("both {a} and {b}"), format!("either {a} or {b}"))
}

/// Reads the relief of a file.
fn relief(file: &mut PackFile) -> Result<Relief, FormatError> {
    match [LAYERS, VDIM].map(|key| file.entries.contains_key(key)) {
        [_, false] => {
            let heights = image(file, HEIGHTS)?;
            Ok(LayerMap::from_textures(heights, &image(file, DISPLACEMENTS)?)?.into())
        }
        [false, true] => {
            let (packed, reference) = (image(file, INDIRECTION)?, image(file, REFERENCE)?);
            let shared = |file: &mut PackFile| Ok([image(file, HEIGHTS)?, image(file, DISPLACEMENTS)?]);
            let map = Vdim::from_textures(&packed, &reference, || shared(file))?;
            let lights = map.header().lights;
            let shadows =
                file.take_texture(SHADOWS).map(|texture| ShadowMap::from_texture(texture, lights)).transpose()?;
            Relief::sampled(map, shadows)
        }
        [true, true] => Err(both("relief", [LAYERS, VDIM])),
    }
}

/// Reads the base and the components of a file.
fn factors(file: &mut PackFile) -> Result<FactoredFlatBtf, FormatError> {
    let weights = WeightMap::from_texture(file.take_own())?;
    let tables = image(file, TABLES)?;
    let basis = file.take_texture(BASIS);
    let residual = file.take_texture(RESIDUAL).map(ResidualMap::from_texture).transpose()?;
    FactoredFlatBtf::new(BasisMap::from_textures(tables, basis.as_ref())?, weights, residual)
}

/// Checks that sampled shadows have the texels of the reflectance, and the lights of its components. Trees have none.
fn check_shadows(FlatBtfParts { relief, reflectance }: &FlatBtfParts) -> Result<(), FormatError> {
    let Some(shadows) = relief.shadows() else { return Ok(()) };
    let StoredReflectance::Factors(factors) = reflectance else {
        let allowed = "none, because trees include shadows";
        return Err(FormatError::whole("part shadows", format!("{} lights", shadows.lights().len()), allowed));
    };
    let header = factors.header();
    let found = [shadows.size(), shadows.levels()];
    if found != [header.size, header.levels] {
        let form = |[size, levels]: [u32; 2]| format!("{levels} levels of {size} x {size}");
        let allowed = format!("{}, as the weights have", form([header.size, header.levels]));
        return Err(FormatError::whole("part shadows", form(found), allowed));
    }
    if header.groups > 0 && header.lights != shadows.lights() {
        let (found, allowed) = ("other lights than the components have", "the same lights");
        return Err(FormatError::whole("part shadows", found, allowed).problem());
    }
    Ok(())
}
