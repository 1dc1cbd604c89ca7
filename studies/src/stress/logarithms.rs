//! Logarithms and exponentials, and the encoding based on them.

use super::fed::{Filling, Numbers, table};
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_core::Symmetry;
use brdfc_formats::wavelet::{SliceScale, WaveletDecoder, WaveletPack};
use brdfc_wavelet::log_encode::{DEFAULT_BIAS, LogEncoding};
use brdfc_wavelet::recipe::Recipe;

/// Relative error of `vector_math::ln`, and of `vector_math::exp`.
const LN: f64 = 3e-7;
const EXP: f64 = 2.5e-7;

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let count = if small { 2_000 } else { 200_000 };
    let mut numbers = Numbers::new(1);
    let (mut ln, mut exp) = (Worst::default(), Worst::default());
    for _ in 0..count {
        let y = numbers.between(-87.0, 88.0).exp() as f32;
        let exact = f64::from(y).ln();
        ln.add((f64::from((stages.ln)(y)) - exact) / (exact.abs() + 1e-5));
        let x = numbers.between(-80.0, 80.0) as f32;
        exp.add(f64::from((stages.exp)(x)) / f64::from(x).exp() - 1.0);
    }
    vec![
        ln.row(
            ["ln, f32", "all normal numbers"],
            Measure::Relative,
            LN,
            "the documented bound; near 1 it is relative to 1e-5",
        ),
        exp.row(["exp, f32", "-80 to 80"], Measure::Relative, EXP, "the documented bound"),
        log_encode(stages, small),
        from_log(stages),
        no_numbers(stages),
    ]
}

/// Tables with 1e-12 to 1e6, denormals, zeros, and means at both ends.
fn log_encode(stages: &Stages, small: bool) -> StressRow {
    let levels = if small { 2 } else { 4 };
    let cells = 1usize << (4 * levels);
    let mut worst = Worst::default();
    for filling in Filling::ALL {
        for scale in [1e-30f32, 1e-12, 1.0, 1e6, 1e24] {
            for bias in [1e-6, 3e-4, DEFAULT_BIAS, 1.0] {
                let samples = filling.numbers(cells, &mut Numbers::new(2));
                let samples: Vec<f32> = samples.iter().map(|v| v.abs() * scale).collect();
                let table = table(levels, Symmetry::NONE, &samples);
                let encoding = LogEncoding::of(&table, bias);
                for (f, v) in table.values.iter().zip((stages.log_encode)(&table, encoding).values.iter()) {
                    let exact = encoding.encode(f64::from(*f));
                    worst.add((f64::from(*v) - exact) / (4.0 * U + LN * exact.abs() + 1e-12));
                }
            }
        }
    }
    worst.row(
        ["log encoding, f32", "1e-12 to 1e6, denormals, zeros, a spike, means 1e-30 to 1e30"],
        Measure::OfBound,
        1.0,
        "4 roundings of f / μ + ε, and 3e-7 of the logarithm",
    )
}

fn decoder(mean: f32, bias: f32) -> WaveletDecoder {
    let header = super::fed::header(&Recipe { levels: 1, stored_levels: 1, ..Recipe::default() }, mean, bias);
    WaveletDecoder::new(&WaveletPack {
        header,
        index: vec![1, 0, 0, 0],
        scales: vec![SliceScale::default(); 2],
        on_grid: Default::default(),
        off_grid: Default::default(),
        crop: None,
        texels: vec![0; 8],
    })
}

fn from_log(stages: &Stages) -> StressRow {
    let mut worst = Worst::default();
    for mean in [1e-30f32, 1e-12, 0.3, 1e6, 1e30] {
        for bias in [1e-6f32, 1e-2, 1.0] {
            let decoder = decoder(mean, bias);
            let mut numbers = Numbers::new(3);
            for _ in 0..500 {
                let f = f64::from(mean) * numbers.between(-14.0, 14.0).exp();
                let v = (f / f64::from(mean) + f64::from(bias)).ln() as f32;
                let (mean, bias) = (f64::from(mean), f64::from(bias));
                let exact = (mean * (f64::from(v).exp() - bias)).max(0.0);
                worst.add((f64::from((stages.from_log)(&decoder, v)) - exact) / (exact + bias * mean));
            }
        }
    }
    worst.row(
        ["log decoding, f32", "means 1e-30 to 1e30"],
        Measure::Relative,
        EXP + 3.0 * U,
        "an exponential and 3 roundings; relative to f + ε μ",
    )
}

/// Values that no encoder writes but a file may contain.
fn no_numbers(stages: &Stages) -> StressRow {
    let mut worst = Worst::default();
    for mean in [f32::MIN_POSITIVE, 1.0, f32::MAX] {
        for v in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 100.0, -100.0, 1e-40, 0.0] {
            let f = (stages.from_log)(&decoder(mean, 1.0), v);
            worst.check(f.is_finite() && f >= 0.0);
        }
    }
    worst.row(
        ["log decoding, f32", "NaN, infinities"],
        Measure::Count,
        0.0,
        "decoded values are finite and not negative",
    )
}
