//! Methods to show a relief, next to the surface itself: layers, a height field, a normal map, the sampled indirections
//! of Hadim et al. 2009, and bounds.

#[cfg(feature = "render")]
mod frames;
mod methods;
mod renderings;
mod rows;
mod shadows;
mod sheet;

#[cfg(feature = "render")]
pub use frames::{ReliefFrame, ReliefFrames, relief_frames};
pub use rows::{AngleRow, MethodRow, ObjectRow, ReliefRow, ReliefSettings, RenderingRow};

use brdfc_core::address::AddressError;
use brdfc_flat_btf::encode::{
    EncodeError, FlatBtfEncoded, FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ReliefForm, ValueSource,
    VdimRecipe, encode,
};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile};
use brdfc_render::rendering::Panel;
use methods::Methods;
use renderings::{Renderings, Surface};
use std::convert::Infallible;

/// Sampled indirections, with as many views as in the study `flat-btf`.
const VDIM: VdimRecipe = VdimRecipe {
    polar_angles: 16,
    azimuth_rows: 25,
    largest_angle: 80.0,
    oversampling: 2,
    shadows: true,
    compact: false,
};

/// A structure that is encoded in several ways, with the same reflectance.
struct Encoder {
    structure: Structure,
    appearance: Appearance,
    /// Texels of all maps per side, except of heights.
    texels: u32,
}

impl Encoder {
    fn new(address: &str, texels: u32) -> Result<Self, AddressError> {
        let structure = Structure::parse(address)?;
        Ok(Self { appearance: structure.appearance(), structure, texels })
    }

    /// Encodes with layers.
    fn layers(&self) -> Result<FlatBtfEncoded, EncodeError<Infallible>> {
        // The displacements then have as many texels as the other maps, and only the heights twice as many per side.
        self.encoded(ReliefForm::Layers, 2 * self.texels)
    }

    /// Encodes with an indirection map, as it is read from its file.
    fn sampled(&self, vdim: VdimRecipe) -> Result<FlatBtfDecoder, EncodeError<Infallible>> {
        let decoder = self.encoded(ReliefForm::Vdim(vdim), self.texels)?.decoder;
        Ok(FlatBtfFile::from_bytes(&FlatBtfFile::new(decoder)?.to_bytes(false))?.decoder)
    }

    fn encoded(&self, relief: ReliefForm, texels: u32) -> Result<FlatBtfEncoded, EncodeError<Infallible>> {
        let recipe = FlattenRecipe {
            texels,
            relief,
            flat_texels: self.texels as usize,
            views: DirectionSet::ubo2003(),
            lights: DirectionSet::ubo2003(),
            fill: FillMethod::Poisson,
            bounces: 0,
            reflectance: Reflectance::Brdf,
            target: FactoredTarget::Error(0.0),
        };
        let values = ValueSource::Computed(&self.appearance);
        let input = FlatInput { mesh: self.structure.mesh(), repairs: None, values };
        encode(input, &recipe, &MemoryScratch::default(), &())
    }
}

/// Errors of the study.
#[derive(Debug, thiserror::Error)]
pub enum ReliefError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The surface cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError<Infallible>),
    /// The adapter cannot draw it.
    #[cfg(feature = "render")]
    #[error(transparent)]
    Gpu(#[from] brdfc_gpu::GpuError),
}

/// Calls of `done` by [`relief_study`], with and without a sheet.
pub fn steps(with_sheet: bool) -> usize {
    Renderings::COUNT + methods::COUNT + 1 + if with_sheet { sheet::COUNT } else { 0 }
}

/// Compares the methods on one structure; on request draws a contact sheet of layers and surface. Calls `done` after
/// each step.
///
/// # Errors
/// Returns an error for a wrong address, or a surface that cannot be encoded.
pub fn relief_study(
    address: &str,
    settings: &ReliefSettings,
    with_sheet: bool,
    done: &dyn Fn(),
) -> Result<(ReliefRow, Option<Panel>), ReliefError> {
    let encoder = Encoder::new(address, settings.texels)?;
    let FlatBtfEncoded { decoder, model, .. } = encoder.layers()?;
    let sampled = encoder.sampled(VDIM)?;
    let methods = Methods::new(&model, &decoder, &sampled);
    done();
    let surface = Surface { model: &model, appearance: &encoder.appearance };
    let sheet = with_sheet.then(|| sheet::sheet(surface, &methods.layers(), done));
    let renderings = Renderings::new(surface, settings.pixels, done);
    let row = |method| {
        let row = renderings.row(&method);
        done();
        row
    };
    let row = ReliefRow { model: encoder.structure.canonical(), methods: methods.all().into_iter().map(row).collect() };
    Ok((row, sheet))
}
