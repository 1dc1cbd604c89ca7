//! The integral of a BRDF over an environment, for one view: directions with weights.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector};
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use std::f64::consts::{PI, TAU};

/// Radius of the innermost ring around the mirror direction, radians.
const FIRST_RING: f64 = 0.04 * PI / 180.0;
/// Smallest deviation of the slopes of half vectors.
const MIN_SLOPE: f64 = 1e-3;
/// Share of a lobe's sum below which a direction is left out.
const NEGLIGIBLE: f64 = 1e-7;

/// Number of rings around the mirror direction, and of directions on each.
#[derive(Debug, Clone, Copy)]
pub struct Resolution {
    /// Rings, with radii that grow geometrically.
    pub rings: usize,
    /// Directions per ring, an even number.
    pub azimuths: usize,
}

/// `f_r cos θ dω` for directions around the mirror direction of a view.
pub struct Reflection {
    samples: Vec<Sample>,
}

struct Sample {
    direction: Vector,
    weight: [f64; 3],
    /// Standard deviation of the cell of the sample, radians.
    deviation: f64,
    /// Sharpness of look-ups for this deviation.
    sharpness: f32,
}

impl Reflection {
    /// Samples a source for an outgoing unit vector. Negative values become 0.
    pub fn new(source: &dyn Source, outgoing: Vector, resolution: Resolution, tally: &mut Tally) -> Self {
        let [x, y, cosine] = outgoing;
        let sine = x.hypot(y);
        let [c, s] = if sine > 0.0 { [x / sine, y / sine] } else { [1.0, 0.0] };
        // From the plane of view to tangent and bitangent.
        let turned = |[u, v, w]: Vector| [c * u - s * v, s * u + c * v, w];
        // The plane of view is a plane of symmetry of isotropic materials.
        let is_isotropic = source.symmetry().isotropic;
        let turns = if is_isotropic { resolution.azimuths / 2 } else { resolution.azimuths };
        let (mirror, along) = ([-sine, 0.0, cosine], [cosine, 0.0, sine]);
        let border = |ring: usize| match ring {
            0 => 0.0,
            _ => FIRST_RING * (PI / FIRST_RING).powf((ring - 1) as f64 / (resolution.rings - 1) as f64),
        };
        let mut samples = Vec::new();
        for ring in 0..resolution.rings {
            let (inner, outer) = (border(ring), border(ring + 1));
            let (radius, solid_angle) =
                (0.5 * (inner + outer), (inner.cos() - outer.cos()) * TAU / resolution.azimuths as f64);
            for azimuth in 0..turns {
                let turn = (azimuth as f64 + 0.5) / resolution.azimuths as f64 * TAU;
                let at = |k: usize| radius.cos() * mirror[k] + radius.sin() * turn.cos() * along[k];
                let incoming = [at(0), radius.sin() * turn.sin(), at(2)];
                if incoming[2] <= 0.0 {
                    continue;
                }
                let value = source.eval(DirectionPair::new(turned(incoming), outgoing), tally);
                let weight = value.map(|v| v.max(0.0) * incoming[2] * solid_angle);
                let deviation = 0.5 * solid_angle.sqrt();
                let sharpness = EnvironmentHeader::sharpness(deviation) as f32;
                let mirrored = [incoming[0], -incoming[1], incoming[2]];
                let both = [incoming, mirrored].into_iter().take(if is_isotropic { 2 } else { 1 });
                samples.extend(both.map(|direction| Sample {
                    direction: turned(direction),
                    weight,
                    deviation,
                    sharpness,
                }));
            }
        }
        let sum = |sample: &Sample| sample.weight.iter().sum::<f64>();
        let total: f64 = samples.iter().map(sum).sum();
        samples.retain(|sample| sum(sample) > NEGLIGIBLE * total);
        Self { samples }
    }

    /// Reflected share of uniform light: the directional albedo.
    pub fn albedo(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.samples.iter().map(|sample| sample.weight[k]).sum())
    }

    /// Standard deviation of a Gaussian with the same peak and sum, radians; `None` for black.
    pub fn width(&self) -> Option<f64> {
        let density = |sample: &Sample| sample.weight.iter().sum::<f64>() / (4.0 * sample.deviation * sample.deviation);
        let peak = self.samples.iter().map(density).fold(0.0, f64::max);
        let total: f64 = self.albedo().iter().sum();
        (total > 0.0).then(|| (total / peak / TAU).sqrt())
    }

    /// Slopes of half vectors, for a reflection towards the normal; `None` for black.
    pub fn slopes(&self) -> Option<Slopes> {
        let (mut sums, mut total) = ([0.0; 3], 0.0);
        for Sample { direction: [x, y, z], weight, deviation, .. } in &self.samples {
            let [u, v] = [x, y].map(|c| c / (1.0 + z));
            // Squares of densities: the square of a Gaussian has half its variance, and a diffuse share hardly counts.
            let weight = (weight.iter().sum::<f64>() / deviation).powi(2);
            [u * u, u * v, v * v].into_iter().zip(&mut sums).for_each(|(product, sum)| *sum += 2.0 * weight * product);
            total += weight;
        }
        let [xx, xy, yy] = sums.map(|sum| sum / total);
        let (mean, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let deviations = [mean + half, mean - half].map(|variance| variance.max(0.0).sqrt().max(MIN_SLOPE));
        (total > 0.0).then(|| Slopes { deviations, angle: 0.5 * (2.0 * xy).atan2(xx - yy) })
    }

    /// Reflected radiance in a local frame of tangent, bitangent and normal.
    pub fn radiance(&self, environment: &EnvironmentDecoder, frame: &Frame) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for Sample { direction, weight, sharpness, .. } in &self.samples {
            let light = environment.radiance(frame.world(direction.map(|c| c as f32)), *sharpness);
            (0..3).for_each(|k| sum[k] += weight[k] * f64::from(light[k]));
        }
        sum
    }
}

/// Distribution of the half vectors of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slopes {
    /// Standard deviations along the long and the short axis.
    pub deviations: [f64; 2],
    /// Angle of the long axis from the tangent, radians.
    pub angle: f64,
}

/// A frame of tangent, bitangent and normal in an environment.
#[derive(Debug, Clone, Copy)]
pub struct Frame([[f32; 3]; 3]);

impl Frame {
    /// Frame of three orthogonal unit vectors.
    pub fn new(axes: [Vector; 3]) -> Self {
        Self(axes.map(|axis| axis.map(|c| c as f32)))
    }

    /// Tangent, bitangent and normal.
    pub fn axes(&self) -> [[f32; 3]; 3] {
        self.0
    }

    /// Converts a local direction to the frame of the environment.
    pub fn world(&self, local: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| (0..3).map(|axis| local[axis] * self.0[axis][k]).sum())
    }
}
