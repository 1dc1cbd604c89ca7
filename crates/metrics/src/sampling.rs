//! Fixed sets of directions for comparisons: the same in every run and on every machine.

use brdfc_core::pair_list::PairList;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_formats::direction::{DirectionPair, Vector, dot, from_polar, half_vector};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::sync::{Arc, OnceLock};

/// Number of pairs of [`PairSet::comparison`] with both directions uniform over the hemisphere's solid angle.
pub const UNIFORM_PAIRS: usize = 1 << 15;
/// Number of pairs near the mirror direction: half vectors up to 45 degrees from the normal, denser by the square root
/// towards it.
pub const MIRROR_PAIRS: usize = 1 << 14;
/// Number of pairs with one direction 75 to 88 degrees from the normal, alternately the incoming and the outgoing
/// direction.
pub const GRAZING_PAIRS: usize = 1 << 14;

/// Direction pairs of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct PairSet {
    /// Direction pairs at which both sides are evaluated.
    pub pairs: Arc<PairList>,
    /// Number of pairs, from the first on, that the mean is computed from.
    pub of_mean: usize,
    /// Directions in which renderings and albedos are compared.
    pub directions: DirectionRange,
}

impl PairSet {
    /// A set of any pairs; the mean is over all.
    pub fn new(pairs: Vec<DirectionPair>) -> Self {
        Self { of_mean: pairs.len(), pairs: Arc::new(PairList::new(pairs)), directions: DirectionRange::ALL }
    }

    /// The independent test directions of comparisons: 65,536 pairs, the same in every run, spread evenly in three
    /// strata. They depend on no codec, so errors of any two packs are comparable. The mean is over the uniform pairs:
    /// a few pairs with mirrored light at grazing angles would dominate it otherwise.
    pub fn comparison() -> Self {
        static PAIRS: OnceLock<Arc<PairList>> = OnceLock::new();
        let pairs = PairList::cached(&PAIRS, comparison_pairs);
        Self { pairs, of_mean: UNIFORM_PAIRS, directions: DirectionRange::ALL }
    }

    /// Test pairs of a pack for a range of directions: as many uniform pairs, all within the range, and the pairs of
    /// the other strata that are within the range.
    pub fn within(directions: DirectionRange) -> Self {
        let all = Self::comparison();
        if directions.is_all() {
            return all;
        }
        let ([light_low, light_high], [view_low, view_high]) = (directions.light.sines(), directions.view.sines());
        let between = |low: f64, high: f64, share: f64, turn: f64| {
            from_polar_cosine(low + (high - low) * (1.0 - share), TAU * turn)
        };
        let uniform = points(1).take(UNIFORM_PAIRS).map(|[a, b, c, d]| {
            DirectionPair::new(between(light_low, light_high, a, b), between(view_low, view_high, c, d))
        });
        let others = all.pairs[UNIFORM_PAIRS..].iter().copied().filter(|pair| directions.contains(*pair));
        let pairs = Arc::new(PairList::new(uniform.chain(others).collect()));
        Self { pairs, of_mean: UNIFORM_PAIRS, directions }
    }
}

fn comparison_pairs() -> Vec<DirectionPair> {
    let steepest = 88f64.to_radians().cos();
    let between =
        |low: f64, high: f64, share: f64, turn: f64| from_polar_cosine(low + (high - low) * (1.0 - share), TAU * turn);
    let uniform = |[a, b, c, d]: [f64; 4]| DirectionPair::new(between(0.0, 1.0, a, b), between(0.0, 1.0, c, d));
    let mirrored = |[a, b, c, d]: [f64; 4]| {
        let incoming = between(steepest, 1.0, a, b);
        let half = from_polar(FRAC_PI_4 * c * c, TAU * d);
        let twice = 2.0 * dot(incoming, half);
        DirectionPair::new(incoming, std::array::from_fn(|k| twice * half[k] - incoming[k]))
    };
    let grazing = |(k, [a, b, c, d]): (usize, [f64; 4])| {
        let pair = DirectionPair::new(between(steepest, 75f64.to_radians().cos(), a, b), between(steepest, 1.0, c, d));
        if k % 2 == 0 { pair } else { pair.exchanged() }
    };
    let seen = points(1).map(mirrored).filter(|pair| pair.outgoing[2] > steepest).take(MIRROR_PAIRS);
    let grazing = points(1).take(GRAZING_PAIRS).enumerate().map(grazing);
    let (mut pairs, others): (Vec<DirectionPair>, Vec<DirectionPair>) =
        rayon::join(|| points(1).map(uniform).take(UNIFORM_PAIRS).collect(), || seen.chain(grazing).collect());
    pairs.extend(others);
    pairs
}

