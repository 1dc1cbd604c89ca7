//! The split sum of game engines ("Real Shading in Unreal Engine 4", Karis 2013): a diffuse part and a GGX lobe, with one
//! look-up of the irradiance and one of an environment that the lobe of that roughness filters.

use crate::fitted_ggx::fitted_ggx;
use brdfc_core::analytic::Ggx;
use brdfc_core::{Source, Tally};
use brdfc_environment::{PrefilterError, prefilter};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot, normalize};
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use brdfc_metrics::rendering::ReferenceRendering;
use brdfc_render::lobe_sampler::low_discrepancy;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Texels along each side of a face of the filtered environment.
const SIDE: u32 = 128;
/// Half vectors of the filter, and of an albedo.
const SAMPLES: [usize; 2] = [64, 1024];
/// Cosines of the view with an albedo.
const VIEWS: usize = 64;

/// The model of a material that is closest to it in renderings under point lights, as its split sum.
#[derive(Debug, Clone)]
pub struct SplitSumMaterial {
    model: Ggx,
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
    /// Look-ups in an environment.
    pub const FETCHES: u32 = 2;

    /// Fits the model. The lobe of an anisotropic material gets the mean roughness of both axes, as engines have one
    /// filtered environment for all directions.
    pub fn new(source: &dyn Source) -> Self {
        let (reference, _) = ReferenceRendering::new(source, DirectionRange::ALL);
        let fitted = fitted_ggx(source, reference.exposure());
        let alpha = (fitted.alpha_x * fitted.alpha_y).sqrt();
        let model = Ggx { alpha_x: alpha, alpha_y: alpha, ..fitted };
        let lobe = Ggx { kd: [0.0; 3], ..model };
        let albedo = |at: usize| {
            let cosine = (at as f64 + 0.5) / VIEWS as f64;
            let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
            let mut sum = [0.0; 3];
            for (incoming, inverse_density) in half_vectors(SAMPLES[1], alpha).filter_map(|h| reflected(h, outgoing)) {
                let value = lobe.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default());
                (0..3).for_each(|k| sum[k] += value[k] * incoming[2] * inverse_density);
            }
            sum.map(|s| (s / SAMPLES[1] as f64) as f32)
        };
        Self { model, albedos: (0..VIEWS).into_par_iter().map(albedo).collect() }
    }

    /// Filters an environment with the lobe, seen along the normal.
    ///
    /// # Errors
    /// Returns the errors of [`prefilter`].
    pub fn lit_by<'a>(&'a self, environment: &'a EnvironmentDecoder) -> Result<SplitSum<'a>, PrefilterError> {
        let lobe: Vec<(Vector, f64)> =
            half_vectors(SAMPLES[0], self.model.alpha_x).filter_map(|h| reflected(h, [0.0, 0.0, 1.0])).collect();
        let radiance = |direction: Vector| {
            let n = normalize(direction);
            let other = if n[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
            let t = normalize(cross(other, n));
            let b = cross(n, t);
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for (incoming, inverse_density) in &lobe {
                // As many samples as cover the lobe, each with the Gaussian of its solid angle.
                let sharpness = EnvironmentHeader::sharpness((inverse_density / SAMPLES[0] as f64 / TAU).sqrt());
                let world = [0, 1, 2].map(|k| incoming[0] * t[k] + incoming[1] * b[k] + incoming[2] * n[k]);
                let light = environment.radiance(world.map(|c| c as f32), sharpness as f32);
                (0..3).for_each(|k| sum[k] += incoming[2] * f64::from(light[k]));
                total += incoming[2];
            }
            sum.map(|s| s / total)
        };
        let filtered = EnvironmentDecoder::new(&prefilter(&radiance, SIDE, 1, &())?);
        Ok(SplitSum { material: self, irradiance: environment, filtered })
    }
}

impl SplitSum<'_> {
    /// Reflected radiance for unit vectors in the frame of the environment, W/(m² sr).
    pub fn radiance(&self, normal: [f32; 3], to_viewer: [f32; 3]) -> [f32; 3] {
        let cosine = dot(normal.map(f64::from), to_viewer.map(f64::from));
        let mirrored = [0, 1, 2].map(|k| (2.0 * cosine * f64::from(normal[k]) - f64::from(to_viewer[k])) as f32);
        let position = (cosine.clamp(0.0, 1.0) * VIEWS as f64 - 0.5).clamp(0.0, (VIEWS - 1) as f64) as f32;
        let lower = (position as usize).min(VIEWS - 2);
        let [low, high] = [self.material.albedos[lower], self.material.albedos[lower + 1]];
        let diffuse = self.irradiance.radiance(normal, 0.0);
        let specular = self.filtered.radiance(mirrored, self.filtered.header().sharpest() as f32);
        [0, 1, 2].map(|k| {
            let albedo = low[k] + (position - lower as f32) * (high[k] - low[k]);
            self.material.model.kd[k] as f32 * diffuse[k] + albedo * specular[k]
        })
    }
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
    use super::*;
    use brdfc_core::address::parse_synth;

    fn decoder(radiance: impl Fn(Vector) -> Vector + Sync) -> EnvironmentDecoder {
        EnvironmentDecoder::new(&prefilter(&radiance, 64, 1, &()).unwrap())
    }

    /// In uniform light the split sum is exact: it reflects the albedo.
    #[test]
    fn uniform_light_is_reflected_by_the_albedo() {
        let source = parse_synth("synth:ggx?kd=0.2&f0=0.5&alpha=0.2").unwrap();
        let material = SplitSumMaterial::new(source.as_ref());
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
        let source = parse_synth("synth:ggx?kd=0&f0=0.9&alpha=0.3").unwrap();
        let material = SplitSumMaterial::new(source.as_ref());
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
}
