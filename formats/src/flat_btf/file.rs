//! File of a flat BTF: shader bindings, headers of the images, and the visibility mask.

use super::decoder::{FlatBtfDecoder, FlatBtfParts, FlatValues, Indirection};
use super::directions::SampledDirections;
use super::factored::{BasisMap, FACTORED_ENTRY, FactoredFlatBtf, ShadowMap, WeightMap};
use super::flat_view::VisibilityMask;
use super::shader::{BASIS, DIRECTIONS, NORMAL, PACKED, RANGES, REFERENCE, SHADOW, WEIGHTS};
use super::{DISPLACEMENT_ENTRY, DisplacementMap, IndirectionMap, NormalMap, ReferenceMap, maps::DiffuseMap};
use crate::FormatError;
use crate::bindings::{Bindings, PackFile};
use std::collections::BTreeMap;

/// Key of the visibility mask, a KTX2 file. Shaders do not read it.
const MASK: &str = "brdfc.flat-btf.mask";
/// Key of the encoder's report: settings and measured errors, JSON.
const REPORT: &str = "brdfc.flat-btf.report";

/// A flat BTF as stored in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfFile {
    /// Decoder with the parts of the asset.
    pub decoder: FlatBtfDecoder,
    /// Meshes that interpolate sampled views and lights; `None` for the light form.
    pub directions: Option<SampledDirections>,
    /// Texels visible in each view, if the file has the mask.
    pub mask: Option<VisibilityMask>,
    /// Report of the encoder, as JSON text; empty if there is none.
    pub report: String,
}

impl FlatBtfFile {
    /// Creates a file from a decoder and an optional mask, without a report.
    ///
    /// # Errors
    /// Returns an error if the values are uncompressed views, which files cannot hold, if views or lights cannot be
    /// interpolated, or if the mask has another size.
    pub fn new(decoder: FlatBtfDecoder, mask: Option<VisibilityMask>) -> Result<Self, FormatError> {
        let values = &decoder.parts().values;
        if let FlatValues::Views(views) = values {
            let found = format!("{} uncompressed views", views.len());
            return Err(FormatError::whole("values of a flat BTF", found, "factored values, or the light form"));
        }
        let directions = SampledDirections::of(values)?;
        let file = Self { decoder, directions, mask, report: String::new() };
        file.check_mask()?;
        Ok(file)
    }

    fn check_mask(&self) -> Result<(), FormatError> {
        let Some(mask) = &self.mask else { return Ok(()) };
        let parts = self.decoder.parts();
        let views = parts.values.directions().map(|[views, _]| views.len() as u32);
        if mask.size() == parts.diffuse.size() && views.is_none_or(|views| views == mask.views()) {
            return Ok(());
        }
        let found = format!("{0} x {0} texels of {1} views", mask.size(), mask.views());
        let allowed = format!("{0} x {0} texels of each view", parts.diffuse.size());
        Err(FormatError::whole(MASK, found, allowed))
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let parts = self.decoder.parts();
        let mut entries = BTreeMap::from([match &parts.indirection {
            Indirection::Samples(map) => map.entry(),
            Indirection::Compact(map) => map.entry(),
        }]);
        if let Some(asset) = parts.values.factored() {
            entries.extend(asset.basis().header().entries());
            entries.extend([asset.weights().entry()]);
            entries.extend(asset.shadow().map(ShadowMap::entry));
        }
        entries.extend(self.mask.as_ref().map(|mask| (MASK.to_owned(), mask.to_bytes())));
        if !self.report.is_empty() {
            entries.insert(REPORT.to_owned(), self.report.clone().into_bytes());
        }
        self.bindings().to_file(entries, supercompress)
    }

    /// Bindings of the file's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        self.decoder.bindings(true, self.directions.as_ref())
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
        let mask = file.entries.remove(MASK).map(|bytes| read_mask(&bytes)).transpose()?;
        let diffuse = DiffuseMap::from_texture(&file.take_own())?;
        let mut image = |name: &'static str| {
            let texture = file.take_texture(name);
            move || texture.ok_or_else(|| FormatError::whole(name, "no texels", "texels of a flat BTF").problem())
        };
        let (reference, packed, normal) = (image(REFERENCE)()?, image(PACKED)()?, image(NORMAL)()?);
        let (ranges, directions) = (image(RANGES), image(DIRECTIONS));
        let indirection: Indirection = if packed.entries.contains_key(DISPLACEMENT_ENTRY) {
            DisplacementMap::from_textures(&packed, &ranges()?)?.into()
        } else {
            IndirectionMap::from_texture(&packed)?.into()
        };
        let values = if packed.entries.contains_key(FACTORED_ENTRY) {
            let (basis, weights, shadow) = (image(BASIS)()?, image(WEIGHTS)()?, image(SHADOW)().ok());
            let shadow = shadow.map(ShadowMap::from_texture).transpose()?;
            let asset =
                FactoredFlatBtf::new(BasisMap::from_texture(&basis)?, WeightMap::from_texture(weights)?, shadow)?;
            FlatValues::Factored(Box::new(asset))
        } else {
            FlatValues::None
        };
        let stored = directions().ok().map(|texture| SampledDirections::from_texture(&texture)).transpose()?;
        let reference = ReferenceMap::from_texture(&reference)?;
        let parts = FlatBtfParts { reference, indirection, normal: NormalMap::from_texture(&normal)?, diffuse, values };
        let made = Self::new(FlatBtfDecoder::new(parts)?, mask)?;
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

fn read_mask(bytes: &[u8]) -> Result<VisibilityMask, FormatError> {
    VisibilityMask::from_bytes(bytes)
        .map_err(|error| FormatError { field: format!("{MASK}, {}", error.field).into(), ..error })
}
