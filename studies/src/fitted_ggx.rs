//! The alternative to a measured pack: a diffuse part and a GGX lobe, fitted to the same renderings by which packs are
//! judged.

use brdfc_core::analytic::Ggx;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_metrics::lab::lab;
use brdfc_metrics::rendering::rendering_pairs;
use brdfc_metrics::values::values_at;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

/// Diffuse albedo, reflectance of facets, logarithms of roughness along tangent and bitangent.
const PARAMETERS: usize = 8;
type Parameters = SVector<f64, PARAMETERS>;
/// Stride of the pixels that are evaluated.
const EVERY: usize = 11;
/// Initial values of fits: roughness and reflectance.
const STARTS: [(f64, f64); 6] = [(0.03, 0.04), (0.03, 0.5), (0.1, 0.04), (0.1, 0.5), (0.3, 0.04), (0.3, 0.5)];
const STEPS: usize = 60;

/// The model whose renderings are closest to those of `source` by the squares of ΔE (CIE76), by the Levenberg-Marquardt
/// method from several starts. `exposure` is that of the renderings.
pub(crate) fn fitted_ggx(source: &dyn Source, exposure: f64) -> Ggx {
    let pairs: Vec<DirectionPair> = rendering_pairs().iter().copied().step_by(EVERY).collect();
    let (values, _) = values_at(source, &pairs);
    let shown = |f: [f64; 3], pair: &DirectionPair| lab(f.map(|f| (f * pair.incoming[2] * exposure) as f32));
    let colours: Vec<[f32; 3]> = values.iter().zip(&pairs).map(|(f, pair)| shown(*f, pair)).collect();
    let isotropic = source.symmetry().isotropic;
    let residuals = |parameters: &Parameters| -> Vec<f64> {
        let ggx = model(parameters, isotropic);
        let of = |(pair, colour): (&DirectionPair, &[f32; 3])| {
            let found = shown(ggx.eval(*pair, &mut Tally::default()), pair);
            std::array::from_fn::<f64, 3, _>(|c| f64::from(found[c] - colour[c]))
        };
        pairs.par_iter().zip(&colours).flat_map_iter(of).collect()
    };
    let fits = STARTS.into_iter().map(|(alpha, f0): (f64, f64)| {
        let start = [0.3, 0.3, 0.3, f0.sqrt(), f0.sqrt(), f0.sqrt(), alpha.ln(), alpha.ln()];
        descended(Parameters::from(start), &residuals)
    });
    let best = fits.min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are starts").0;
    model(&best, isotropic)
}

/// Squares ensure that albedo and reflectance are positive, exponentials that the roughness is.
fn model(parameters: &Parameters, isotropic: bool) -> Ggx {
    let p = parameters;
    let [alpha_x, alpha_y] = [p[6], p[7]].map(|v| v.exp().clamp(0.001, 1.0));
    Ggx {
        kd: [p[0], p[1], p[2]].map(|v| v * v),
        f0: [p[3], p[4], p[5]].map(|v| v * v),
        alpha_x,
        alpha_y: if isotropic { alpha_x } else { alpha_y },
    }
}

/// The end of a descent, with the sum of squares there.
fn descended(mut at: Parameters, residuals: &impl Fn(&Parameters) -> Vec<f64>) -> (Parameters, f64) {
    const STEP: f64 = 1e-3;
    let sum = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
    let mut here = residuals(&at);
    let mut error = sum(&here);
    let mut damping = 1e-2;
    for _ in 0..STEPS {
        let slopes: Vec<Vec<f64>> = (0..PARAMETERS)
            .map(|k| {
                let mut moved = at;
                moved[k] += STEP;
                residuals(&moved).iter().zip(&here).map(|(there, here)| (there - here) / STEP).collect()
            })
            .collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let normal = SMatrix::<f64, PARAMETERS, PARAMETERS>::from_fn(|a, b| product(&slopes[a], &slopes[b]));
        let right = Parameters::from_fn(|a, _| product(&slopes[a], &here));
        let before = error;
        while damping < 1e8 {
            let mut damped = normal;
            for k in 0..PARAMETERS {
                damped[(k, k)] += damping * (normal[(k, k)] + 1e-6);
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&right)) else { break };
            let there = residuals(&(at - step));
            if sum(&there) < error {
                (at, error, here) = (at - step, sum(&there), there);
                damping *= 0.2;
                break;
            }
            damping *= 5.0;
        }
        if error > 0.9999 * before {
            break;
        }
    }
    (at, error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;

    /// The fit recovers a model of the fitted kind.
    #[test]
    fn a_ggx_is_recovered() {
        let source = parse_synth("synth:ggx?kd=0.3,0.1,0.05&f0=0.06&alpha=0.15").unwrap();
        let found = fitted_ggx(source.as_ref(), 2.0);
        for (found, expected) in found.kd.into_iter().zip([0.3, 0.1, 0.05]) {
            assert!((found - expected).abs() < 2e-3, "{found} {expected}");
        }
        assert!((found.alpha_x - 0.15).abs() < 2e-3 && (found.f0[0] - 0.06).abs() < 2e-3, "{found:?}");
        assert_eq!(found.alpha_x, found.alpha_y);
        let source = parse_synth("synth:ggx?kd=0.1&f0=0.5&alpha_x=0.1&alpha_y=0.4").unwrap();
        let found = fitted_ggx(source.as_ref(), 0.5);
        assert!((found.alpha_x - 0.1).abs() < 3e-3 && (found.alpha_y - 0.4).abs() < 1e-2, "{found:?}");
    }
}