/// Points that fill the four-dimensional unit cube evenly: multiples of the powers of `1/g`, where `g` is the root of
/// `g^5 = g + 1` (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"), starting with number
/// `first`.
pub fn points(first: u32) -> impl Iterator<Item = [f64; 4]> {
    (first..).map(point)
}

/// Point `number` of the sequence of [`points`].
pub fn point(number: u32) -> [f64; 4] {
    const G: f64 = 1.167_303_978_261_418_7;
    const STEPS: [f64; 4] = [1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G), 1.0 / (G * G * G * G)];
    STEPS.map(|step| (0.5 + f64::from(number) * step).fract())
}

/// Unit vector with this z and azimuth, radians.
pub(super) fn from_polar_cosine(z: f64, phi: f64) -> Vector {
    let r = (1.0 - z * z).max(0.0).sqrt();
    [r * phi.cos(), r * phi.sin(), z]
}

/// `count` direction pairs, both directions uniform over the hemisphere's solid angle, from a seeded generator.
pub fn random_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut direction = || {
        let z: f64 = 1.0 - generator.random::<f64>();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let phi = TAU * generator.random::<f64>();
        [r * phi.cos(), r * phi.sin(), z]
    };
    (0..count).map(|_| DirectionPair::new(direction(), direction())).collect()
}

/// `side²` directions with cosine density: the mean of `f` over them times π is the albedo.
pub fn cosine_directions(side: usize) -> Vec<Vector> {
    let step = 1.0 / side as f64;
    let mut directions = Vec::with_capacity(side * side);
    for a in 0..side {
        for b in 0..side {
            let r = ((a as f64 + 0.5) * step).sqrt();
            let phi = (b as f64 + 0.5) * step * TAU;
            directions.push([r * phi.cos(), r * phi.sin(), (1.0 - r * r).sqrt()]);
        }
    }
    directions
}

/// Directions per axis of each half of [`albedo_samples`].
const ALBEDO_SIDE: usize = 16;
/// Smallest sampled angle between half vector and normal, radians.
const NARROWEST: f64 = 1e-4;

