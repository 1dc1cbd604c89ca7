//! Spherical Gaussians ("All-frequency rendering of dynamic, spatially-varying reflectance", Wang, Ren, Gong, Snyder and Guo
//! 2009): a diffuse part, and microfacets whose half vectors are distributed as a sum of Gaussians. Each Gaussian is warped
//! to incoming directions; Fresnel's law, shadowing and cosine are those at its centre. A look-up in the prefiltered
//! environment of the same width integrates it.

use super::least_squares::{Column, Minimum, Solution, non_negative, refine, scan};
use super::lit_balls::{LitBalls, View};
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};

/// Maximum number of Gaussians.
const MAX_LOBES: usize = 4;
/// Least and most standard deviation of half vectors, radians, and the number of steps between them that the fit tries.
const WIDTHS: ([f64; 2], usize) = ([0.005, 0.8], 32);
/// Rounds in which all widths move.
const ROUNDS: usize = 3;
/// Variance of the Gaussian with the mean direction of the cosine around the normal, square radians.
const COSINE_VARIANCE: f64 = 1.0 / 3.0;
/// Weight below which a term is left out.
const NEGLIGIBLE: f64 = 1e-3;

/// A material as a sum of spherical Gaussians.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussians {
    /// Diffuse albedo; black if no look-up of the irradiance is needed.
    diffuse: [f64; 3],
    lobes: Vec<Gaussian>,
}

/// Microfacets whose half vectors `h` have the density `exp((n·h - 1) / width²)`, normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gaussian {
    /// Standard deviation of half vectors, radians.
    width: f64,
    /// Reflectance of facets along the normal, and at grazing angles.
    reflectance: [[f64; 3]; 2],
}

impl Gaussians {
    /// Fits 1, 2, 3 and 4 Gaussians to the light that a material reflects: widths by a search, one after the other, and
    /// reflectances by least squares.
    pub fn fitted(balls: &LitBalls<'_>) -> Vec<Self> {
        let [diffuse] = balls.columns(|environment, view| [environment.radiance(view.normal, 0.0)]);
        let (range, steps) = WIDTHS;
        let ratio = (range[1] / range[0]).powf(1.0 / (steps - 1) as f64);
        let mut lobes: Vec<(f64, [Column; 2])> = Vec::new();
        let mut all: Vec<Self> = Vec::new();
        for _ in 0..MAX_LOBES {
            let columns = |width: f64| balls.columns(|environment, view| terms(environment, view, width));
            let error = |lobes: &[(f64, [Column; 2])], skipped: usize, new: &[Column; 2]| {
                let others = lobes.iter().enumerate().filter(|(at, _)| *at != skipped).map(|(_, (_, columns))| columns);
                solved(&diffuse, others.chain([new]), &balls.target).error
            };
            let added = scan(range, steps, |width| {
                let new = columns(width);
                (error(&lobes, usize::MAX, &new), new)
            });
            lobes.push((added.at, added.found));
            let count = lobes.len();
            for at in (0..ROUNDS).flat_map(|_| 0..count) {
                let (width, found) = lobes[at].clone();
                let here = Minimum { at: width, error: error(&lobes, at, &found), found };
                let moved = refine(here, ratio, |width| {
                    let new = columns(width);
                    (error(&lobes, at, &new), new)
                });
                lobes[at] = (moved.at, moved.found);
            }
            let solution = solved(&diffuse, lobes.iter().map(|(_, columns)| columns), &balls.target);
            all.push(Self::of(&solution, lobes.iter().map(|(width, _)| *width)));
        }
        all.dedup();
        all
    }

    fn of(solution: &Solution, widths: impl Iterator<Item = f64>) -> Self {
        let is_negligible = |weight: &[f64; 3]| weight.iter().all(|w| *w < NEGLIGIBLE);
        let (diffuse, weights) = solution.weights.split_first().expect("the diffuse part is the first");
        let lobe = |(width, weights): (f64, &[[f64; 3]])| Gaussian { width, reflectance: [weights[0], weights[1]] };
        Self {
            diffuse: if is_negligible(diffuse) { [0.0; 3] } else { *diffuse },
            lobes: widths
                .zip(weights.chunks_exact(2))
                .map(lobe)
                .filter(|lobe| !lobe.reflectance.iter().all(is_negligible))
                .collect(),
        }
    }

