//! Candidates for the terms of the light, and the texels on which they are compared.

use crate::recipe::DomainName;
use crate::stack::LightSamples;
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates};
use brdfc_readers::pixels::Pixels;
use rayon::prelude::*;

/// Number of texels used.
const TEXELS: usize = 512;
/// Candidates for `ε` of logarithms, as shares of the mean value.
const EPSILONS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// A candidate and its errors.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Candidate {
    /// Domain of the values.
    pub domain: DomainName,
    /// `ε` of logarithms, else 0.
    pub epsilon: f32,
    /// Coordinates of the polynomials, or learned terms.
    pub coordinates: LightCoordinates,
    /// Highest degree of the polynomials, or the number of learned terms.
    pub degree: u32,
    /// Ridge `λ`, the weight of the penalty on roughness; 0 for learned terms.
    pub ridge: f64,
    /// PSNR of sRGB-encoded values at the fitted lights, dB.
    pub psnr: f64,
    /// The same in leave-one-out cross-validation over the lights; `None` if there are too few lights. For learned terms an
    /// estimate, because their components have seen all photographs. Both values are for 512 texels, before pruning and rounding.
    pub held_out_psnr: Option<f64>,
}

impl Candidate {
    /// Domain of the candidate.
    pub fn domain(&self) -> Domain {
        match self.domain {
            DomainName::Linear => Domain::Linear,
            DomainName::Display => Domain::Display,
            DomainName::CubeRoot => Domain::CubeRoot,
            DomainName::Log => Domain::Logarithm { epsilon: self.epsilon },
        }
    }

    /// Rank of the candidate; lowest if it has no cross-validation.
    pub(crate) fn merit(&self) -> f64 {
        self.held_out_psnr.unwrap_or(f64::NEG_INFINITY)
    }

    /// Terms of the candidate.
    pub fn basis(&self) -> LightBasis {
        LightBasis { coordinates: self.coordinates, degree: self.degree }
    }
}

/// Sample of texels under all lights.
pub(crate) struct Texels {
    /// Linear values of each light: red, green and blue of each texel.
    pub(crate) values: Vec<Vec<f32>>,
    /// The same values sRGB-encoded, 0 to 1.
    pub(crate) codes: Vec<Vec<f32>>,
    mean: f64,
}

impl Texels {
    pub(crate) fn new(samples: &LightSamples) -> Self {
        let at = samples.spread_texels(TEXELS);
        let of_light = |image: &Pixels| -> Vec<f32> {
            at.iter().flat_map(|texel| image.pixel(*texel)).map(|value| value.max(0.0)).collect()
        };
        let values: Vec<Vec<f32>> = samples.images.par_iter().map(of_light).collect();
        let codes = values.iter().map(|values| to_srgb(Domain::Linear, values.clone())).collect();
        let numbers = values.iter().map(Vec::len).sum::<usize>().max(1);
        let mean = values.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / numbers as f64;
        Self { values, codes, mean }
    }

    /// Values of each light in a domain.
    pub(crate) fn encoded(&self, domain: Domain) -> Vec<Vec<f32>> {
        let mut values = self.values.clone();
        values.iter_mut().for_each(|values| domain.encode_each(values));
        values
    }

    pub(crate) fn domains(&self, name: DomainName) -> Vec<Domain> {
        match name {
            DomainName::Linear => vec![Domain::Linear],
            DomainName::Display => vec![Domain::Display],
            DomainName::CubeRoot => vec![Domain::CubeRoot],
            DomainName::Log => {
                let epsilon = |share: f64| (share * self.mean).max(1e-6) as f32;
                EPSILONS.iter().map(|share| Domain::Logarithm { epsilon: epsilon(*share) }).collect()
            }
        }
    }
}

