//! The split sum of game engines ("Real Shading in Unreal Engine 4", Karis 2013): a diffuse part and a GGX lobe, with one
//! look-up of the irradiance and one of an environment that the lobe of that roughness filters.

use super::least_squares::{Minimum, Solution, non_negative, refine, scan};
use super::lit_balls::{LitBalls, View};
use brdfc_core::analytic::Ggx;
use brdfc_core::{Source, Tally};
use brdfc_environment::{PrefilterError, prefilter};
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot, normalize};
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use brdfc_render::lobe_sampler::low_discrepancy;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Texels along each side of a face of the filtered environment.
const SIDE: u32 = 128;
/// Half vectors of the filter, and of an albedo.
const SAMPLES: [usize; 2] = [64, 1024];
/// Cosines of the view with an albedo.
const VIEWS: usize = 64;
/// Least and most roughness, and the number of steps between them that the fit starts with.
const ALPHAS: ([f64; 2], usize) = ([0.01, 1.0], 16);
/// Mean albedo of a lobe that is left out.
const NEGLIGIBLE: f32 = 5e-3;

/// A model with a diffuse part and an isotropic lobe. Its lobe is that of [`Ggx`], but facets reflect any share at grazing
/// angles, as in engines with a parameter for it ("F90"); Schlick's approximation has 1, which few measured materials reach.
#[derive(Debug, Clone, Copy)]
struct Model {
    /// Diffuse albedo.
    kd: [f64; 3],
    /// Reflectance of facets along the normal, and at grazing angles.
    reflectance: [[f64; 3]; 2],
    /// Roughness.
    alpha: f64,
}

/// The split sum of a model.
#[derive(Debug, Clone)]
pub struct SplitSumMaterial {
    model: Model,
    /// False if the lobe reflects too little for a look-up.
    has_lobe: bool,
    /// Share of uniform light that the lobe reflects, by the cosine of the view.
    albedos: Vec<[f32; 3]>,
}

/// A material in an environment.
#[derive(Debug, Clone)]
pub struct SplitSum<'a> {
    material: &'a SplitSumMaterial,
    irradiance: &'a EnvironmentDecoder,
    filtered: EnvironmentDecoder,
}

impl SplitSumMaterial {
    fn of_model(model: Model) -> Self {
        let reflected =
            |terms: [f32; 2]| [0, 1, 2].map(|k| (0..2).map(|at| model.reflectance[at][k] as f32 * terms[at]).sum());
        let albedos: Vec<[f32; 3]> = albedos(model.alpha).into_iter().map(reflected).collect();
        let mean = |k: usize| albedos.iter().map(|albedo| albedo[k]).sum::<f32>() / VIEWS as f32;
        Self { model, has_lobe: (0..3).any(|k| mean(k) > NEGLIGIBLE), albedos }
    }

    /// Fits the split sum to the light that a material reflects: albedo and reflectances of facets by least squares for
    /// each roughness, as all are linear. An anisotropic material gets one roughness, as engines have one filtered
    /// environment for all directions.
    pub fn fitted(balls: &LitBalls<'_>) -> Self {
        let [irradiance] = balls.columns(|environment, view| [environment.radiance(view.normal, 0.0)]);
        let of = |alpha: f64| -> (f64, Solution) {
            let (albedos, lobe) = (albedos(alpha), lobe(alpha));
            let [along, grazing] = balls.columns(|environment, view| {
                let light = filtered(environment, &lobe, view.mirrored.map(f64::from)).map(|c| c as f32);
                at_cosine(&albedos, view.cosine).map(|albedo| light.map(|c| albedo * c))
            });
            let solution = non_negative(&[&irradiance, &along, &grazing], &balls.target);
            (solution.error, solution)
        };
        let ([least, most], steps) = ALPHAS;
        let ratio = (most / least).powf(1.0 / (steps - 1) as f64);
        let clamped = |alpha: f64| of(alpha.clamp(least, most));
        let Minimum { at, found, .. } = refine(scan([least, most], steps, of), ratio, clamped);
        let reflectance = [found.weights[1], found.weights[2]];
        Self::of_model(Model { kd: found.weights[0], reflectance, alpha: at.clamp(least, most) })
    }

    /// Look-ups in an environment: engines have materials without a lobe.
    pub fn fetches(&self) -> u32 {
        1 + u32::from(self.has_lobe)
    }

    /// Filters an environment with the lobe, seen along the normal.
    ///
    /// # Errors
    /// Returns the errors of [`prefilter`].
    pub fn lit_by<'a>(&'a self, environment: &'a EnvironmentDecoder) -> Result<SplitSum<'a>, PrefilterError> {
        let lobe = lobe(self.model.alpha);
        let radiance = |direction: Vector| filtered(environment, &lobe, direction);
        let filtered = EnvironmentDecoder::new(&prefilter(&radiance, SIDE, 1, &())?);
        Ok(SplitSum { material: self, irradiance: environment, filtered })
    }
}

