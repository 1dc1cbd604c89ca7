//! Searches the number of terms and their arrangement for a pack that meets a target.

use crate::assemble::{Arrangement, CHANNELS, Limits, arrangements};
use crate::candidates::Candidate;
use crate::levels::TermImages;
use crate::measure::{StackErrors, stack_errors};
use crate::recipe::{PwtRecipe, Target};
use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightMap, PwtDecoder, PwtErrors, PwtHeader, PwtPack, mesh_bytes};

/// Approximate number of texels of all photographs that are compared at the end, and the minimum number of rows as long as they do
/// not have eight times as many.
const COMPARED_TEXELS: usize = 1 << 21;
const MIN_ROWS: usize = 64;
/// Maximum loss of PSNR at the fitted lights, dB, if no larger one is requested.
const MAX_FITTED_LOSS: f64 = 3.0;
/// Maximum share of the error of leaving the finest level out, and the PSNR, dB, from which its absence is invisible.
const MAX_BLUR: f64 = 1.0 / 3.0;
const INVISIBLE: f64 = 45.0;
/// Maximum number of packs that a search for a measured target builds.
const TRIALS: usize = 8;

/// A pack that can be built.
struct Step {
    /// Number of images that it chooses from.
    terms: usize,
    arrangement: Arrangement,
    /// Bytes on a GPU.
    bytes: u64,
    /// Error of all terms: weighted squares.
    error: f64,
}

/// Search for the smallest pack that meets a target.
pub struct Search<'a> {
    samples: &'a LightSamples,
    /// Number of lights that terms were fitted to; terms are orthonormal over them.
    lights: usize,
    images: &'a [TermImages],
    /// Packs of increasing size and decreasing error.
    path: Vec<Step>,
    header: PwtHeader,
    /// The chosen candidate, or that of each number of learned terms.
    candidates: &'a [Candidate],
}

/// A pack that was found.
pub struct Found {
    /// The pack.
    pub pack: PwtPack,
    /// Its errors.
    pub errors: StackErrors,
    /// Errors of its terms before pruning.
    pub candidate: Candidate,
    /// True if the pack meets the target.
    pub met: bool,
}

impl<'a> Search<'a> {
    /// Search over the arrangements of terms that were fitted to `lights` lights. It can leave the last learned terms out,
    /// with their part of the light map, unless their number is requested.
    pub fn new(
        samples: &'a LightSamples,
        lights: usize,
        images: &'a [TermImages],
        header: PwtHeader,
        candidates: &'a [Candidate],
        recipe: &PwtRecipe,
    ) -> Self {
        let bytes = if let Target::Bytes(bytes) = recipe.target { bytes } else { u64::MAX };
        let layers = recipe.max_fetches.unwrap_or(PwtRecipe::MAX_FETCHES) as usize;
        let mesh = header.views.as_ref().map_or(0, mesh_bytes);
        let map = |terms| mesh + header.light_map.as_ref().map_or(0, |map| LightMap::bytes_of(map.side(), terms + 1));
        let is_fixed = header.light_map.is_none() || recipe.degree.is_some();
        let first = if is_fixed { images.len() } else { CHANNELS };
        let mut steps = Vec::new();
        for terms in (first..images.len()).step_by(CHANNELS).chain([images.len()]) {
            let bytes = bytes.saturating_sub(map(terms));
            let limits =
                Limits { extent: header.extent, depth: header.levels, views: header.view_count(), layers, bytes };
            let left_out: f64 = images[terms..].iter().filter_map(|image| image.errors.last()).sum();
            steps.extend(arrangements(&images[..terms], &limits).into_iter().map(|arrangement| {
                let (bytes, error) = (arrangement.bytes(&limits) + map(terms), arrangement.error + left_out);
                Step { terms, arrangement, bytes, error }
            }));
        }
        steps.sort_by(|a, b| a.bytes.cmp(&b.bytes).then(a.error.total_cmp(&b.error)));
        let mut least = None;
        steps.retain(|step| {
            let is_closer = least.is_none_or(|least| step.error < least);
            least = if is_closer { Some(step.error) } else { least };
            is_closer
        });
        if let Target::Bytes(bytes) = recipe.target {
            // The smallest, if all are too large.
            let fitting = steps.iter().filter(|step| step.bytes <= bytes).count();
            steps.truncate(fitting.max(1));
        }
        Self { samples, lights, images, path: steps, header, candidates }
    }

