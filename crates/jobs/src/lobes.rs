//! Lobes of materials: `brdfc encode --codec lobes`.

use crate::Error;
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_environment::training::{KINDS, TrainingEnvironment};
use brdfc_environment::{PrefilterError, prefilter};
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_lobes::{EncodedLobes, Environments, LobesError, LobesRecipe, encode};
use std::sync::OnceLock;

/// Name of the codec.
pub const CODEC: &str = "lobes";
/// Texels along each side of a face of an environment that lobes are fitted to.
const SIDE: u32 = 256;
/// First seed of the environments whose error is measured; the fit has the seeds from 0.
const HELD_OUT: u64 = 100;

/// Fits lobes to a material. All materials of a process share the environments.
///
/// # Errors
/// Returns an error for a recipe out of range, and if the work was cancelled.
pub fn encode_lobes(source: &dyn Source, recipe: &LobesRecipe, progress: &dyn Progress) -> Result<EncodedLobes, Error> {
    static ENVIRONMENTS: OnceLock<Environments> = OnceLock::new();
    // Before the environments, which take seconds.
    recipe.check().map_err(Error::usage)?;
    let environments = match ENVIRONMENTS.get() {
        Some(environments) => environments,
        None => {
            let made = environments(progress)?;
            ENVIRONMENTS.get_or_init(|| made)
        }
    };
    Ok(encode(source, environments, recipe, progress)?)
}

/// One environment of each kind for the fit, and one for the error.
fn environments(progress: &dyn Progress) -> Result<Environments, Error> {
    let decoder = |seed: u64| -> Result<EnvironmentDecoder, Error> {
        let environment = TrainingEnvironment::new(seed);
        let pack = prefilter(&|direction| environment.radiance(direction), SIDE, 1, progress)?;
        Ok(EnvironmentDecoder::new(&pack))
    };
    let from = |first: u64| (first..first + KINDS).map(decoder).collect::<Result<Vec<_>, _>>();
    Ok(Environments { training: from(0)?, held_out: from(HELD_OUT)? })
}

impl From<LobesError> for Error {
    fn from(error: LobesError) -> Self {
        match error {
            LobesError::Cancelled(cancelled) => cancelled.into(),
            LobesError::Invalid(error) => Self::own_layout(error),
        }
    }
}

impl From<PrefilterError> for Error {
    fn from(error: PrefilterError) -> Self {
        match error {
            PrefilterError::Cancelled(cancelled) => cancelled.into(),
            PrefilterError::Invalid(error) => Self::input(error),
        }
    }
}