/// Outgoing directions and their weights in `∫ f cos θo dωo` at an incoming direction: the integral is the weighted sum
/// of `f`.
///
/// Half of them have cosine density. The other half reflect the light at half vectors whose angle to the normal is
/// spread over its logarithm, so that they hit lobes of any width. Both are weighted by the balance heuristic (Veach
/// and Guibas 1995). Directions below the horizon are omitted. A matte white has 1 exactly, narrow lobes are within a
/// few percent.
pub fn albedo_samples(incoming: Vector) -> Vec<(Vector, f64)> {
    let cosine = cosine_directions(ALBEDO_SIDE);
    let step = 1.0 / ALBEDO_SIDE as f64;
    let widths = (FRAC_PI_2 / NARROWEST).ln();
    let mirrored = (0..ALBEDO_SIDE * ALBEDO_SIDE).map(|k| {
        let t = ((k / ALBEDO_SIDE) as f64 + 0.5) * step;
        // Rings are rotated against each other.
        let phi = ((k % ALBEDO_SIDE) as f64 + 0.5 + 0.618 * (k / ALBEDO_SIDE) as f64) * step * TAU;
        let half = from_polar(FRAC_PI_2 * ((t - 1.0) * widths).exp(), phi);
        let twice = 2.0 * dot(incoming, half);
        std::array::from_fn(|k| twice * half[k] - incoming[k])
    });
    let seen = |outgoing: &Vector| outgoing[2] > 0.0 && dot(incoming, *outgoing) > -1.0;
    let counted = |outgoing: Vector| {
        let half = half_vector(DirectionPair::new(incoming, outgoing));
        let theta = half[0].hypot(half[1]).atan2(half[2]);
        let of_angle = if theta >= NARROWEST { 1.0 / (theta * widths) } else { 0.0 };
        let of_half = if of_angle > 0.0 { of_angle / (TAU * theta.sin()) } else { 0.0 };
        let density = outgoing[2] / PI + of_half / (4.0 * dot(incoming, half));
        (outgoing, outgoing[2] / (density * cosine.len() as f64))
    };
    let mut samples: Vec<(Vector, f64)> = cosine.iter().copied().chain(mirrored).filter(seen).map(counted).collect();
    // Exact for matte materials.
    let white: f64 = samples.iter().map(|(_, counted)| counted / PI).sum();
    samples.iter_mut().for_each(|(_, counted)| *counted /= white);
    samples
}

/// Number of polar angles of albedos, in steps of 5 degrees.
const ALBEDO_STEPS: usize = 18;

/// Direction pairs of an albedo.
#[derive(Debug, Clone)]
pub struct AlbedoPairs {
    /// Polar angle and azimuth of the incoming direction, degrees.
    pub angles: [f64; 2],
    /// Incoming direction, a unit vector.
    pub incoming: Vector,
    /// Pairs with each outgoing direction of [`albedo_samples`].
    pub pairs: PairList,
    /// Weight of each pair.
    pub counted: Vec<f64>,
}

impl AlbedoPairs {
    fn new([theta, phi]: [f64; 2]) -> Self {
        let incoming = from_polar(theta.to_radians(), phi.to_radians());
        let (pairs, counted) = albedo_samples(incoming)
            .into_iter()
            .map(|(out, counted)| (DirectionPair::new(incoming, out), counted))
            .unzip();
        Self { angles: [theta, phi], incoming, pairs: PairList::new(pairs), counted }
    }

