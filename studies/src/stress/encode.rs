//! Complete encodes: constant sources, black ones, lobes narrower than any grid.

use super::fed::constant;
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, cell_centre};
use brdfc_formats::table::TableDecoder;
use brdfc_formats::wavelet::{Filter, RowScratch, WaveletDecoder, WaveletPack};
use brdfc_table::encode::Prepared;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::log_encode::LogEncoding;
use brdfc_wavelet::recipe::{Recipe, Target};

/// Values of constant sources: close to 0, the dynamic range, the maximum of packs.
const VALUES: [f64; 7] = [1e-30, 1e-12, 1e-3, 0.3, 1e3, 1e6, 1e30];

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let mut rows = constants(stages, small);
    rows.push(lobes(stages, small));
    rows.push(narrow_tables(stages, small));
    rows
}

fn recipe(levels: u32, energy_preserving: bool) -> Recipe {
    Recipe {
        levels,
        stored_levels: levels,
        energy_preserving,
        measure_off_grid: false,
        supercompress: false,
        ..Recipe::visible()
    }
}

fn constants(stages: &Stages, small: bool) -> Vec<StressRow> {
    let [mut wavelets, mut tables, mut black_wavelets, mut black_tables] = [Worst::default(); 4];
    let every = super::fed::pairs(true);
    let pairs: Vec<DirectionPair> = every.into_iter().step_by(if small { 31 } else { 7 }).collect();
    // Denormal values count as black.
    for value in VALUES.into_iter().chain([0.0, 1e-42]) {
        let source = constant(value);
        let black = value < f64::from(f32::MIN_POSITIVE);
        let compare = |worst: &mut Worst, zero: f64, eval: &dyn Fn(DirectionPair) -> f32| {
            for pair in &pairs {
                let found = f64::from(eval(*pair));
                // Denormal numbers have few digits.
                let of_zero = (found - value) / (zero + f64::from(f32::MIN_POSITIVE));
                worst.add(if black { of_zero } else { found / value - 1.0 });
            }
        };
        for levels in if small { 2..=3 } else { 2..=5 } {
            for energy_preserving in [false, true] {
                match (stages.encode)(&source, &recipe(levels, energy_preserving)) {
                    Ok(made) => {
                        let decoder = WaveletDecoder::new(&made.pack);
                        let zero = f64::from(made.pack.header.mean) * f64::from(made.pack.header.bias);
                        let worst = if black { &mut black_wavelets } else { &mut wavelets };
                        compare(worst, zero, &|pair| decoder.eval(pair, levels as f32, Filter::Bilinear)[0]);
                    }
                    Err(_) => wavelets.add(f64::NAN),
                }
            }
        }
        for factored in [false, true] {
            let recipe = TableRecipe { size: Size::Bytes(1 << 10), factored, measure: false, ..TableRecipe::default() };
            let prepared = Prepared::new(&source, &recipe, 1 << 12, &()).ok();
            match prepared.and_then(|prepared| (stages.table_pack)(&prepared, &recipe).ok()) {
                Some(pack) => {
                    let decoder = TableDecoder::new(&pack);
                    let worst = if black { &mut black_tables } else { &mut tables };
                    let zero = f64::from(pack.header().mean) * f64::from(pack.header().bias);
                    compare(worst, zero, &|pair| decoder.eval(pair)[0]);
                }
                None => tables.add(f64::NAN),
            }
        }
    }
    let why = "one logarithm and one exponential: 3e-7 and 2.5e-7, and roundings; constant slices have steps of 0 without errors";
    vec![
        wavelets.row(
            ["whole wavelet encode", "constants 1e-30 to 1e30, plain and energy-preserving"],
            Measure::Relative,
            CONSTANT,
            why,
        ),
        tables.row(
            ["whole table encode", "constants 1e-30 to 1e30, plain and factored"],
            Measure::Relative,
            CONSTANT,
            why,
        ),
        black_wavelets.row(
            ["whole wavelet encode", "black and denormal sources"],
            Measure::Relative,
            3e-7 * 8.2 + 2.5e-7 + 8.0 * U,
            "ε μ is added and subtracted: one ln, 3e-7 of ln ε = -8.1, and one exp; relative to ε μ, where μ is 1 for black",
        ),
        black_tables.row(
            ["whole table encode", "black and denormal sources"],
            Measure::Relative,
            8.0 * U * 9.3 + 2.5e-7 + 8.0 * U,
            "the same for ln ε = -9.2, which a fit averages: 8 roundings",
        ),
    ]
}