    /// Look-ups in an environment.
    pub fn fetches(&self) -> usize {
        usize::from(self.diffuse != [0.0; 3]) + self.lobes.len()
    }

    /// Reflected radiance for unit vectors in the frame of the environment, W/(m² sr).
    pub fn radiance(&self, environment: &EnvironmentDecoder, normal: [f32; 3], to_viewer: [f32; 3]) -> [f32; 3] {
        let view = View::new(normal, to_viewer);
        let mut sum = [0.0; 3];
        let mut add = |light: [f32; 3], weight: [f64; 3]| (0..3).for_each(|k| sum[k] += weight[k] as f32 * light[k]);
        if self.diffuse != [0.0; 3] {
            add(environment.radiance(normal, 0.0), self.diffuse);
        }
        for lobe in &self.lobes {
            let terms = terms(environment, &view, lobe.width);
            terms.into_iter().zip(lobe.reflectance).for_each(|(light, weight)| add(light, weight));
        }
        sum
    }
}

fn solved<'a>(diffuse: &'a Column, lobes: impl Iterator<Item = &'a [Column; 2]>, target: &Column) -> Solution {
    let columns: Vec<&Column> = std::iter::once(diffuse).chain(lobes.flatten()).collect();
    non_negative(&columns, target)
}

/// Light that a Gaussian of half vectors reflects, by facets with a reflectance of 1 along the normal and 0 at grazing
/// angles (Schlick 1994), and the reverse.
fn terms(environment: &EnvironmentDecoder, view: &View, width: f64) -> [[f32; 3]; 2] {
    // At the centre, the half vector is the normal, and the light comes from the mirror direction.
    let cosine = view.cosine.max(1e-3);
    let variance = warped(width * width, cosine);
    let light = environment.radiance(view.mirrored, sharpness(variance));
    // f cos θ = D G F / (4 cos θ), and the warp to incoming directions turns 4 cos θ into the larger solid angle. The
    // distribution is normalised over the sphere.
    let share = shadowing(width, cosine) * (1.0 - (-2.0 / variance).exp());
    let schlick = (1.0 - cosine).powi(5);
    [1.0 - schlick, schlick].map(|fresnel| light.map(|c| (share * fresnel) as f32 * c))
}

/// Variance of the warped Gaussian: `4 h·o` times as large a solid angle (Wang et al. 2009, section 3).
fn warped(variance: f64, cosine: f64) -> f64 {
    4.0 * cosine * variance
}

/// Share of facets that are visible to both sides, `1 / (1 + Λ(i) + Λ(o))` for the mirror direction (Smith, for the
/// distribution of Trowbridge and Reitz with as steep a slope at the normal).
fn shadowing(width: f64, cosine: f64) -> f64 {
    let alpha_squared = 2.0 * width * width;
    let squared = cosine * cosine;
    (squared / (squared + alpha_squared * (1.0 - squared))).sqrt()
}

/// Sharpness of the look-up of a Gaussian: that of its level, or between the coarsest level and the irradiance.
fn sharpness(variance: f64) -> f32 {
    let coarsest = EnvironmentHeader::deviation(1.0).powi(2);
    let share = (variance - coarsest) / (COSINE_VARIANCE - coarsest);
    if share > 0.0 { (1.0 - share).max(0.0) as f32 } else { EnvironmentHeader::sharpness(variance.sqrt()) as f32 }
}

#[cfg(test)]
mod tests {
    use super::super::testing::balls_of;
    use super::*;
    use brdfc_environment::prefilter;
    use brdfc_formats::direction::{Vector, dot, normalize};
    use std::f64::consts::TAU;

    /// Mirror reflectance of 1 along the normal and at grazing angles.
    fn white(width: f64) -> Gaussians {
        Gaussians { diffuse: [0.0; 3], lobes: vec![Gaussian { width, reflectance: [[1.0; 3]; 2] }] }
    }

