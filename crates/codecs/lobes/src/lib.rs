//! Encoder of lobes: the light that a material reflects from an environment, as a weighted sum of a few look-ups in
//! prefiltered light.
//!
//! Lobes have fixed directions relative to the normal, the mirror direction or the viewer, so that reflections move
//! smoothly with the view; only their weights and sharpness vary with it. Half vectors, not directions, are shifted: a
//! highlight that is round over half vectors becomes narrow across the plane of view at grazing angles by itself.
//!
//! `views` computes the reflected radiance in environments, `candidate` lists possible lobes, `select` chooses and moves
//! them, `system` solves for weights, and `measure` measures the error in other environments.

mod candidate;
mod facts;
mod measure;
mod non_negative;
mod recipe;
mod reflection;
mod select;
mod system;
mod views;

pub use facts::LobesFacts;
pub use measure::RenderingError;
pub use recipe::{DEFAULT_DELTA_E, DEFAULT_FETCHES, LobesRecipe};

use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::container::half;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_formats::lobes::{LobesHeader, LobesPack};
use candidate::Candidate;
use reflection::Resolution;
use select::Selection;
use system::System;
use views::Views;

/// Number of view angles with weights.
const NODES: usize = 24;
/// Random frames in each environment: for the fit, and for the error.
const FRAMES: [usize; 2] = [60, 40];
/// Directions of the integrals: for the fit, and for the error.
const RESOLUTIONS: [Resolution; 2] = [Resolution { rings: 96, azimuths: 64 }, Resolution { rings: 128, azimuths: 72 }];

/// Error of [`encode`].
#[derive(Debug, thiserror::Error)]
pub enum LobesError {
    /// The material is anisotropic.
    #[error("the material is anisotropic, expected an isotropic one for lobes")]
    Anisotropic,
    /// A number of the recipe, or a weight, is out of range.
    #[error(transparent)]
    Invalid(#[from] FormatError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A pack with a number of lobes that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct LobesTrial {
    /// The pack.
    pub pack: LobesPack,
    /// Its error in environments that the fit did not use.
    pub error: RenderingError,
    /// True if the error is within the limit of the recipe.
    pub meets: bool,
}

/// Lobes of a material.
#[derive(Debug, Clone)]
pub struct EncodedLobes {
    /// Packs in the order in which they were tried, from few lobes to many.
    pub trials: Vec<LobesTrial>,
    /// Number of the selected one.
    pub selected: usize,
    /// Repairs of the source's values.
    pub tally: Tally,
}

impl EncodedLobes {
    /// The selected pack and its error.
    pub fn best(&self) -> &LobesTrial {
        &self.trials[self.selected]
    }
}

/// Environments of the fit, and others for the measured error.
#[derive(Debug, Clone)]
pub struct Environments {
    /// Environments of the fit, all with the same side.
    pub training: Vec<EnvironmentDecoder>,
    /// Environments of the error.
    pub held_out: Vec<EnvironmentDecoder>,
}

/// Checks a source and a recipe, which is much faster than the environments of the fit.
///
/// # Errors
/// Returns an error for anisotropic sources, and for a recipe out of range.
pub fn check(source: &dyn Source, recipe: &LobesRecipe) -> Result<(), LobesError> {
    recipe.check()?;
    if source.symmetry().isotropic { Ok(()) } else { Err(LobesError::Anisotropic) }
}

/// Fits lobes to an isotropic source. The result does not depend on the number of threads.
///
/// # Errors
/// Returns the errors of [`check`], and an error if the work was cancelled.
///
/// # Panics
/// Panics if there are no environments.
pub fn encode(
    source: &dyn Source,
    environments: &Environments,
    recipe: &LobesRecipe,
    progress: &dyn Progress,
) -> Result<EncodedLobes, LobesError> {
    check(source, recipe)?;
    let counts = recipe.counts();
    progress.stage(Stage::Lobes, counts.len() + 2)?;
    let mut tally = Tally::default();
    let nodes: Vec<f64> = (0..NODES).map(|node| node as f64 / (NODES - 1) as f64).collect();
    let training = Views::new(source, &environments.training, &nodes, FRAMES[0], RESOLUTIONS[0], &mut tally);
    progress.step()?;
    // Between the nodes, where weights are interpolated.
    let between: Vec<f64> = nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let held_out = Views::new(source, &environments.held_out, &between, FRAMES[1], RESOLUTIONS[1], &mut tally);
    progress.step()?;
    let sharpest = environments.training[0].header().sharpest();
    // A black material has no width; its lobe has no weight.
    let mut selection = Selection::new(&training, training.width.unwrap_or(1.0), sharpest);
    let mut trials: Vec<LobesTrial> = Vec::new();
    for count in counts {
        selection.grow(count);
        progress.step()?;
        let pack = assembled(&selection.system, &training)?;
        if trials.last().is_some_and(|last| last.pack == pack) {
            break;
        }
        let error = measure::rendering_error(&pack, &held_out);
        let meets = recipe.max_delta_e.is_none_or(|most| error.mean <= most);
        trials.push(LobesTrial { pack, error, meets });
        if meets && recipe.max_delta_e.is_some() {
            break;
        }
    }
    let best = |at: &usize| (!trials[*at].meets, trials[*at].error.mean);
    let order = |a: &usize, b: &usize| best(a).0.cmp(&best(b).0).then(best(a).1.total_cmp(&best(b).1));
    let selected = (0..trials.len()).min_by(order).unwrap_or(0);
    Ok(EncodedLobes { trials, selected, tally })
}

/// Pack of a system. Weights are scaled down where they would reflect more of uniform light than the material.
fn assembled(system: &System, views: &Views<'_>) -> Result<LobesPack, FormatError> {
    let mut rows: Vec<(Candidate, Vec<[f64; 3]>)> =
        system.candidates.iter().enumerate().map(|(at, one)| (*one, system.weights(at).collect())).collect();
    if rows.is_empty() {
        rows.push((Candidate::IRRADIANCE, vec![[0.0; 3]; views.views.len()]));
    }
    let mut texels = vec![[0.0; 4]; rows.len() * views.views.len()];
    for (node, view) in views.views.iter().enumerate() {
        let sum = |k: usize| rows.iter().map(|(one, weights)| one.fetches() as f64 * weights[node][k]).sum::<f64>();
        let scale = [0, 1, 2].map(|k| if sum(k) > view.albedo[k] { view.albedo[k] / sum(k) } else { 1.0 });
        for (row, (one, weights)) in rows.iter().enumerate() {
            let [r, g, b] = [0, 1, 2].map(|k| ((weights[node][k] * scale[k]) as f32).min(half::MAX));
            texels[row * views.views.len() + node] = [r, g, b, one.sharpness_at(view.outgoing[2])];
        }
    }
    let lobes = rows.iter().zip(0..).flat_map(|((one, _), row)| one.lobes(row)).collect();
    LobesPack::new(LobesHeader { nodes: NODES as u32, rows: rows.len() as u32, lobes }, &texels)
}