impl SplitSum<'_> {
    /// Look-ups of a point.
    pub fn fetches(&self) -> u32 {
        self.material.fetches()
    }

    /// Reflected radiance for unit vectors in the frame of the environment, W/(m² sr).
    pub fn radiance(&self, normal: [f32; 3], to_viewer: [f32; 3]) -> [f32; 3] {
        let view = View::new(normal, to_viewer);
        let diffuse = self.irradiance.radiance(normal, 0.0);
        let kd = self.material.model.kd;
        if !self.material.has_lobe {
            return [0, 1, 2].map(|k| kd[k] as f32 * diffuse[k]);
        }
        let specular = self.filtered.radiance(view.mirrored, self.filtered.header().sharpest() as f32);
        let albedo = at_cosine(&self.material.albedos, view.cosine);
        [0, 1, 2].map(|k| kd[k] as f32 * diffuse[k] + albedo[k] * specular[k])
    }
}

/// Albedos of a lobe by the cosine of the view, for facets with a reflectance of 1 along the normal and 0 at grazing angles,
/// and the reverse: Fresnel's law as approximated by Schlick is linear in both.
fn albedos(alpha: f64) -> Vec<[f32; 2]> {
    let facets = [1.0, 0.0].map(|f0| Ggx { kd: [0.0; 3], f0: [f0; 3], alpha_x: alpha, alpha_y: alpha });
    let albedo = |at: usize| {
        let cosine = (at as f64 + 0.5) / VIEWS as f64;
        let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        let mut sums = [0.0; 2];
        for (incoming, inverse_density) in half_vectors(SAMPLES[1], alpha).filter_map(|h| reflected(h, outgoing)) {
            for (sum, facets) in sums.iter_mut().zip(&facets) {
                let value = facets.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default())[0];
                *sum += value * incoming[2] * inverse_density / SAMPLES[1] as f64;
            }
        }
        [sums[0] - sums[1], sums[1]].map(|sum| sum as f32)
    };
    (0..VIEWS).into_par_iter().map(albedo).collect()
}

/// Interpolates a table by the cosine of the view.
fn at_cosine<const N: usize>(table: &[[f32; N]], cosine: f64) -> [f32; N] {
    let position = (cosine * VIEWS as f64 - 0.5).clamp(0.0, (VIEWS - 1) as f64) as f32;
    let lower = (position as usize).min(VIEWS - 2);
    let [low, high] = [table[lower], table[lower + 1]];
    std::array::from_fn(|k| low[k] + (position - lower as f32) * (high[k] - low[k]))
}

/// Directions of the lobe seen along the normal, with the inverse of their density.
fn lobe(alpha: f64) -> Vec<(Vector, f64)> {
    half_vectors(SAMPLES[0], alpha).filter_map(|h| reflected(h, [0.0, 0.0, 1.0])).collect()
}