/// Relative error bound of decoded constants.
const CONSTANT: f64 = 3e-7 + 2.5e-7 + 32.0 * U;

/// Lobes narrower than a cell, all slices stored: the error of a value is at most the sum of the steps of its slices.
fn lobes(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    for alpha in [0.001, 0.003, 0.03] {
        let Ok(source) = parse_synth(&format!("synth:ggx?kd=0.1&f0=0.9&alpha={alpha}")) else {
            worst.add(f64::NAN);
            continue;
        };
        for levels in if small { 2..=3 } else { 2..=4 } {
            for bits in [8, 12, 16] {
                let recipe = Recipe { bits, target: Target::Ratio(1.0), ..recipe(levels, false) };
                match (stages.encode)(source.as_ref(), &recipe) {
                    Ok(made) => on_grid(&made.pack, source.as_ref(), &mut worst),
                    Err(_) => worst.add(f64::NAN),
                }
            }
        }
    }
    worst.row(
        ["whole wavelet encode", "GGX of roughness 0.001 to 0.03, all slices, 8 to 16 bits"],
        Measure::OfBound,
        1.0,
        "half a step of every slice on the path to a cell, and 64 roundings of their ranges",
    )
}

fn on_grid(pack: &WaveletPack, source: &dyn Source, worst: &mut Worst) {
    let header = &pack.header;
    let (n, cells, levels) = (header.grid(), header.cells(), header.levels);
    let encoding = LogEncoding { mean: f64::from(header.mean), bias: f64::from(header.bias) };
    let step = |k: usize| {
        let scale = pack.scales[usize::from(pack.index[k])];
        let (half, last) = (0.5 * f64::from(scale.scale), f64::from((1u32 << header.bits) - 1));
        let spread = if header.bits == 12 { half / 65535.0 } else { 0.0 };
        half / last + spread + 64.0 * U * f64::from(scale.scale + scale.offset.abs())
    };
    let mut allowed = step(0) / n as f64;
    for j in 0..levels {
        let (first, scale) = (1usize << (2 * j), f64::from(1u32 << j) / n as f64);
        allowed += scale * (first..2 * first).map(step).fold(0.0, f64::max);
        allowed += scale * std::f64::consts::SQRT_2 * (2 * first..4 * first).map(step).fold(0.0, f64::max);
    }
    let decoder = WaveletDecoder::new(pack);
    let (mut row, mut scratch) = (vec![0.0f32; cells], RowScratch::default());
    for outer in 0..cells {
        decoder.decode_row(outer, 0, &mut row, &mut scratch);
        for (inner, found) in row.iter().enumerate() {
            let centre = |cell: usize| cell_centre(cell % n, cell / n, n);
            let f = source.eval(DirectionPair::new(centre(outer), centre(inner)), &mut Tally::default())[0];
            worst.add((f64::from(*found) - encoding.encode(f)) / allowed);
        }
    }
}

/// Plain tables are never brighter than their source.
fn narrow_tables(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    for alpha in [0.001, 0.003, 0.03] {
        let recipe = TableRecipe { size: Size::Bytes(2 << 10), measure: false, ..TableRecipe::default() };
        let prepared = parse_synth(&format!("synth:ggx?kd=0.1&f0=0.9&alpha={alpha}"))
            .ok()
            .and_then(|source| Prepared::new(source.as_ref(), &recipe, 1 << 14, &()).ok());
        let made = prepared.and_then(|prepared| Some(((stages.table_pack)(&prepared, &recipe).ok()?, prepared)));
        let Some((pack, prepared)) = made else {
            worst.add(f64::NAN);
            continue;
        };
        let values = prepared.samples.values.iter().flatten();
        let (least, most) = values.fold((f32::MAX, 0.0f32), |(least, most), v| (least.min(*v), most.max(*v)));
        let decoder = TableDecoder::new(&pack);
        for pair in super::fed::pairs(small).into_iter().step_by(if small { 11 } else { 1 }) {
            for found in decoder.eval(pair) {
                // The bias of the logarithm blurs values far below the mean.
                let floor = f64::from(pack.header().mean * pack.header().bias);
                let over = f64::from(found) / f64::from(most) - 1.0;
                let under = (f64::from(least) - f64::from(found)) / (f64::from(least) + floor);
                worst.add(over.max(under).max(0.0));
            }
        }
    }
    worst.row(
        ["whole table encode", "GGX of roughness 0.001 to 0.03"],
        Measure::Relative,
        1e-5,
        "nodes are between the smallest and the largest sample, filtered values between nodes; roundings of ln of 1e8",
    )
}
