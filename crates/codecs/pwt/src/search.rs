//! Searches the number of terms and their arrangement for a pack that meets a target.

use crate::assemble::{Arrangement, Limits, arrangements};
use crate::candidates::Candidate;
use crate::levels::TermImages;
use crate::measure::{StackErrors, stack_errors};
use crate::recipe::{PwtRecipe, Target};
use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightMap, PwtDecoder, PwtErrors, PwtHeader, PwtPack};

/// Numbers of learned terms are multiples of the texels' channels.
const STEP: usize = 4;
/// Approximate number of texels of all photographs that are compared at the end.
const COMPARED_TEXELS: usize = 1 << 21;
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
    candidate: Candidate,
}

impl<'a> Search<'a> {
    /// Search over the arrangements of terms that were fitted to `lights` lights. Of learned terms it can leave the last ones out,
    /// with their part of the light map, unless their number is requested.
    pub fn new(
        samples: &'a LightSamples,
        lights: usize,
        images: &'a [TermImages],
        header: PwtHeader,
        candidate: Candidate,
        recipe: &PwtRecipe,
    ) -> Self {
        let bytes = if let Target::Bytes(bytes) = recipe.target { bytes } else { u64::MAX };
        let layers = recipe.max_fetches.unwrap_or(PwtRecipe::MAX_FETCHES) as usize;
        let map = |terms| header.light_map.as_ref().map_or(0, |map| LightMap::bytes_of(map.side(), terms + 1));
        let is_fixed = header.light_map.is_none() || recipe.degree.is_some();
        let first = if is_fixed { images.len() } else { STEP };
        let mut steps = Vec::new();
        for terms in (first..images.len()).step_by(STEP).chain([images.len()]) {
            let bytes = bytes.saturating_sub(map(terms));
            let limits = Limits { extent: header.extent, depth: header.levels, layers, bytes };
            let left_out: f64 = images[terms..].iter().filter_map(|image| image.errors.last()).sum();
            steps.extend(arrangements(&images[..terms], &limits).into_iter().map(|arrangement| {
                let (bytes, error) = (arrangement.bytes(&limits) + map(terms), arrangement.error + left_out);
                Step { terms, arrangement, bytes, error }
            }));
        }
        steps.sort_by(|a, b| a.bytes.cmp(&b.bytes).then(a.error.total_cmp(&b.error)));
        let mut least = f64::INFINITY;
        steps.retain(|step| {
            let is_closer = step.error < least;
            least = least.min(step.error);
            is_closer
        });
        if let Target::Bytes(bytes) = recipe.target {
            // The smallest, if all are too large.
            let fitting = steps.iter().filter(|step| step.bytes <= bytes).count();
            steps.truncate(fitting.max(1));
        }
        Self { samples, lights, images, path: steps, header, candidate }
    }

    /// The pack, its errors, and true if it meets the target.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn run(self, target: Target) -> Result<(PwtPack, StackErrors, bool), FormatError> {
        let last = self.path.len() - 1;
        let first_below = |error: f64| self.path.iter().position(|step| step.error <= error);
        match target {
            // The path ends there.
            Target::Bytes(bytes) => {
                let (pack, errors) = self.made(last)?;
                let met = pack.gpu_bytes() <= bytes;
                Ok((pack, errors, met))
            }
            Target::Energy(share) => {
                let found = first_below((1.0 - share) * self.path[0].error);
                let (pack, errors) = self.made(found.unwrap_or(last))?;
                Ok((pack, errors, found.is_some()))
            }
            Target::Loss(loss) => {
                // Truncation adds to the error at held-out lights.
                let unseen = self.candidate.held_out_psnr.unwrap_or(self.candidate.psnr);
                let unseen = 10f64.powf(-unseen / 10.0);
                let numbers = (3 * self.samples.defined_texels() * self.lights) as f64;
                let allowed = (10f64.powf(loss / 10.0) - 1.0) * unseen * numbers + self.path[last].error;
                let (pack, errors) = self.made(first_below(allowed).unwrap_or(last))?;
                Ok((pack, errors, true))
            }
            Target::Quality(psnr) => self.measured(|errors| errors.psnr >= psnr),
            Target::DeltaE(delta_e) => self.measured(|errors| errors.delta_e <= delta_e),
        }
    }

    /// Finds approximately the smallest arrangement whose pack passes, by bisection with up to [`TRIALS`] packs; the largest if
    /// none passes.
    fn measured(&self, passes: impl Fn(&StackErrors) -> bool) -> Result<(PwtPack, StackErrors, bool), FormatError> {
        let (mut low, mut high) = (0, self.path.len() - 1);
        let mut best = self.made(high)?;
        if !passes(&best.1) {
            return Ok((best.0, best.1, false));
        }
        for _ in 0..TRIALS {
            if high - low <= 1 {
                break;
            }
            let middle = low + (high - low).div_ceil(2);
            let made = self.made(middle)?;
            if passes(&made.1) {
                (high, best) = (middle, made);
            } else {
                low = middle;
            }
        }
        Ok((best.0, best.1, true))
    }

    /// Builds and measures the pack of an arrangement.
    fn made(&self, at: usize) -> Result<(PwtPack, StackErrors), FormatError> {
        let Step { terms, arrangement, .. } = &self.path[at];
        let mut header = self.header.clone();
        if let Some(map) = &mut header.light_map {
            map.truncate(terms + 1);
            header.basis.degree = *terms as u32;
        }
        let pack = arrangement.pack(&self.images[..*terms], header)?;
        let decoder = PwtDecoder::new(pack);
        let all = self.samples.size[0] * self.samples.size[1] * self.samples.lights.len();
        let errors = stack_errors(&decoder, self.samples, all.div_ceil(COMPARED_TEXELS));
        let measured = PwtErrors {
            lights: errors.lights as u32,
            psnr: errors.psnr as f32,
            held_out_psnr: self.candidate.held_out_psnr.unwrap_or(0.0) as f32,
            delta_e: errors.delta_e as f32,
        };
        Ok((decoder.into_pack().with_errors(measured), errors))
    }
}
