//! Methods that store each view separately: polynomials of the light, or the plain values.

use super::assets::Asset;
use super::errors::Truth;
use super::lights::Lights;
use super::rows::Tally;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtDecoder, PwtPack};
use brdfc_pwt::candidates::Candidate;
use brdfc_pwt::measure::images_of_pack;
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{LightSamples, PwtRecipe, Target, encode, plain};
use std::time::Instant;

const HARMONICS: LightBasis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 3 };
const BIQUADRATIC: LightBasis = LightBasis { coordinates: LightCoordinates::Projected, degree: 2 };
/// Number of blended views between directions of a set, each of which is fetched completely.
const BLENDED_VIEWS: f64 = 3.0;
/// Number of blended lights, for methods without a polynomial of the light.
const BLENDED_LIGHTS: f64 = 3.0;
/// Methods of the first pass, in order.
pub(super) const FIRST: [&str; 7] =
    ["uncompressed", "PTM", "PTM, LRGB", "PTM at half size", "HSH, order 3", "HSH, order 3, at half size", "PWT"];

/// Bytes per texel of a map, and fetches of textures of four numbers that hold its coefficients.
fn cost(model: MapModel) -> (u64, f64) {
    match model {
        MapModel::Rgb => (18, 5.0),
        MapModel::Lrgb => (9, 3.0),
    }
}

/// Results of the first pass over a view.
pub(super) struct FirstView {
    pub(super) tallies: [Tally; FIRST.len()],
    /// Choice of the tree's encoder.
    pub(super) chosen: Candidate,
}

/// A view ready to be stored and measured.
pub(super) struct View<'a> {
    lights: &'a Lights,
    samples: LightSamples,
    truth: Truth,
}

/// Number of texels of all mipmap levels of a square image.
pub(super) fn texels_with_mipmaps(size: usize) -> u64 {
    (0..=size.ilog2()).map(|level| ((size >> level) as u64).pow(2)).sum()
}

impl<'a> View<'a> {
    pub(super) fn new(asset: &Asset, view: usize, lights: &'a Lights) -> Self {
        let renderings = asset.renderings(view, lights);
        let samples = asset.samples(view, &renderings, lights);
        let truth = Truth::new(&renderings, asset.mask(view));
        Self { lights, samples, truth }
    }

    /// Results that do not depend on the other views.
    ///
    /// # Errors
    /// Returns an error for renderings that an encoder rejects.
    pub(super) fn first(&self) -> Result<FirstView, FormatError> {
        let map = |model| self.map(model);
        let terms = |basis, level| -> Result<Tally, FormatError> {
            let start = Instant::now();
            let pack = plain(&self.samples, basis, level)?;
            Ok(self.packed(pack, start.elapsed().as_secs_f64()))
        };
        let (rgb, lrgb, small) = (map(MapModel::Rgb)?, map(MapModel::Lrgb)?, terms(BIQUADRATIC, 1)?);
        let (harmonics, small_harmonics) = (terms(HARMONICS, 0)?, terms(HARMONICS, 1)?);

        let start = Instant::now();
        let made = encode(&self.samples, &PwtRecipe::default())?;
        let tree = self.packed(made.pack, start.elapsed().as_secs_f64());
        let tallies = [self.uncompressed(), rgb, lrgb, small, harmonics, small_harmonics, tree];
        Ok(FirstView { tallies, chosen: made.candidates[0] })
    }

    /// A polynomial texture map.
    fn map(&self, model: MapModel) -> Result<Tally, FormatError> {
        let start = Instant::now();
        let map = fit_map(&self.samples, model)?;
        let seconds = start.elapsed().as_secs_f64();
        let shown = images_of(&map, self.lights.directions.clone()).into_linear();
        let (bytes, fetches) = cost(model);
        let bytes = bytes * texels_with_mipmaps(self.samples.size[0]);
        Ok(self.tally(&shown, bytes, BLENDED_VIEWS * fetches, seconds))
    }

    /// The smallest tree with this mean ΔE. Uses the known choice of the encoder instead of searching for it again.
    ///
    /// # Errors
    /// Returns the errors of [`Self::first`].
    pub(super) fn at_error(&self, chosen: Candidate, delta_e: f64) -> Result<Tally, FormatError> {
        let recipe = PwtRecipe {
            coordinates: Some(chosen.coordinates),
            degree: Some(chosen.degree),
            ridge: (chosen.coordinates != LightCoordinates::Learned).then_some(chosen.ridge),
            domain: Some(chosen.domain),
            target: Target::DeltaE(delta_e),
            ..PwtRecipe::default()
        };
        let start = Instant::now();
        let made = encode(&self.samples, &recipe)?;
        Ok(self.packed(made.pack, start.elapsed().as_secs_f64()))
    }

    /// The values themselves, blended for held-out lights as in a renderer.
    fn uncompressed(&self) -> Tally {
        let bytes = 4 * self.samples.lights.len() as u64 * texels_with_mipmaps(self.samples.size[0]);
        let shown = self.lights.completed(self.samples.clone().into_linear());
        self.tally(&shown, bytes, BLENDED_VIEWS * BLENDED_LIGHTS, 0.0)
    }

    fn packed(&self, pack: PwtPack, seconds: f64) -> Tally {
        let (bytes, fetches) = (pack.gpu_bytes(), f64::from(pack.header().fetches()));
        let shown =
            images_of_pack(&PwtDecoder::new(pack), [0.0, 0.0, 1.0], self.lights.directions.clone()).into_linear();
        self.tally(&shown, bytes, BLENDED_VIEWS * fetches, seconds)
    }

    fn tally(&self, shown: &[Vec<[f32; 3]>], bytes: u64, fetches: f64, seconds: f64) -> Tally {
        let errors = self.truth.errors(shown, self.lights);
        Tally { bytes, fetches, seconds, errors }
    }
}
