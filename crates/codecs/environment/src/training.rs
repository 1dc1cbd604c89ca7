//! Environments on which lobes are fitted: skies, studios, rooms and noise, drawn at random. Measured environments stay
//! out, so that errors under them are errors under environments that the fit has not used.

use brdfc_formats::direction::{Vector, dot, normalize};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Number of different kinds.
pub const KINDS: u64 = 4;
/// Exponent below which the light of a soft spot is ignored.
const CUT: f64 = -12.0;

/// A random environment.
#[derive(Debug, Clone)]
pub struct TrainingEnvironment {
    sky: Option<Sky>,
    spots: Vec<Spot>,
    ambient: f64,
}

/// A gradient above the horizon, and ground below it.
#[derive(Debug, Clone, Copy)]
struct Sky {
    zenith: [f64; 3],
    horizon: [f64; 3],
    ground: [f64; 3],
}

/// A round source of light.
#[derive(Debug, Clone, Copy)]
struct Spot {
    towards: Vector,
    /// Radius of a disc, or standard deviation of a soft spot, radians.
    size: f64,
    cosine: f64,
    is_disc: bool,
    radiance: [f64; 3],
}

impl Spot {
    fn new(towards: Vector, degrees: f64, is_disc: bool, radiance: [f64; 3]) -> Self {
        let size = degrees.to_radians();
        Self { towards, size, cosine: size.cos(), is_disc, radiance }
    }
}

impl TrainingEnvironment {
    /// Draws an environment. Its kind is the seed modulo [`KINDS`]: noise of spots of all sizes, a sky with a sun, a
    /// studio with area lights, a room with windows and lamps.
    pub fn new(seed: u64) -> Self {
        let mut random = Random(ChaCha8Rng::seed_from_u64(seed));
        let mut spots = Vec::new();
        let mut sky = None;
        let ambient = match seed % KINDS {
            0 => {
                spots.extend((0..260).map(|_| random.spot(0.05)));
                0.03
            }
            1 => {
                sky = Some(Sky { zenith: [0.1, 0.16, 0.3], horizon: [0.5, 0.52, 0.55], ground: [0.09, 0.08, 0.06] });
                let [x, y, z] = random.direction();
                let sun = normalize([x, 0.15 + 0.8 * y.abs(), z]);
                let degrees = random.between(0.4, 2.0);
                // The same irradiance for each size.
                let strength = 2.0 / (degrees * degrees);
                spots.push(Spot::new(sun, degrees, true, [60.0, 52.0, 40.0].map(|c| c * strength)));
                spots.push(Spot::new(sun, 12.0, false, [0.8, 0.7, 0.5]));
                spots.extend((0..60).map(|_| random.spot(0.03)));
                0.0
            }
            2 => {
                for _ in 0..4 {
                    let [x, y, z] = random.direction();
                    let (degrees, strength) = (random.between(5.0, 22.0), random.between(2.0, 9.0));
                    let tint = [1.0, random.between(0.7, 1.0), random.between(0.55, 1.0)];
                    spots.push(Spot::new([x, y.abs(), z], degrees, true, tint.map(|c| c * strength)));
                }
                spots.extend((0..40).map(|_| random.spot(0.02)));
                0.06
            }
            _ => {
                for _ in 0..6 {
                    let [x, y, z] = random.direction();
                    let (degrees, strength) = (random.between(3.0, 10.0), random.between(1.0, 6.0));
                    let window = normalize([x, 0.4 * y, z]);
                    spots.push(Spot::new(window, degrees, true, [0.85, 0.95, 1.0].map(|c| c * strength)));
                }
                for _ in 0..8 {
                    let [x, y, z] = random.direction();
                    let (degrees, strength) = (random.between(0.7, 2.0), random.between(8.0, 40.0));
                    spots.push(Spot::new([x, y.abs(), z], degrees, true, [1.0, 0.85, 0.6].map(|c| c * strength)));
                }
                spots.extend((0..200).map(|_| random.spot(0.03)));
                0.02
            }
        };
        Self { sky, spots, ambient }
    }

    /// Radiance from a direction of any length but 0, y up.
    pub fn radiance(&self, direction: Vector) -> Vector {
        let towards = normalize(direction);
        let mut sum = [self.ambient; 3];
        if let Some(Sky { zenith, horizon, ground }) = self.sky {
            let height = towards[1].max(0.0).sqrt();
            let above = [0, 1, 2].map(|k| horizon[k] + height * (zenith[k] - horizon[k]));
            let light = if towards[1] > 0.0 { above } else { ground };
            (0..3).for_each(|k| sum[k] += light[k]);
        }
        for spot in &self.spots {
            let cosine = dot(spot.towards, towards);
            let share = if spot.is_disc {
                f64::from(u8::from(cosine > spot.cosine))
            } else {
                let exponent = (cosine - 1.0) / (spot.size * spot.size);
                if exponent > CUT { exponent.exp() } else { 0.0 }
            };
            if share > 0.0 {
                (0..3).for_each(|k| sum[k] += share * spot.radiance[k]);
            }
        }
        sum
    }
}

struct Random(ChaCha8Rng);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// A uniform direction.
    fn direction(&mut self) -> Vector {
        let (y, turn) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - y * y).sqrt();
        [r * turn.cos(), y, r * turn.sin()]
    }

    /// A spot of any size from 0.7 to 40 degrees: smaller ones are brighter, and the brightness varies.
    fn spot(&mut self, scale: f64) -> Spot {
        let towards = self.direction();
        let degrees = self.between(-0.5, 5.3).exp2();
        let is_disc = self.between(0.0, 1.0) < 0.5;
        // Nearly normal, by the sum of twelve uniform numbers.
        let normal = (0..12).map(|_| self.between(0.0, 1.0)).sum::<f64>() - 6.0;
        let strength = (1.2 * normal).exp() * degrees.powf(-0.6) * scale;
        let tint = [0; 3].map(|_| self.between(0.5, 1.0));
        Spot::new(towards, degrees, is_disc, tint.map(|c| c * strength))
    }
}
