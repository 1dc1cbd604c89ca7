//! Measures every setting on one material.

use super::settings::{WaveletSetting, cost};
use super::{ParetoMaterial, ParetoRow};
use crate::timing::best_of;
use brdfc_core::{PackSource, Source};
use brdfc_formats::wavelet::Filter;
use brdfc_jobs::encode::{EncodeError, EncodedPack, PackRecipe, encode};
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use std::time::Instant;

/// Shorter encodes, in seconds, are repeated up to a maximum number of times.
const SHORT: f64 = 0.5;
const MAX_RUNS: usize = 3;
/// Number of pairs decoded per run, and number of runs.
const PAIRS: usize = 1 << 13;
const DECODE_RUNS: usize = 3;
const SEED: u64 = 11;

/// Measures every setting on one material. Calls `done` with the finished share of the material.
///
/// # Errors
/// Returns an error if no pack can be made of the source.
pub fn pareto(
    name: &str,
    source: &dyn Source,
    settings: &[PackRecipe],
    done: &dyn Fn(f64),
) -> Result<ParetoMaterial, EncodeError> {
    let reference = Reference::new(source, PairSet::comparison());
    let pairs = random_pairs(PAIRS, SEED);
    let all: f64 = settings.iter().map(cost).sum();
    let mut so_far = 0.0;
    let mut rows = Vec::with_capacity(settings.len());
    for recipe in settings {
        let (made, encode_seconds, runs) = timed(source, &recipe.clone().without_measuring())?;
        let decoder = made.pack.decoder();
        let level = decoder.levels() as f32;
        let decode = || pairs.iter().map(|pair| decoder.eval(*pair, level, Filter::Bilinear)[0]).sum::<f32>();
        let error = reference.compare(&PackSource::new(&*made.pack, None));
        let wavelet = match recipe {
            PackRecipe::Wavelet(recipe) => WaveletSetting::of(recipe),
            _ => None,
        };
        rows.push(ParetoRow {
            codec: made.codec.variant().to_owned(),
            setting: wavelet.map_or_else(|| made.codec.size(), |setting| setting.to_string()),
            wavelet,
            bytes_on_gpu: made.pack.gpu_bytes(),
            bytes_on_disk: made.bytes.len() as u64,
            fetches: made.pack.fetches(),
            encode_seconds,
            runs,
            decode_rate: PAIRS as f64 / best_of(DECODE_RUNS, decode),
            delta_e: error.rendering.delta_e.mean,
            delta_e_p95: error.rendering.delta_e.p95,
            relative_error: error.norms.relative_mean,
            on_bytes_front: false,
            on_seconds_front: false,
        });
        so_far += cost(recipe);
        done(so_far / all);
    }
    Ok(ParetoMaterial::marked(name, rows))
}

/// A pack, the seconds of its shortest run, and the number of runs.
fn timed(source: &dyn Source, recipe: &PackRecipe) -> Result<(EncodedPack, f64, usize), EncodeError> {
    let (mut shortest, mut all, mut runs) = (f64::INFINITY, 0.0, 0);
    loop {
        let start = Instant::now();
        let made = encode(source, recipe, &())?;
        let seconds = start.elapsed().as_secs_f64();
        (shortest, all, runs) = (shortest.min(seconds), all + seconds, runs + 1);
        if runs == MAX_RUNS || all >= SHORT {
            return Ok((made, shortest, runs));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::settings;
    use super::*;
    use brdfc_core::address::parse_synth;
    use std::cell::Cell;

    #[test]
    fn larger_packs_are_closer_and_fronts_are_marked() {
        let source = parse_synth("synth:ggx?alpha=0.3").unwrap();
        let reported = Cell::new(0.0);
        let done = |share: f64| {
            assert!(share > reported.get() && share < 1.0 + 1e-9);
            reported.set(share);
        };
        let settings = settings(true);
        let study = pareto("ggx", source.as_ref(), &settings, &done).unwrap();
        assert!((reported.get() - 1.0).abs() < 1e-9 && study.rows.len() == settings.len());
        let tables: Vec<&ParetoRow> = study.rows.iter().filter(|row| row.codec == "table").collect();
        assert!(
            tables
                .windows(2)
                .all(|pair| { pair[0].bytes_on_gpu < pair[1].bytes_on_gpu && pair[0].delta_e > pair[1].delta_e })
        );
        assert!(study.rows.iter().all(|row| row.encode_seconds > 0.0 && row.decode_rate > 0.0 && row.runs > 0));
        // 8 x 8 wavelets are larger and less accurate than tables.
        let wavelets = || study.rows.iter().filter(|row| row.codec == "wavelet");
        assert!(wavelets().count() == 4 && wavelets().all(|row| !row.on_bytes_front), "{:?}", study.rows);
        assert!(study.rows.iter().any(|row| row.on_bytes_front) && study.rows.iter().any(|row| row.on_seconds_front));
    }
}