    /// Pairs of albedo curves: incoming directions from 0 to 85 degrees in steps of 5, at the azimuths 0 and, for
    /// anisotropic materials, 90 degrees.
    pub fn of_curves(isotropic: bool) -> Vec<&'static Self> {
        static ALL: [OnceLock<AlbedoPairs>; 2 * ALBEDO_STEPS] = [const { OnceLock::new() }; 2 * ALBEDO_STEPS];
        let count = if isotropic { ALBEDO_STEPS } else { 2 * ALBEDO_STEPS };
        let angles = |k: usize| [5.0 * (k % ALBEDO_STEPS) as f64, 90.0 * (k / ALBEDO_STEPS) as f64];
        ALL[..count].par_iter().enumerate().map(|(k, cell)| cell.get_or_init(|| Self::new(angles(k)))).collect()
    }

    /// The pairs within a range of outgoing directions.
    pub fn within(&self, view: Elevations) -> Self {
        let inside = self.pairs.iter().zip(&self.counted).filter(|(pair, _)| view.contain(pair.outgoing));
        let (pairs, counted) = inside.map(|(pair, counted)| (*pair, *counted)).unzip();
        Self { pairs: PairList::new(pairs), counted, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_above_the_horizon_and_in_their_strata() {
        let pairs = PairSet::comparison().pairs;
        assert_eq!(pairs.len(), 65_536);
        for pair in pairs.iter() {
            assert!(pair.is_above_horizon());
            for v in [pair.incoming, pair.outgoing] {
                assert!((dot(v, v) - 1.0).abs() < 1e-12);
            }
        }
        let (uniform, rest) = pairs.split_at(UNIFORM_PAIRS);
        let (mirror, grazing) = rest.split_at(MIRROR_PAIRS);
        let off_mirror = |pair: &DirectionPair| {
            let [x, y, z] = pair.incoming;
            dot([-x, -y, z], pair.outgoing)
        };
        let near = |pairs: &[DirectionPair]| pairs.iter().filter(|pair| off_mirror(pair) > 0.99).count();
        assert!(near(mirror) > MIRROR_PAIRS / 4 && near(uniform) < UNIFORM_PAIRS / 100);
        let limit = 75f64.to_radians().cos() + 1e-12;
        assert!(grazing.iter().all(|pair| pair.incoming[2].min(pair.outgoing[2]) <= limit));
        assert!(grazing.iter().filter(|pair| pair.incoming[2] <= limit).count() > GRAZING_PAIRS / 2);
    }

    #[test]
    fn pairs_within_a_range_are_within() {
        let directions =
            DirectionRange { light: Elevations { from: 0.0, to: 30.0 }, view: Elevations { from: 60.0, to: 90.0 } };
        let set = PairSet::within(directions);
        assert!(set.pairs.iter().all(|pair| directions.contains(*pair) && pair.is_above_horizon()));
        assert!(set.pairs.len() >= UNIFORM_PAIRS && set.pairs.len() < 65_536, "{}", set.pairs.len());
        // Uniform over the solid angle: the mean of z is the middle of both sines.
        let mean = set.pairs[..UNIFORM_PAIRS].iter().map(|pair| pair.incoming[2]).sum::<f64>() / UNIFORM_PAIRS as f64;
        assert!((mean - 0.25).abs() < 1e-3, "{mean}");
        assert_eq!(PairSet::within(DirectionRange::ALL), PairSet::comparison());
    }

    /// Known albedos: of a matte white, and of the part of a lobe of any width around the mirror direction: `f` makes
    /// the reflected light equal to the solid angle of half vectors within `width`.
    #[test]
    fn albedos_of_lobes_of_any_width() {
        for theta in [0.0, 0.5, 1.2, 1.45] {
            let incoming = from_polar(theta, 0.3);
            let samples = albedo_samples(incoming);
            let white: f64 = samples.iter().map(|(_, counted)| counted / PI).sum();
            assert!((white - 1.0).abs() < 1e-12, "{theta}: {white}");
            for width in [1e-3, 1e-2, 0.1] {
                // dω_o = 4 (i · h) dω_h.
                let f = |outgoing: Vector| {
                    let half = half_vector(DirectionPair::new(incoming, outgoing));
                    let off = half[0].hypot(half[1]).atan2(half[2]) / width;
                    (-off * off).exp() / (4.0 * dot(incoming, half) * outgoing[2])
                };
                let found: f64 = samples.iter().map(|(outgoing, counted)| f(*outgoing) * counted).sum();
                let expected = PI * width * width;
                assert!(
                    theta + 4.0 * width > FRAC_PI_2 || (found / expected - 1.0).abs() < 0.05,
                    "{theta} {width}: {}",
                    found / expected
                );
            }
        }
    }

    /// Means over the uniform pairs are integrals, far more accurate than with as many random pairs.
    #[test]
    fn uniform_pairs_integrate() {
        let pairs = &PairSet::comparison().pairs[..UNIFORM_PAIRS];
        let mean = |f: &dyn Fn(&DirectionPair) -> f64| pairs.iter().map(f).sum::<f64>() / pairs.len() as f64;
        // The standard error with random pairs would be 1.6e-3.
        assert!((mean(&|pair| pair.incoming[2]) - 0.5).abs() < 4e-4);
        assert!((mean(&|pair| pair.outgoing[2].powi(2)) - 1.0 / 3.0).abs() < 4e-4);
        assert!(mean(&|pair| pair.incoming[0] * pair.outgoing[0]).abs() < 1e-3);
        let turned = |pair: &DirectionPair| pair.incoming[0] * pair.outgoing[1] - pair.incoming[1] * pair.outgoing[0];
        assert!(mean(&turned).abs() < 1e-3);
    }
}
