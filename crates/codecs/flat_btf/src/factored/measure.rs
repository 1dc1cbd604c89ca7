//! Errors of a factored flat BTF against the original values: decoded as in shaders, at texels outside the fit.

use super::residual::Shares;
use super::sample::Sample;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{FactoredErrors, FactoredFlatBtf};
use brdfc_metrics::lab::{distance_squared, lab};
use rayon::prelude::*;

/// Errors at the texels of a sample with these shares; the k-th of them is the texel `place(k)` of the asset. Lights reach
/// texels as in the shares, not as rays through layers do.
pub(super) fn errors(
    asset: &FactoredFlatBtf,
    sample: &Sample,
    count: usize,
    place: impl Fn(usize) -> [u32; 2] + Sync,
    shares: &Shares,
) -> FactoredErrors {
    let (views, lights) = (sample.views.len(), sample.lights);
    let of_texel = |k: usize| -> Vec<f32> {
        let texel = asset.texel(place(k));
        let difference = |pair: usize| {
            let (view, light) = (pair / lights, pair % lights);
            let expected = rgb9e5::decode(sample.word(k, view, light));
            let (lit, shaded) = (shares.lit_roots[k * lights + light].powi(3), shares.shaded[k * lights + light]);
            let (value, diffuse) = (texel.value(view as u32, light as u32), texel.base().diffuse);
            let found = [0, 1, 2].map(|c: usize| lit * value[c] + shaded * diffuse[c]);
            distance_squared(lab(found), lab(expected)).sqrt()
        };
        (0..views * lights).map(difference).collect()
    };
    let mut all: Vec<f32> = (0..count).into_par_iter().map(of_texel).collect::<Vec<_>>().concat();
    let is_seen = |at: usize| sample.masks.is_seen(at / (views * lights), at / lights % views);
    let seen: Vec<f32> = (0..all.len()).filter(|at| is_seen(*at)).map(|at| all[at]).collect();
    summary(count, seen, &mut all)
}

/// Summary of differences at a number of texels, where views see them and everywhere.
pub(super) fn summary(texels: usize, mut seen: Vec<f32>, all: &mut [f32]) -> FactoredErrors {
    let mean = |values: &[f32]| {
        (values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len().max(1) as f64) as f32
    };
    let (seen_mean, all_mean) = (mean(&seen), mean(all));
    FactoredErrors {
        texels: texels as u32,
        seen_mean,
        seen_p95: quantile(&mut seen, 0.95),
        seen_max: seen.iter().copied().fold(0.0, f32::max),
        all_mean,
        all_p95: quantile(all, 0.95),
    }
}

/// Quantile of some values at `share`; 0 if there are none.
fn quantile(values: &mut [f32], share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() as f64 * share) as usize).min(values.len() - 1);
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles() {
        let mut values: Vec<f32> = (0..100).map(|k| ((k * 37) % 100) as f32).collect();
        assert_eq!((quantile(&mut values, 0.95), quantile(&mut values, 0.0), quantile(&mut [], 0.5)), (95.0, 0.0, 0.0));
    }
}