/// Converts values in a domain to sRGB encoding, 0 to 1.
pub(crate) fn to_srgb(domain: Domain, mut values: Vec<f32>) -> Vec<f32> {
    if domain == Domain::Display {
        values.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        return values;
    }
    domain.decode_each(&mut values);
    values.iter_mut().for_each(|value| *value = value.min(1.0));
    Domain::Display.encode_each(&mut values);
    values
}

/// Squared slopes of the sRGB encoding, 0 to 1, over values in a domain: the mean of both sides, which differ at black and white.
pub(crate) struct SquaredSlopes {
    black: f32,
    /// Distance between entries, in the domain.
    step: f32,
    /// Squared slopes at equally spaced values from black to white.
    table: Vec<f32>,
}

impl SquaredSlopes {
    /// Computes the slopes for a domain. A table, because the encodings take many times longer than a look-up.
    pub(crate) fn new(domain: Domain) -> Self {
        const STEPS: usize = 4096;
        const DIFFERENCE: f32 = 1e-3;
        let [black, white] = [0.0, 1.0].map(|value| domain.encode(value));
        let step = (white - black) / STEPS as f32;
        let values = (0..=STEPS).map(|k| black + k as f32 * step);
        let [below, at, above] = [-DIFFERENCE, 0.0, DIFFERENCE]
            .map(|difference| to_srgb(domain, values.clone().map(|value| value + difference).collect()));
        let squared = |difference: f32| (difference / DIFFERENCE).powi(2);
        let of = |k: usize| 0.5 * (squared(at[k] - below[k]) + squared(above[k] - at[k]));
        Self { black, step, table: (0..=STEPS).map(of).collect() }
    }

    /// The entry nearest to a value: the first below black, the last above white.
    pub(crate) fn at(&self, value: f32) -> f32 {
        let nearest = ((value - self.black) / self.step).round() as usize;
        self.table[nearest.min(self.table.len() - 1)]
    }
}

/// Sum of squared differences.
pub(crate) fn squares(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from((a - b) * (a - b))).sum()
}

/// PSNR for a mean squared error of values from 0 to 1, dB. Errors below rounding to 16 bits
/// count as that; NaN counts as the largest error.
pub fn decibels(mean_square: f64) -> f64 {
    if mean_square.is_nan() {
        return 0.0;
    }
    -10.0 * mean_square.max(1.0 / 65536.0 / 65536.0).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers: the derivative of the sRGB curve times that of the decoded value. Nearer to black and white, entries differ more
    /// from the slope at a value.
    #[test]
    fn slopes_are_those_of_the_curve() {
        let curve = |value: f64| 1.055 / 2.4 * value.powf(1.0 / 2.4 - 1.0);
        let of_value = |domain: Domain, value: f64| match domain {
            Domain::Linear => 1.0,
            Domain::Display => 1.0 / curve(value),
            Domain::CubeRoot => 3.0 * value.powf(2.0 / 3.0),
            Domain::Logarithm { epsilon } => value + f64::from(epsilon),
        };
        let logarithms = [1e-6, 0.1].map(|epsilon| Domain::Logarithm { epsilon });
        for domain in [[Domain::Linear, Domain::Display, Domain::CubeRoot].as_slice(), &logarithms].concat() {
            let slopes = SquaredSlopes::new(domain);
            for value in (0..97).map(|k| 0.03 + 0.01 * f64::from(k) / 1.003) {
                let expected = (curve(value) * of_value(domain, value)).powi(2);
                let found = f64::from(slopes.at(domain.encode(value as f32)));
                assert!((found / expected - 1.0).abs() < 0.03, "{domain:?} {value}: {found} {expected}");
            }
            // One side is clipped at white and above.
            let white = f64::from(slopes.at(domain.encode(1.0)));
            let expected = 0.5 * (curve(1.0) * of_value(domain, 1.0)).powi(2);
            assert!((white / expected - 1.0).abs() < 0.03, "{domain:?}: {white} {expected}");
            assert_eq!(slopes.at(100.0), slopes.at(domain.encode(1.0)));
        }
    }
}