    /// The smallest pack that meets the target, or the closest one.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn run(self, target: Target) -> Result<Found, FormatError> {
        let last = self.path.len() - 1;
        let first_below = |error: f64| self.path.iter().position(|step| step.error <= error);
        match target {
            // The path ends there.
            Target::Bytes(bytes) => {
                let found = self.found(last)?;
                Ok(Found { met: found.pack.gpu_bytes() <= bytes, ..found })
            }
            Target::Energy(share) => {
                let step = first_below((1.0 - share) * self.path[0].error);
                Ok(Found { met: step.is_some(), ..self.found(step.unwrap_or(last))? })
            }
            Target::Loss(loss) => {
                // Truncation adds to the error at held-out lights. Where these cannot be predicted, that at the fitted ones counts.
                let Candidate { psnr, held_out_psnr, .. } = self.candidate(u32::MAX);
                let added = |psnr: f64, loss: f64| (10f64.powf(loss / 10.0) - 1.0) * 10f64.powf(-psnr / 10.0);
                let added = added(held_out_psnr.unwrap_or(psnr), loss).min(added(psnr, loss.max(MAX_FITTED_LOSS)));
                let numbers = (3 * self.samples.defined_texels() * self.lights) as f64;
                let added =
                    if loss < MAX_FITTED_LOSS { (added * numbers).min(self.blur(numbers)) } else { added * numbers };
                self.found(first_below(added + self.path[last].error).unwrap_or(last))
            }
            Target::Quality(psnr) => self.measured(|errors| errors.psnr >= psnr),
            Target::DeltaE(delta_e) => self.measured(|errors| errors.delta_e <= delta_e),
        }
    }

    /// Candidate with so many terms, or with all of them.
    fn candidate(&self, terms: u32) -> Candidate {
        let with_terms = self.candidates.iter().find(|candidate| candidate.degree == terms);
        *with_terms.or(self.candidates.last()).expect("one or more candidates")
    }

    /// Error that would look blurred: highlights that nothing predicts can make all detail seem unimportant.
    fn blur(&self, numbers: f64) -> f64 {
        let finest = |image: &TermImages| image.errors[1] - image.errors[0];
        let detail: f64 = self.images.iter().map(finest).sum();
        (MAX_BLUR * detail).max(10f64.powf(-INVISIBLE / 10.0) * numbers)
    }

    /// Finds approximately the smallest arrangement whose pack passes, by bisection with up to [`TRIALS`] packs; the largest if
    /// none passes.
    fn measured(&self, passes: impl Fn(&StackErrors) -> bool) -> Result<Found, FormatError> {
        let (mut low, mut high) = (0, self.path.len() - 1);
        let mut best = self.found(high)?;
        if !passes(&best.errors) {
            return Ok(Found { met: false, ..best });
        }
        for _ in 0..TRIALS {
            if high - low <= 1 {
                break;
            }
            let middle = low + (high - low).div_ceil(2);
            let found = self.found(middle)?;
            if passes(&found.errors) {
                (high, best) = (middle, found);
            } else {
                low = middle;
            }
        }
        Ok(best)
    }

    /// Builds and measures the pack of a step.
    fn found(&self, at: usize) -> Result<Found, FormatError> {
        let Step { terms, arrangement, .. } = &self.path[at];
        let mut header = self.header.clone();
        if let Some(map) = &mut header.light_map {
            map.truncate(terms + 1);
            header.basis.degree = *terms as u32;
        }
        let candidate = self.candidate(header.basis.degree);
        let decoder = PwtDecoder::new(arrangement.pack(&self.images[..*terms], header)?);
        let [width, height] = self.samples.size;
        let of_row = width * self.samples.lights.len();
        let rows = COMPARED_TEXELS.div_ceil(of_row).max(MIN_ROWS.min(8 * COMPARED_TEXELS / of_row));
        // With an odd step, not the same rows of every view.
        let step = height.div_ceil(rows) | usize::from(self.samples.views.is_some());
        let errors = stack_errors(&decoder, self.samples, step);
        let measured = PwtErrors {
            lights: errors.lights as u32,
            psnr: errors.psnr as f32,
            held_out_psnr: candidate.held_out_psnr.unwrap_or(0.0) as f32,
            delta_e: errors.delta_e as f32,
        };
        Ok(Found { pack: decoder.into_pack().with_errors(measured), errors, candidate, met: true })
    }
}
