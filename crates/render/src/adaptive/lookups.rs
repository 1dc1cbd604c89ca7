//! Look-ups of adaptive shading for a material, made from its source.

use super::AdaptiveMaterial;
use crate::shade::Reflectance;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::brdf_map;
use brdfc_bandwidth::resolution::Resolution;
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::importance::ImportancePack;
use brdfc_importance::{ImportanceRecipe, LobeDistributions, importance_samples};
use brdfc_metrics::image::luminance;

/// Number of outgoing directions that [`albedo`] averages over.
const VIEWS: u32 = 8;
/// Number of samples per outgoing direction.
const SAMPLES: u32 = 128;

/// Maps and samples of a material, besides its pack.
#[derive(Debug)]
pub struct Lookups {
    /// Bandwidth of its lobe.
    pub bandwidth: BandwidthMap,
    /// Directions drawn in proportion to its lobe.
    pub samples: ImportancePack,
    /// The densities behind the samples, for ground truths.
    pub distributions: LobeDistributions,
    /// Approximate luminance of its albedo, see [`AdaptiveMaterial::albedo`].
    pub albedo: f32,
}

impl Lookups {
    /// Makes all look-ups with the default recipes.
    ///
    /// # Errors
    /// Returns an error for recipes that the layouts reject, which the default recipes do not cause.
    pub fn new(source: &dyn Source) -> Result<Self, FormatError> {
        let (bandwidth, _) = brdf_map(source, Resolution::default(), DEFAULT_EPSILON)?;
        let (samples, _) = importance_samples(source, &ImportanceRecipe::default())?;
        Self::of_packs(source, bandwidth, samples)
    }

    /// Makes the rest for existing packs.
    ///
    /// # Errors
    /// Returns an error for recipes that the layouts reject, which the default recipes do not cause.
    pub fn of_packs(
        source: &dyn Source,
        bandwidth: BandwidthMap,
        samples: ImportancePack,
    ) -> Result<Self, FormatError> {
        let distributions = LobeDistributions::new(source, &ImportanceRecipe::default())?;
        let albedo = albedo(&samples, |pair| source.eval(pair, &mut Tally::default()));
        Ok(Self { bandwidth, samples, distributions, albedo })
    }

    /// An adaptive material with this `f_r` and no texture.
    pub fn material<'a>(&'a self, reflectance: &'a dyn Reflectance) -> AdaptiveMaterial<'a> {
        AdaptiveMaterial {
            reflectance,
            samples: &self.samples,
            bandwidth: &self.bandwidth,
            albedo: self.albedo,
            texture: None,
        }
    }
}

/// Luminance of the directional albedo, the mean over outgoing directions at equal steps of their cosine.
fn albedo(samples: &ImportancePack, f_r: impl Fn(DirectionPair) -> [f64; 3]) -> f32 {
    let mut sum = 0.0;
    for view in 0..VIEWS {
        let cosine = (view as f32 + 0.5) / VIEWS as f32;
        let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        for index in 0..SAMPLES {
            let (incoming, inverse_density) = samples.sample(outgoing, index);
            if inverse_density > 0.0 {
                let pair = DirectionPair::new(incoming.map(f64::from), outgoing.map(f64::from));
                sum += luminance(f_r(pair).map(|c| c as f32)) * f64::from(incoming[2] * inverse_density);
            }
        }
    }
    // Measured values may be below 0.
    (sum / f64::from(VIEWS * SAMPLES)).max(0.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;

    #[test]
    fn the_albedo_of_lambert_is_its_diffuse_reflectance() {
        for (address, expected) in [("synth:lambert?kd=0.6", 0.6f32), ("synth:lambert?kd=0.1", 0.1)] {
            let found = Lookups::new(parse_synth(address).unwrap().as_ref()).unwrap().albedo;
            assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        }
    }
}
