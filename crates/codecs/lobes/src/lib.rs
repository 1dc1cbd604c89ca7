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
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use brdfc_formats::lobes::{LobesHeader, LobesPack, MAX_SCALE, MAX_SHARPNESS};
use candidate::{Candidate, Place};
use reflection::Resolution;
use select::Selection;
use system::System;
use views::Views;

/// Views of a material.
#[derive(Debug, Clone, Copy)]
struct Grid {
    /// Number of view angles with weights.
    nodes: usize,
    /// Number of view azimuths with weights.
    azimuths: usize,
    /// Random frames in each environment: for the fit, and for the error.
    frames: [usize; 2],
}

const ISOTROPIC: Grid = Grid { nodes: 24, azimuths: 1, frames: [60, 40] };
/// Four times the views in half the frames.
const ANISOTROPIC: Grid = Grid { nodes: 12, azimuths: 8, frames: [30, 20] };
/// Directions of the integrals: for the fit, and for the error.
const RESOLUTIONS: [Resolution; 2] = [Resolution { rings: 96, azimuths: 64 }, Resolution { rings: 128, azimuths: 72 }];

/// Error of [`encode`].
#[derive(Debug, thiserror::Error)]
pub enum LobesError {
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

/// Fits lobes to a source. The result does not depend on the number of threads.
///
/// # Errors
/// Returns an error for a recipe out of range, and if the work was cancelled.
///
/// # Panics
/// Panics if there are no environments.
pub fn encode(
    source: &dyn Source,
    environments: &Environments,
    recipe: &LobesRecipe,
    progress: &dyn Progress,
) -> Result<EncodedLobes, LobesError> {
    recipe.check()?;
    let counts = recipe.counts();
    progress.stage(Stage::Lobes, counts.len() + 2)?;
    let mut tally = Tally::default();
    let grid = if source.symmetry().isotropic { ISOTROPIC } else { ANISOTROPIC };
    let [frames, other_frames] = grid.frames;
    let training = Views::new(source, &environments.training, &grid.places(), frames, RESOLUTIONS[0], &mut tally);
    progress.step()?;
    let between = grid.between();
    let held_out = Views::new(source, &environments.held_out, &between, other_frames, RESOLUTIONS[1], &mut tally);
    progress.step()?;
    let sharpest = environments.training[0].header().sharpest();
    let candidates = match (grid.azimuths, training.width, &training.slopes) {
        (1, Some(width), _) => Candidate::isotropic(width, sharpest),
        (_, _, Some(slopes)) => Candidate::anisotropic(slopes, sharpest),
        // A black material has no width; its lobe has no weight.
        _ => vec![grid.irradiance()],
    };
    let mut selection = Selection::new(&training, candidates, sharpest);
    let mut trials: Vec<LobesTrial> = Vec::new();
    let mut last: Option<LobesPack> = None;
    for count in counts {
        selection.grow(count);
        progress.step()?;
        let pack = assembled(grid, &selection.system, &training, f64::from(sharpest))?;
        if last.as_ref() == Some(&pack) {
            // With more look-ups, a pair may fit.
            continue;
        }
        last = Some(pack.clone());
        let error = measure::rendering_error(&pack, &held_out);
        let pack = pack.with_delta_e([error.mean, error.p95].map(|delta_e| delta_e as f32))?;
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

impl Grid {
    /// Positions and azimuths of the weights, in the order of a pack.
    fn places(&self) -> Vec<[f64; 2]> {
        let node = |node: usize| node as f64 / (self.nodes - 1) as f64;
        let place = |azimuth: usize, at: usize| match at {
            // Above the normal there is only one view, and one set of weights.
            0 => [0.0, 0.0],
            _ => [node(at), azimuth as f64 / self.azimuths as f64],
        };
        (0..self.azimuths).flat_map(|azimuth| (0..self.nodes).map(move |at| place(azimuth, at))).collect()
    }

    /// Positions and azimuths between those of the weights, which are interpolated there.
    fn between(&self) -> Vec<[f64; 2]> {
        let step = |count: usize, at: usize| (at as f64 + 0.5) / count as f64;
        let [azimuths, nodes] = [self.azimuths, self.nodes - 1];
        (0..azimuths).flat_map(|azimuth| (0..nodes).map(move |at| [step(nodes, at), step(azimuths, azimuth)])).collect()
    }

    /// The irradiance as a candidate.
    fn irradiance(&self) -> Candidate {
        Candidate::irradiance(if self.azimuths == 1 { Place::InPlane } else { Place::OnSurface })
    }
}

/// Scale of weights up to `largest`: the next larger power of two, so that half floats round materials of all magnitudes alike. By
/// the bits of the exponent, because logarithms differ between platforms.
fn scale_of(largest: f32) -> f32 {
    const EXPONENT: u32 = 0x7f80_0000;
    let power = f32::from_bits(largest.to_bits() & EXPONENT);
    if largest > 0.0 { (2.0 * power).clamp(1.0 / MAX_SCALE, MAX_SCALE) } else { 1.0 }
}

/// Pack of a system. Weights are scaled down where they would reflect more of uniform light than the material.
///
/// The fit cannot distinguish sharpnesses from that of the finest level on. There a lobe takes that of the material's
/// highlight, for environments with finer levels.
fn assembled(grid: Grid, system: &System, views: &Views<'_>, sharpest: f64) -> Result<LobesPack, FormatError> {
    let own = views.width.map_or(sharpest, EnvironmentHeader::sharpness).clamp(sharpest, f64::from(MAX_SHARPNESS));
    let stored = |sharpness: f32| if f64::from(sharpness) < sharpest { sharpness } else { own as f32 };
    let mut rows: Vec<(Candidate, Vec<[f64; 3]>)> =
        system.candidates.iter().enumerate().map(|(at, one)| (*one, system.weights(at).collect())).collect();
    if rows.is_empty() {
        rows.push((grid.irradiance(), vec![[0.0; 3]; views.views.len()]));
    }
    let mut texels = vec![[0.0; 4]; rows.len() * views.views.len()];
    for (at, view) in views.views.iter().enumerate() {
        let sum = |k: usize| rows.iter().map(|(one, weights)| one.fetches() as f64 * weights[at][k]).sum::<f64>();
        let scale = [0, 1, 2].map(|k| if sum(k) > view.albedo[k] { view.albedo[k] / sum(k) } else { 1.0 });
        for (row, (one, weights)) in rows.iter().enumerate() {
            let [r, g, b] = [0, 1, 2].map(|k| (weights[at][k] * scale[k]) as f32);
            texels[row * views.views.len() + at] = [r, g, b, stored(one.sharpness_at(view.outgoing[2]))];
        }
    }
    let largest = texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).fold(0.0, f32::max);
    let scale = scale_of(largest);
    for [r, g, b, _] in &mut texels {
        [r, g, b].into_iter().for_each(|c| *c = (*c / scale).min(half::MAX));
    }
    let lobes = rows.iter().zip(0..).flat_map(|((one, _), row)| one.lobes(row)).collect();
    let [nodes, azimuths] = [grid.nodes, grid.azimuths].map(|count| count as u32);
    LobesPack::new(LobesHeader { nodes, azimuths, rows: rows.len() as u32, scale, delta_e: [0.0; 2], lobes }, &texels)
}
