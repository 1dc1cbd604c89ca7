//! Methods to show a relief, next to the surface itself: layers, a height field, a normal map, the sampled indirections
//! of Hadim et al. 2009, and bounds.

mod methods;
mod renderings;
mod rows;
mod shadows;

pub use rows::{AngleRow, MethodRow, ObjectRow, ReliefRow, ReliefSettings, RenderingRow};

use brdfc_core::address::{AddressError, parse_synth};
use brdfc_flat_btf::encode::{
    EncodeError, FlatBtfEncoded, FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ValueSource, encode,
};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::direction_set::DirectionSet;
use methods::Methods;
use renderings::Renderings;
use std::convert::Infallible;

/// Errors of the study.
#[derive(Debug, thiserror::Error)]
pub enum ReliefError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The surface cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError<Infallible>),
}

/// Calls of `done` by [`relief_study`].
pub const STEPS: usize = Renderings::COUNT + methods::COUNT + 1;

/// Compares the methods on one structure. Calls `done` after each step.
///
/// # Errors
/// Returns an error for a wrong address, or a surface that cannot be encoded.
pub fn relief_study(address: &str, settings: &ReliefSettings, done: &dyn Fn()) -> Result<ReliefRow, ReliefError> {
    let structure = Structure::parse(address)?;
    let sources = structure.default_materials().iter().map(|m| parse_synth(m)).collect::<Result<_, _>>()?;
    let appearance = Appearance { sources, ..Appearance::default() };
    let recipe = FlattenRecipe {
        texels: settings.texels,
        flat_texels: settings.texels as usize,
        views: DirectionSet::ubo2003(),
        lights: DirectionSet::ubo2003(),
        fill: FillMethod::Poisson,
        bounces: 0,
        reflectance: Reflectance::Brdf,
        target: FactoredTarget::Error(0.0),
    };
    let input = FlatInput { mesh: structure.mesh(), repairs: None, values: ValueSource::Computed(&appearance) };
    let FlatBtfEncoded { decoder, model, .. } = encode(input, &recipe, &MemoryScratch::default(), &())?;
    let methods = Methods::new(&model, &decoder, settings);
    done();
    let renderings = Renderings::new(&model, &appearance, settings.pixels, done);
    let row = |method| {
        let row = renderings.row(&method);
        done();
        row
    };
    Ok(ReliefRow { model: structure.canonical(), methods: methods.all().into_iter().map(row).collect() })
}
