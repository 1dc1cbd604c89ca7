//! Importance sampling of lobes: directions to integrate over.

use brdfc_formats::direction::Vector;
use brdfc_importance::LobeDistributions;
use std::f64::consts::{PI, TAU};

/// Samples incoming directions for an outgoing one, more densely where they matter more.
///
/// The mean of `g(incoming) / density` over indices from 0 on is the integral of `g` over the directions that the
/// sampler reaches, in solid angle. Directions are unit vectors in the local frame, and may lie below the horizon.
pub trait LobeSampler: Sync {
    /// Direction of an index, and the inverse of its density, sr; 0 for an index without a direction, which still
    /// counts as a sample.
    fn sample(&self, outgoing: Vector, index: usize) -> (Vector, f64);

    /// Density of an incoming direction, 1/sr; 0 for directions that the sampler does not reach.
    fn density(&self, outgoing: Vector, incoming: Vector) -> f64;
}

/// Samples hemisphere directions in proportion to their cosine, for matte surfaces.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CosineSampler {
    /// Shift of the sequence, see [`low_discrepancy`].
    pub shift: [f64; 2],
}

impl LobeSampler for CosineSampler {
    fn sample(&self, outgoing: Vector, index: usize) -> (Vector, f64) {
        let [u, v] = low_discrepancy(index, self.shift);
        let (sine, phi) = (u.sqrt(), TAU * v);
        let incoming = [sine * phi.cos(), sine * phi.sin(), (1.0 - u).sqrt()];
        (incoming, 1.0 / self.density(outgoing, incoming))
    }

    fn density(&self, _: Vector, incoming: Vector) -> f64 {
        incoming[2].max(0.0) / PI
    }
}

/// A measured lobe as a sampler.
#[derive(Clone, Copy)]
pub struct MeasuredLobe<'a> {
    /// Distributions of the material's half vectors.
    pub distributions: &'a LobeDistributions,
    /// Shift of the sequence, see [`low_discrepancy`].
    pub shift: [f64; 2],
}

impl LobeSampler for MeasuredLobe<'_> {
    fn sample(&self, outgoing: Vector, index: usize) -> (Vector, f64) {
        self.distributions.sample(outgoing, low_discrepancy(index, self.shift))
    }

    fn density(&self, outgoing: Vector, incoming: Vector) -> f64 {
        self.distributions.density(outgoing, incoming)
    }
}

/// Alternates between two samplers, weighted by the balance heuristic (Veach and Guibas 1995), so that the combination
/// is good where either of them is. The density is the mean of both.
#[derive(Clone, Copy)]
pub struct BalancedSampler<'a> {
    /// Sampler of even indices.
    pub first: &'a dyn LobeSampler,
    /// Sampler of odd indices.
    pub second: &'a dyn LobeSampler,
}

impl LobeSampler for BalancedSampler<'_> {
    fn sample(&self, outgoing: Vector, index: usize) -> (Vector, f64) {
        let of = if index.is_multiple_of(2) { self.first } else { self.second };
        let (incoming, inverse) = of.sample(outgoing, index / 2);
        let density = self.density(outgoing, incoming);
        (incoming, if inverse > 0.0 && density > 0.0 { 1.0 / density } else { 0.0 })
    }

    fn density(&self, outgoing: Vector, incoming: Vector) -> f64 {
        0.5 * (self.first.density(outgoing, incoming) + self.second.density(outgoing, incoming))
    }
}

/// Points that fill the unit square evenly from the first on: radical inverses in the bases 2 and 3 (Halton 1960),
/// shifted by `shift` modulo 1 (Cranley and Patterson 1976). The bases 2 and 3 repeat after 2³² indices.
pub fn low_discrepancy(index: usize, shift: [f64; 2]) -> [f64; 2] {
    let twos = f64::from((index as u32).reverse_bits()) / 4_294_967_296.0;
    let (mut threes, mut share, mut rest) = (0.0, 1.0 / 3.0, index as u32);
    while rest > 0 {
        threes += share * f64::from(rest % 3);
        (share, rest) = (share / 3.0, rest / 3);
    }
    [twos + shift[0], threes + shift[1]].map(|u| u - u.floor())
}

/// A different shift for each of many neighbouring points, so that their errors are noise without a pattern: fractions
/// of multiples of two irrational numbers (Roberts 2018).
pub fn shift_of(point: usize) -> [f64; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|step| (point as f64 * step).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTGOING: Vector = [0.6, 0.0, 0.8];

    /// Uniform directions.
    struct Uniform;

    impl LobeSampler for Uniform {
        fn sample(&self, _: Vector, index: usize) -> (Vector, f64) {
            let [u, v] = low_discrepancy(index, [0.3, 0.6]);
            let (z, phi) = (1.0 - 2.0 * u, TAU * v);
            let sine = (1.0 - z * z).sqrt();
            ([sine * phi.cos(), sine * phi.sin(), z], 4.0 * PI)
        }

        fn density(&self, _: Vector, _: Vector) -> f64 {
            0.25 / PI
        }
    }

    fn mean(sampler: &dyn LobeSampler, samples: usize, g: impl Fn(Vector) -> f64) -> f64 {
        let term = |index| {
            let (incoming, inverse) = sampler.sample(OUTGOING, index);
            g(incoming) * inverse
        };
        (0..samples).map(term).sum::<f64>() / samples as f64
    }

    #[test]
    fn the_first_points_are_those_of_halton() {
        let found: Vec<[f64; 2]> = (1..6).map(|index| low_discrepancy(index, [0.0; 2])).collect();
        let expected = [[1.0 / 2.0, 1.0 / 3.0], [1.0 / 4.0, 2.0 / 3.0], [3.0 / 4.0, 1.0 / 9.0]];
        for (found, expected) in found.iter().zip(expected) {
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-15), "{found:?} {expected:?}");
        }
        assert!((0..1000).all(|i| low_discrepancy(i, shift_of(i)).iter().all(|u| (0.0..1.0).contains(u))));
    }

    #[test]
    fn powers_of_the_cosine_have_known_integrals() {
        let cosine = CosineSampler { shift: [0.2, 0.7] };
        let balanced = BalancedSampler { first: &cosine, second: &Uniform };
        for power in [1, 2, 5] {
            let exact = TAU / f64::from(power + 1);
            let g = |d: Vector| d[2].max(0.0).powi(power);
            assert!((mean(&cosine, 4096, g) / exact - 1.0).abs() < 2e-3);
            assert!((mean(&balanced, 8192, g) / exact - 1.0).abs() < 5e-3);
        }
        // The control: densities of one sampler for the directions of another.
        struct Wrong;
        impl LobeSampler for Wrong {
            fn sample(&self, outgoing: Vector, index: usize) -> (Vector, f64) {
                (CosineSampler::default().sample(outgoing, index).0, TAU)
            }
            fn density(&self, _: Vector, _: Vector) -> f64 {
                1.0 / TAU
            }
        }
        assert!((mean(&Wrong, 4096, |d| d[2]) / PI - 1.0).abs() > 0.1);
    }

    #[test]
    fn samples_have_the_inverse_of_their_density() {
        let cosine = CosineSampler::default();
        let balanced = BalancedSampler { first: &cosine, second: &Uniform };
        let samplers: [&dyn LobeSampler; 3] = [&cosine, &Uniform, &balanced];
        for sampler in samplers {
            for index in 0..200 {
                let (incoming, inverse) = sampler.sample(OUTGOING, index);
                assert!((inverse * sampler.density(OUTGOING, incoming) - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(cosine.density(OUTGOING, [0.0, 0.6, -0.8]), 0.0);
    }
}