    /// Microfacets without shadows under a light, by the sum over half vectors.
    fn exact(width: f64, outgoing: Vector, light: &dyn Fn(Vector) -> f64) -> f64 {
        let (rings, turns) = (400, 120);
        let mut sum = 0.0;
        for (ring, turn) in (0..rings).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
            let angle = (f64::from(ring) + 0.5) / f64::from(rings) * (6.0 * width);
            let phi = (f64::from(turn) + 0.5) / f64::from(turns) * TAU;
            let half = [angle.sin() * phi.cos(), angle.sin() * phi.sin(), angle.cos()];
            let solid_angle = angle.sin() * 6.0 * width / f64::from(rings) * TAU / f64::from(turns);
            let distribution = ((half[2] - 1.0) / (width * width)).exp() / (TAU * width * width);
            let projection = dot(half, outgoing);
            let incoming = [0, 1, 2].map(|k| 2.0 * projection * half[k] - outgoing[k]);
            // dω_i = 4 h·o dω_h.
            sum += light(incoming) * distribution * projection / outgoing[2] * solid_angle;
        }
        sum
    }

    /// A narrow Gaussian of half vectors reflects what a look-up of the warped width has. The control does not warp it.
    #[test]
    fn warped_gaussians_integrate_microfacets() {
        let lamp = normalize([-0.3, 0.1, 1.0]);
        let light = |d: Vector| ((dot(normalize(d), lamp) - 1.0) / 0.02).exp();
        let environment = EnvironmentDecoder::new(&prefilter(&|d| [light(d); 3], 128, 1, &()).unwrap());
        let width = 0.1;
        for outgoing in [normalize([0.3, -0.1, 1.0]), normalize([0.5, 0.0, 1.0])] {
            let expected = exact(width, outgoing, &light) * shadowing(width, outgoing[2]);
            let up = [0.0, 0.0, 1.0];
            let found = f64::from(white(width).radiance(&environment, up, outgoing.map(|c| c as f32))[0]);
            assert!((found / expected - 1.0).abs() < 0.1, "{outgoing:?}: {found} {expected}");
            let unwarped = f64::from(white(0.5 * width).radiance(&environment, up, outgoing.map(|c| c as f32))[0]);
            assert!((unwarped / expected - 1.0).abs() > 0.2, "{outgoing:?}: {unwarped} {expected}");
        }
    }

    /// White facets reflect no more uniform light than arrives, and nearly all of it along the normal.
    #[test]
    fn no_energy_is_gained() {
        let uniform = EnvironmentDecoder::new(&prefilter(&|_| [1.0; 3], 64, 1, &()).unwrap());
        for width in [0.01, 0.1, 0.4] {
            for cosine in [1.0f64, 0.6, 0.2, 0.01] {
                let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine].map(|c| c as f32);
                let found = white(width).radiance(&uniform, [0.0, 0.0, 1.0], outgoing)[0];
                assert!((0.0..=1.0 + 1e-4).contains(&found), "{width} {cosine}: {found}");
                assert!(cosine < 1.0 || found > 0.95, "{width}: {found}");
            }
        }
    }

    /// More Gaussians are closer to the tails of a GGX lobe, and its diffuse part is recovered.
    #[test]
    fn the_tails_of_a_lobe_need_several_gaussians() {
        balls_of("synth:ggx?kd=0.3,0.1,0.05&f0=0.06&alpha=0.15", |balls| {
            let error = |gaussians: &Gaussians| {
                let [found] = balls.columns(|environment, view| {
                    let mut sum = environment.radiance(view.normal, 0.0);
                    (0..3).for_each(|k| sum[k] *= gaussians.diffuse[k] as f32);
                    for lobe in &gaussians.lobes {
                        for (light, weight) in terms(environment, view, lobe.width).iter().zip(lobe.reflectance) {
                            (0..3).for_each(|k| sum[k] += light[k] * weight[k] as f32);
                        }
                    }
                    [sum]
                });
                let of = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>();
                found.iter().zip(&balls.target).map(of).sum::<f64>()
            };
            let all = Gaussians::fitted(balls);
            let errors: Vec<f64> = all.iter().map(error).collect();
            assert!(errors.len() > 1 && errors[errors.len() - 1] < 0.93 * errors[0], "{errors:?}");
            assert!(errors.windows(2).all(|pair| pair[1] < 1.01 * pair[0]), "{errors:?}");
            // One Gaussian of 1.4 times the slope's deviation is nearly as wide as the lobe.
            let narrow = all[0].lobes[0].width;
            assert!((0.06..0.2).contains(&narrow), "{narrow}");
            let diffuse = all[all.len() - 1].diffuse;
            assert!((diffuse[1] - 0.1).abs() < 0.02 && all[0].fetches() == 2, "{diffuse:?}");
        });
    }
}