/// Light that a lobe filters around a direction.
fn filtered(environment: &EnvironmentDecoder, lobe: &[(Vector, f64)], direction: Vector) -> Vector {
    let n = normalize(direction);
    let other = if n[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let t = normalize(cross(other, n));
    let b = cross(n, t);
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for (incoming, inverse_density) in lobe {
        // As many samples as cover the lobe, each with the Gaussian of its solid angle.
        let sharpness = EnvironmentHeader::sharpness((inverse_density / SAMPLES[0] as f64 / TAU).sqrt());
        let world = [0, 1, 2].map(|k| incoming[0] * t[k] + incoming[1] * b[k] + incoming[2] * n[k]);
        let light = environment.radiance(world.map(|c| c as f32), sharpness as f32);
        (0..3).for_each(|k| sum[k] += incoming[2] * f64::from(light[k]));
        total += incoming[2];
    }
    sum.map(|s| s / total)
}

/// Half vectors with the density of the distribution of normals of GGX times their cosine, and that density.
fn half_vectors(count: usize, alpha: f64) -> impl Iterator<Item = (Vector, f64)> {
    (0..count).map(move |index| {
        let [u, v] = low_discrepancy(index, [0.5 / count as f64, 0.0]);
        let squared = (1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u);
        let (cosine, sine, turn) = (squared.sqrt(), (1.0 - squared).max(0.0).sqrt(), TAU * v);
        let width = squared * (alpha * alpha - 1.0) + 1.0;
        let density = alpha * alpha / (0.5 * TAU * width * width) * cosine;
        ([sine * turn.cos(), sine * turn.sin(), cosine], density)
    })
}

/// Direction that a half vector reflects to, and the inverse of its density; `None` below the horizon.
fn reflected((half, density): (Vector, f64), outgoing: Vector) -> Option<(Vector, f64)> {
    let projection = dot(half, outgoing);
    let incoming = [0, 1, 2].map(|k| 2.0 * projection * half[k] - outgoing[k]);
    (projection > 0.0 && incoming[2] > 0.0).then(|| (incoming, 4.0 * projection / density))
}

#[cfg(test)]
mod tests {
    use super::super::testing::balls_of;
    use super::*;

    fn of(kd: f64, f0: f64, alpha: f64) -> (Ggx, SplitSumMaterial) {
        let model = Model { kd: [kd; 3], reflectance: [[f0; 3], [1.0; 3]], alpha };
        (Ggx { kd: [kd; 3], f0: [f0; 3], alpha_x: alpha, alpha_y: alpha }, SplitSumMaterial::of_model(model))
    }

    fn decoder(radiance: impl Fn(Vector) -> Vector + Sync) -> EnvironmentDecoder {
        EnvironmentDecoder::new(&prefilter(&radiance, 64, 1, &()).unwrap())
    }

    /// In uniform light the split sum is exact: it reflects the albedo.
    #[test]
    fn uniform_light_is_reflected_by_the_albedo() {
        let (source, material) = of(0.2, 0.5, 0.2);
        let uniform = decoder(|_| [1.0; 3]);
        let lit = material.lit_by(&uniform).unwrap();
        for cosine in [1.0f64, 0.7, 0.3] {
            let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
            let found = lit.radiance([0.0, 0.0, 1.0], outgoing.map(|c| c as f32));
            // The midpoint rule over the hemisphere.
            let (rings, turns) = (400, 200);
            let mut albedo = 0.0;
            for (ring, turn) in (0..rings).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
                let z = (f64::from(ring) + 0.5) / f64::from(rings);
                let (r, phi) = ((1.0 - z * z).sqrt(), TAU * (f64::from(turn) + 0.5) / f64::from(turns));
                let pair = DirectionPair::new([r * phi.cos(), r * phi.sin(), z], outgoing);
                albedo += source.eval(pair, &mut Tally::default())[0] * z * TAU / f64::from(rings * turns);
            }
            assert!((f64::from(found[0]) - albedo).abs() < 0.02 * albedo, "{cosine}: {} {albedo}", found[0]);
        }
    }

    /// Seen along the normal, the filter is exact, too; at grazing angles the lobe is stretched, which is the known error.
    #[test]
    fn the_filter_is_exact_along_the_normal() {
        let (source, material) = of(0.0, 0.9, 0.3);
        let light = |d: Vector| [1.0 + normalize(d)[0]; 3];
        let environment = decoder(light);
        let lit = material.lit_by(&environment).unwrap();
        let exact = |outgoing: Vector| {
            let all = half_vectors(4096, 0.3).filter_map(|h| reflected(h, outgoing));
            let value = |(incoming, inverse): (Vector, f64)| {
                let f = source.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default())[0];
                f * incoming[2] * inverse * light(incoming)[0]
            };
            all.map(value).sum::<f64>() / 4096.0
        };
        let error = |outgoing: Vector| {
            let found = f64::from(lit.radiance([0.0, 0.0, 1.0], outgoing.map(|c| c as f32))[0]);
            (found / exact(outgoing) - 1.0).abs()
        };
        let (along, grazing) = (error([0.0, 0.0, 1.0]), error([-0.95, 0.0, 0.0975f64.sqrt()]));
        assert!(along < 0.02 && grazing > 2.0 * along, "{along} {grazing}");
    }

    /// The fit to environments recovers a model of the fitted kind, but for what the split sum itself approximates: lobes
    /// are narrower across the plane of view at an angle, which a smaller roughness fits. A matte material has no lobe.
    #[test]
    fn a_model_is_recovered_from_environments() {
        let fit = |address: &str| {
            let mut found = None;
            balls_of(address, |balls| found = Some(SplitSumMaterial::fitted(balls)));
            found.unwrap()
        };
        for alpha in [0.08, 0.2] {
            let found = fit(&format!("synth:ggx?kd=0.3,0.1,0.05&f0=0.06&alpha={alpha}"));
            let Model { kd, reflectance, alpha: narrower } = found.model;
            let near = |found: f64, expected: f64, error: f64| (found - expected).abs() < error;
            assert!(kd.iter().zip([0.3, 0.1, 0.05]).all(|(kd, expected)| near(*kd, expected, 0.03)), "{kd:?}");
            assert!(reflectance[0].iter().all(|f0| near(*f0, 0.06, 0.03)), "{reflectance:?}");
            assert!((0.45..1.1).contains(&(narrower / alpha)) && found.fetches() == 2, "{alpha} {narrower}");
        }
        let matte = fit("synth:lambert?kd=0.6,0.5,0.4");
        assert!((matte.model.kd[1] - 0.5).abs() < 0.01 && matte.fetches() == 1, "{:?}", matte.model);
    }
}
