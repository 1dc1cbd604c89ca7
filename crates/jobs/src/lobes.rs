//! Lobes of materials: `brdfc encode --codec lobes`, and builds of scenes with an environment.

use crate::Error;
use crate::encode::{Budget, OptionError};
use brdfc_core::Source;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::words::{counted, format_number};
use brdfc_environment::training::{KINDS, TrainingEnvironment};
use brdfc_environment::{PrefilterError, prefilter};
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_formats::lobes::MAX_LOBES;
use brdfc_lobes::{DEFAULT_DELTA_E, DEFAULT_FETCHES, EncodedLobes, Environments, LobesError, LobesRecipe, encode};
use rayon::ThreadPoolBuilder;
use std::sync::{Arc, Mutex, PoisonError};

/// Name of the codec.
pub const CODEC: &str = "lobes";
/// Texels along each side of a face of an environment that lobes are fitted to.
const SIDE: u32 = 256;
/// First seed of the environments whose error is measured; the fit has the seeds from 0.
const HELD_OUT: u64 = 100;

/// Resolves a recipe from limits, by default a ΔE of 1. With look-ups alone, the error is as small as possible.
///
/// # Errors
/// Returns an error for a limit out of range.
pub fn recipe(max_delta_e: Option<f64>, max_fetches: Option<u32>) -> Result<LobesRecipe, OptionError> {
    Budget::checked(max_delta_e, None, None, None, None)?;
    let by_default = max_fetches.is_none().then_some(DEFAULT_DELTA_E);
    let max_fetches = max_fetches.map_or(DEFAULT_FETCHES, |fetches| fetches as usize);
    if !(1..=MAX_LOBES).contains(&max_fetches) {
        return Err(OptionError::new("max_fetches", max_fetches.to_string(), format!("1 to {MAX_LOBES} for lobes")));
    }
    Ok(LobesRecipe { max_fetches, max_delta_e: max_delta_e.or(by_default) })
}

/// The limit that the selected lobes miss, if any.
pub fn missed(encoded: &EncodedLobes, recipe: &LobesRecipe) -> Option<String> {
    let best = encoded.best();
    let limit = recipe.max_delta_e.filter(|_| !best.meets)?;
    let (found, fetches, limit) = (best.error.mean, counted(best.pack.fetches(), "look-up"), format_number(limit));
    Some(format!("found a ΔE of {found:.2} with {fetches}, expected at most {limit}"))
}

/// Fits lobes to a material. All materials of a process share the environments.
///
/// # Errors
/// Returns an error for a recipe out of range, and if the work was cancelled.
pub fn encode_lobes(
    source: &dyn Source,
    recipe: &LobesRecipe,
    progress: &dyn Progress,
) -> Result<EncodedLobes, LobesError> {
    // Before the environments, which take seconds.
    recipe.check()?;
    let environments = shared_environments(progress).map_err(|error| match error {
        PrefilterError::Cancelled(cancelled) => LobesError::Cancelled(cancelled),
        PrefilterError::Invalid(error) => LobesError::Invalid(error),
    })?;
    encode(source, &environments, recipe, progress)
}

/// The environments of this process. The first caller makes them, and the others wait.
fn shared_environments(progress: &dyn Progress) -> Result<Arc<Environments>, PrefilterError> {
    static ENVIRONMENTS: Mutex<Option<Arc<Environments>>> = Mutex::new(None);
    let mut shared = ENVIRONMENTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(environments) = &*shared {
        return Ok(environments.clone());
    }
    // In threads of their own: a thread of this pool that waits for part of a loop could start another material, which
    // would wait for the lock that it holds itself.
    let made = match ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build() {
        Ok(pool) => std::thread::scope(|scope| {
            let made = scope.spawn(|| pool.install(|| environments(progress))).join();
            made.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        }),
        Err(_) => environments(progress),
    };
    Ok(shared.insert(Arc::new(made?)).clone())
}

/// Progress of one of several environments, which are a single stage.
struct OneStage<'a>(&'a dyn Progress);

impl Progress for OneStage<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        self.0.check()
    }

    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(OneStage(self.0))
    }
}

/// One environment of each kind for the fit, and one for the error.
fn environments(progress: &dyn Progress) -> Result<Environments, PrefilterError> {
    progress.stage(Stage::Prefilter, 2 * KINDS as usize)?;
    let decoder = |seed: u64| -> Result<EnvironmentDecoder, PrefilterError> {
        let environment = TrainingEnvironment::new(seed);
        let pack = prefilter(&|direction| environment.radiance(direction), SIDE, 1, &OneStage(progress))?;
        progress.step()?;
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
