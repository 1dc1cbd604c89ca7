//! File of a flat BTF: shader bindings, and headers of the images.

use super::decoder::FlatBtfDecoder;
use super::directions::SampledDirections;
use super::factored::{BasisMap, FactoredFlatBtf, ResidualMap, WeightMap};
use super::layers::{LAYERS, LayerMap};
use super::relief::{FlatBtfParts, Relief};
use super::shader::{BASIS, DIRECTIONS, DISPLACEMENTS, HEIGHTS, INDIRECTION, REFERENCE, RESIDUAL, SHADOWS, TABLES};
use super::shadows::ShadowMap;
use super::vdim::Vdim;
use super::vdim_header::VDIM;
use crate::FormatError;
use crate::bindings::{Bindings, PackFile};

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
        let mut entries = reflectance.basis().header().entries();
        entries.extend(match relief {
            Relief::Layers(layers) => vec![layers.entry()],
            Relief::Vdim(map, shadows) => {
                map.entries().into_iter().chain(shadows.as_ref().map(ShadowMap::entry)).collect()
            }
        });
        entries.extend([reflectance.weights().entry()]);
        entries.extend(reflectance.residual().map(ResidualMap::entry));
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
        let weights = WeightMap::from_texture(file.take_own())?;
        let form = [LAYERS, VDIM].map(|key| file.entries.contains_key(key));
        let mut image = |name: &'static str| {
            let texture = file.take_texture(name);
            move || texture.ok_or_else(|| FormatError::whole(name, "no texels", "texels of a flat BTF").problem())
        };
        let relief = match form {
            [_, false] => LayerMap::from_textures(image(HEIGHTS)()?, &image(DISPLACEMENTS)()?)?.into(),
            [false, true] => {
                let (packed, reference) = (image(INDIRECTION)()?, image(REFERENCE)()?);
                let map =
                    Vdim::from_textures(&packed, &reference, || Ok([image(HEIGHTS)()?, image(DISPLACEMENTS)()?]))?;
                let lights = map.header().lights;
                let shadows =
                    image(SHADOWS)().ok().map(|texture| ShadowMap::from_texture(texture, lights)).transpose()?;
                Relief::sampled(map, shadows)?
            }
            [true, true] => {
                let allowed = format!("either {LAYERS} or {VDIM}");
                return Err(FormatError::whole("relief", format!("both {LAYERS} and {VDIM}"), allowed));
            }
        };
        let tables = image(TABLES)()?;
        let basis = image(BASIS)().ok();
        let residual = image(RESIDUAL)().ok().map(ResidualMap::from_texture).transpose()?;
        let stored = image(DIRECTIONS)().ok().map(|texture| SampledDirections::from_texture(&texture)).transpose()?;
        let reflectance = FactoredFlatBtf::new(BasisMap::from_textures(tables, basis.as_ref())?, weights, residual)?;
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

/// Checks that sampled shadows have the texels of the reflectance, and the lights of its components.
fn check_shadows(FlatBtfParts { relief, reflectance }: &FlatBtfParts) -> Result<(), FormatError> {
    let (Some(shadows), header) = (relief.shadows(), reflectance.header()) else { return Ok(()) };
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
