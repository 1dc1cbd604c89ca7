//! The cases of [`engines`](crate::engines) with the sampler filtering, and how far that may be from exact weights.
//!
//! GPUs hold a position between two texels in 8 bits, so a weight is off by up to [`STEP`] along each axis that is filtered. A
//! linear filter is then off by that share of what the neighbours differ by, no more: so each query has a bound of its own.
//!
//! - **Table packs** hold logarithms of `f_r + με`. The bound `b` of the logarithm is the step times the largest difference of
//!   neighbours around the query, summed over the axes; `f_r + με` may be off by the factor `exp(b)`.
//! - **Wavelet packs** likewise, but the logarithm is a sum over slices, all filtered with the same weights: its bound is what
//!   it changes by when the outer direction is moved by the step.
//! - **Polynomial wavelet trees**: every filtered number may be off by three steps of its range, two axes and the mipmap levels.
//!   The bound is how far its colour may be with channels off by their sums.
//! - **Flat BTFs** are no sum of what is filtered: the bound is twice what the value changes by when polar angle and azimuth of the
//!   view, place and level are moved by the step, summed. Twice, as two mipmap levels are rounded each by itself.

use crate::engines::{
    Case, Query, blends, brdf_queries, flat_queries, four, some_flat_btfs, some_tables, some_wavelets, tree_queries,
};
use brdfc_formats::PackKind;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::direction::{DirectionPair, from_tangent_pole, to_tangent_pole};
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_formats::table::{Angles, Curve, TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::f64::consts::PI;

/// What a weight may be off by: samplers hold positions in units of texels with 8 bits behind the point, rounded either way.
pub const STEP: f32 = 1.0 / 256.0;

/// Samplers filter.
const FRAME: FrameBlock = FrameBlock { distance_scale: 1.0, sampler_filters: true, blend: Filter::Bilinear };

/// What other arithmetic adds, as [`engines`](crate::engines) allows of exact weights, and rounding of what is filtered.
const ROUNDING: f64 = 1e-4;

/// How much of what they may be off answers are on the average, at most: positions are rounded to the nearest, so by a quarter of a
/// step in the mean.
const MEAN_SHARE: f64 = 0.3;

/// A case, and what the sampler may make of it.
pub struct SamplerCase {
    pub case: Case,
    /// How far each number of an answer may be from what is expected.
    pub allowed: Vec<[f64; 4]>,
    /// Whether anything is filtered by the sampler along the texture's columns: not where there is one, nor of lifted wavelet
    /// packs, whose cells are reconstructed one by one.
    pub is_filtered: bool,
}

impl SamplerCase {
    /// Errors of answers: relative to the value and what is added to it, and as a share of what is allowed; of each the largest
    /// of its numbers.
    fn errors(&self, found: &[[f32; 4]]) -> Vec<[f64; 2]> {
        assert_eq!(found.len(), self.allowed.len());
        let of = |at: usize| {
            let (expected, floor) = self.case.expected[at];
            (0..4).fold([0.0f64; 2], |most, k| {
                let off = (f64::from(found[at][k]) - f64::from(expected[k])).abs();
                let off = if off.is_nan() { f64::INFINITY } else { off };
                let value = f64::from(expected[k].abs()) + f64::from(floor);
                [most[0].max(off / value), most[1].max(off / self.allowed[at][k])]
            })
        };
        (0..found.len()).map(of).collect()
    }
}

/// What a value of a BRDF may be off by where its logarithm is off by `logarithm`.
fn of_logarithm(logarithm: [f32; 3], expected: [f32; 3], floor: f32) -> [f64; 4] {
    let of = |k: usize| {
        let value = f64::from(expected[k]) + f64::from(floor);
        (f64::from(logarithm[k]).exp() - 1.0 + ROUNDING) * value
    };
    [of(0), of(1), of(2), ROUNDING * f64::from(floor)]
}

/// Sums over axes of what neighbours around a position differ by: of the cells that it is in when it is moved by a step.
fn differences(values: &[[f32; 3]], size: [usize; 3], at: [f32; 3]) -> [f32; 3] {
    let ranges: [_; 3] = std::array::from_fn(|axis| {
        let last = size[axis] - 1;
        let lower = (at[axis] - STEP).floor().max(0.0) as usize;
        lower.min(last)..=(((at[axis] + STEP).floor() + 1.0) as usize).min(last)
    });
    let strides = [1, size[0], size[0] * size[1]];
    let mut most = [[0.0f32; 3]; 3];
    for z in ranges[2].clone() {
        for y in ranges[1].clone() {
            for x in ranges[0].clone() {
                let here = x + y * strides[1] + z * strides[2];
                for (axis, place) in [x, y, z].into_iter().enumerate() {
                    if place == *ranges[axis].end() {
                        continue;
                    }
                    for channel in 0..3 {
                        let apart = (values[here + strides[axis]][channel] - values[here][channel]).abs();
                        most[axis][channel] = most[axis][channel].max(apart);
                    }
                }
            }
        }
    }
    std::array::from_fn(|channel| most.iter().map(|axis| axis[channel]).sum())
}

/// What the logarithm of a table may be off by at a pair.
fn table_bound(pack: &TablePack, values: &[[f32; 3]], pair: DirectionPair, level: f32) -> [f32; 3] {
    let (header, window) = (pack.header(), pack.window());
    let position = header.position(pair);
    let size = pack.extent().map(|n| n as usize);
    let slices = header.slices() as f32;
    let within = |at: f32, axis: usize| (at - window.first[axis] as f32).clamp(0.0, (window.size[axis] - 1) as f32);
    let (column, row) = (within(position.column, 0), within(position.row, 1));
    let slice = position.slice.clamp(0.0, slices - 1.0);
    let [lower, upper] =
        position.layers.map(|layer| differences(values, size, [column, row, layer as f32 * slices + slice]));
    let of_curve = |curve: &Curve| {
        let at = Curve::position(curve.nodes(), Angles::of(pair).theta_half);
        let down = (curve.levels() as f32 - level).clamp(0.0, curve.levels() as f32);
        let row =
            |row: f32| differences(&curve.values(), [curve.nodes(), curve.levels() as usize + 1, 1], [at, row, 0.0]);
        let [fine, coarse] = [row(down.floor()), row(down.ceil())];
        std::array::from_fn(|k| fine[k].max(coarse[k]))
    };
    let curve = pack.curve().map_or([0.0; 3], of_curve);
    std::array::from_fn(|k| {
        let table = lower[k] + position.layer_weight * (upper[k] - lower[k]);
        STEP * (header.span[k] * table + curve[k])
    })
}

/// The case of a table pack.
pub fn of_table(name: &str, pack: &TablePack) -> SamplerCase {
    let (decoder, values) = (TableDecoder::new(pack), pack.values());
    let (pairs, mut queries) = brdf_queries(pack.levels(), 11);
    queries.iter_mut().for_each(|[_, b, _]| b[3] = 1.0);
    let floor = pack.header().mean * pack.header().bias;
    let answer = |(pair, [a, ..]): (&DirectionPair, &Query)| {
        let value = decoder.eval_at(*pair, a[3]);
        (of_logarithm(table_bound(pack, &values, *pair, a[3]), value, floor), (four(value, 0.0), floor))
    };
    let (allowed, expected) = pairs.iter().zip(&queries).map(answer).unzip();
    let (bindings, frame) = (pack.bindings().into_owned(), FRAME);
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::Table, bindings, frame, files, queries, expected };
    SamplerCase { case, allowed, is_filtered: true }
}

/// What the logarithm of a wavelet pack may be off by at a pair: what it changes by when the outer direction is moved.
fn wavelet_bound(decoder: &WaveletDecoder, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
    let header = decoder.header();
    let (outer, inner) = header.parameterisation.to_axes(pair);
    let at = to_tangent_pole(outer);
    let step = f64::from(STEP) * PI / header.grid() as f64;
    let here = decoder.log_value(pair, level, filter);
    let mut most = [0.0f32; 3];
    for moves in [[-step, -step], [-step, step], [step, -step], [step, step]] {
        let moved = [0, 1].map(|axis| (at[axis] + moves[axis]).clamp(0.0, PI));
        let there = header.parameterisation.from_axes(from_tangent_pole(moved), inner);
        let there = decoder.log_value(there, level, filter);
        for k in 0..3 {
            most[k] = most[k].max((there[k] - here[k]).abs());
        }
    }
    most
}

/// The case of a wavelet pack.
pub fn of_wavelet(name: &str, pack: &WaveletPack, filter: Filter) -> SamplerCase {
    let decoder = WaveletDecoder::new(pack);
    let (pairs, mut queries) = brdf_queries(pack.header.levels, 12);
    queries.iter_mut().for_each(|[_, b, _]| b[3] = 1.0);
    let floor = pack.header.mean * pack.header.bias;
    // A sampler filters slices also where the nearest inner cell is taken.
    let nearest = filter == Filter::Nearest && !pack.header.lifted;
    let on_cpu = if nearest { Filter::Slices } else { filter };
    let answer = |(pair, [a, ..]): (&DirectionPair, &Query)| {
        let value = decoder.eval(*pair, a[3], on_cpu);
        (of_logarithm(wavelet_bound(&decoder, *pair, a[3], on_cpu), value, floor), (four(value, 0.0), floor))
    };
    let (allowed, expected) = pairs.iter().zip(&queries).map(answer).unzip();
    let (bindings, files) = (pack.bindings().into_owned(), Vec::new());
    let frame = FrameBlock { blend: filter, ..FRAME };
    let (name, is_filtered) = (format!("{name}, {filter:?}"), !pack.header.lifted && pack.extent()[0] > 1);
    let case = Case { name, decoder: PackKind::Wavelet, bindings, frame, files, queries, expected };
    SamplerCase { case, allowed, is_filtered }
}

/// What a colour of a tree may be off by at a place and light.
fn tree_bound(decoder: &PwtDecoder, [a, b, _]: &Query) -> [f64; 4] {
    let header = decoder.pack().header();
    let weights = header.weights([b[0], b[1], b[2]]);
    let channels = decoder.channels([a[0], a[1]], a[2], &weights);
    let mut off = [0.0f32; 3];
    for component in header.components() {
        let weight = (weights[component.term as usize] * component.scale).abs();
        off[component.channel as usize] += 3.0 * STEP * weight;
    }
    let colour = |k: usize| {
        let of_axes = |numbers: [f32; 3], share: fn(f32) -> f32| -> f32 {
            header.colour.iter().zip(numbers).map(|(axis, number)| share(axis[k]) * number).sum()
        };
        let (value, off) = (of_axes(channels, |share| share), of_axes(off, f32::abs));
        let [low, here, high] = [value - off, value, value + off].map(|value| f64::from(header.domain.decode(value)));
        (high - here).max(here - low) + ROUNDING * (here + 1e-2)
    };
    [colour(0), colour(1), colour(2), 1e-6]
}

/// The case of a polynomial wavelet tree.
fn of_tree(name: &str, pack: PwtPack) -> SamplerCase {
    let (bindings, queries) = (pack.bindings().into_owned(), tree_queries());
    let is_filtered = pack.header().extent != [1; 2];
    let decoder = PwtDecoder::new(pack);
    let answer = |[a, b, _]: &Query| (four(decoder.value([a[0], a[1]], a[2], [b[0], b[1], b[2]]), 0.0), 1e-2);
    let expected = queries.iter().map(answer).collect();
    let allowed = queries.iter().map(|query| tree_bound(&decoder, query)).collect();
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::Pwt, bindings, frame: FRAME, files, queries, expected };
    SamplerCase { case, allowed, is_filtered }
}

/// A view whose place among the views of the indirection is moved by so many of them, polar angle first.
fn moved_view(decoder: &FlatBtfDecoder, [x, y, z]: [f32; 3], [polar, azimuth]: [f32; 2]) -> [f32; 3] {
    let header = decoder.parts().indirection.header();
    let steps = [header.largest_angle / (header.zenith_samples - 1) as f32, TAU / header.azimuth_samples as f32];
    let theta = (x.hypot(y).atan2(z).min(header.largest_angle) + polar * steps[0]).clamp(0.0, header.largest_angle);
    let phi = y.atan2(x) + azimuth * steps[1];
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// A value of a flat BTF with the indirection of another view, and with what is filtered behind it moved, in parameters and
/// levels.
fn moved_value(
    decoder: &FlatBtfDecoder,
    directions: Option<&SampledDirections>,
    [a, b, c]: &Query,
    seen_from: [f32; 3],
    [u, v, level]: [f32; 3],
) -> [f32; 3] {
    let ([view, light], uv) = ([b, c].map(|v| [v[0], v[1], v[2]]), [a[0], a[1]]);
    let Some(directions) = directions else { return decoder.light_form(uv, seen_from, light) };
    let ([views, lights], dimmed) = blends(directions, [view, light]);
    let value = match decoder.parts().values.factored() {
        Some(asset) => {
            let found = decoder.indirection(uv, seen_from);
            asset.value([found[0] + u, found[1] + v], a[2] + level, views, lights)
        }
        None => decoder.full(uv, seen_from, views.samples, lights.samples),
    };
    value.map(|channel| channel * dimmed)
}

/// What a value of a flat BTF may be off by.
fn flat_bound(decoder: &FlatBtfDecoder, directions: Option<&SampledDirections>, query: &Query) -> [f64; 4] {
    let [a, b, _] = query;
    let view = [b[0], b[1], b[2]];
    let here = moved_value(decoder, directions, query, view, [0.0; 3]);
    let asset = decoder.parts().values.factored();
    let steps = asset.map_or([0.0; 2], |asset| {
        // Texels of the coarser of the two levels are larger.
        let (size, last) = (asset.header().size, asset.header().levels - 1);
        let coarser = (a[2].ceil() as u32).min(last);
        [STEP / (size >> coarser).max(1) as f32, STEP]
    });
    // The shader keeps off the borders of blocks by half a step more.
    let turn = 1.5 * STEP;
    let axes = [
        [turn, 0.0, 0.0, 0.0, 0.0],
        [0.0, turn, 0.0, 0.0, 0.0],
        [0.0, 0.0, steps[0], 0.0, 0.0],
        [0.0, 0.0, 0.0, steps[0], 0.0],
        [0.0, 0.0, 0.0, 0.0, steps[1]],
    ];
    let mut most = [0.0f32; 3];
    for axis in &axes[..if asset.is_some() { 5 } else { 2 }] {
        let there = [-1.0, 1.0].map(|sign| {
            let [polar, azimuth, u, v, level] = axis.map(|step| sign * step);
            moved_value(decoder, directions, query, moved_view(decoder, view, [polar, azimuth]), [u, v, level])
        });
        for k in 0..3 {
            most[k] += 2.0 * there.map(|there| (there[k] - here[k]).abs()).into_iter().fold(0.0, f32::max);
        }
    }
    let of = |k: usize| f64::from(most[k]) + ROUNDING * (f64::from(here[k]) + 1e-2);
    [of(0), of(1), of(2), 1e-6]
}

/// The case of a flat BTF.
fn of_flat_btf(name: &str, decoder: &FlatBtfDecoder) -> SamplerCase {
    let directions = SampledDirections::of(&decoder.parts().values).unwrap();
    let bindings = decoder.bindings(true, directions.as_ref()).into_owned();
    let queries = flat_queries();
    let answer = |query: &Query| {
        let view = [query[1][0], query[1][1], query[1][2]];
        (four(moved_value(decoder, directions.as_ref(), query, view, [0.0; 3]), 0.0), 1e-2)
    };
    let expected = queries.iter().map(answer).collect();
    let allowed = queries.iter().map(|query| flat_bound(decoder, directions.as_ref(), query)).collect();
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::FlatBtf, bindings, frame: FRAME, files, queries, expected };
    SamplerCase { case, allowed, is_filtered: true }
}

/// All of them. Their texels are random, so that neighbours are as far apart as can be: no material is.
pub fn sampler_cases() -> Vec<SamplerCase> {
    let tables = some_tables().into_iter().map(|(name, pack)| of_table(&name, &pack));
    let wavelets = some_wavelets().into_iter().map(|(name, pack, filter)| of_wavelet(&name, &pack, filter));
    let trees = crate::pwt::packs().into_iter().map(|(name, pack)| of_tree(name, pack));
    let flat = some_flat_btfs().into_iter().map(|(name, decoder)| of_flat_btf(name, &decoder));
    tables.chain(wavelets).chain(trees).chain(flat).collect()
}

/// Holds answers by the sampler against the CPU's, and prints largest, 99th percentile and mean of the errors. Answers that are no
/// numbers are those of a device that does not filter such a texture.
///
/// # Panics
/// Where an answer is beyond its bound, or the mean of them beyond a share of it.
pub fn check_sampler(what: &str, cases: &[SamplerCase], found: &[Vec<[f32; 4]>]) {
    assert_eq!(found.len(), cases.len());
    let mut all: BTreeMap<&str, [f64; 4]> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (case, found) in cases.iter().zip(found) {
        let (decoder, name) = (case.case.decoder.name(), &case.case.name);
        if is_skipped(found) {
            println!("skipped: {what}: {decoder}, {name}: the device does not filter floats of 32 bits");
            continue;
        }
        let errors = case.errors(found);
        let mean = |k: usize| errors.iter().map(|error| error[k]).sum::<f64>() / errors.len() as f64;
        let mut relative: Vec<f64> = errors.iter().map(|[relative, _]| *relative).collect();
        relative.sort_by(f64::total_cmp);
        let (largest, p99) = (relative[relative.len() - 1], relative[relative.len() * 99 / 100]);
        let share = errors.iter().map(|[_, share]| *share).fold(0.0, f64::max);
        println!(
            "{what}: {decoder}, {name}: largest {largest:.1e}, 99 % {p99:.1e}, mean {:.1e}; of the bound {share:.2}, in the mean {:.3}",
            mean(0),
            mean(1)
        );
        let of_decoder = all.entry(decoder).or_default();
        for (most, number) in of_decoder.iter_mut().zip([largest, p99, mean(0), share]) {
            *most = most.max(number);
        }
        if share > 1.0 || mean(1) > MEAN_SHARE {
            wrong.push(format!("{decoder}, {name}"));
        }
    }
    assert!(wrong.is_empty(), "{what}: beyond the bound: {wrong:#?}");
    assert!(!all.is_empty());
    for (decoder, [largest, p99, mean, share]) in all {
        println!(
            "agrees: {what}, {decoder}: largest {largest:.1e}, 99 % {p99:.1e}, mean {mean:.1e}, {share:.2} of the bound"
        );
    }
}

/// Notices answers by a shader that looks half a texel beside.
///
/// # Panics
/// Where those of a case are within the bounds, or most of all are.
pub fn check_shifted(what: &str, cases: &[SamplerCase], found: &[Vec<[f32; 4]>]) {
    let (mut beyond, mut all) = (0, 0);
    for (case, found) in cases.iter().zip(found).filter(|(case, found)| case.is_filtered && !is_skipped(found)) {
        let noticed = case.errors(found).iter().filter(|[_, share]| *share > 1.0).count();
        assert!(noticed > 0, "{what}: {}, {}", case.case.decoder.name(), case.case.name);
        beyond += noticed;
        all += found.len();
    }
    println!("{what}: {beyond} of {all} answers half a texel beside are beyond their bounds");
    assert!(2 * beyond > all, "{what}: {beyond} of {all}");
}

fn is_skipped(found: &[[f32; 4]]) -> bool {
    found.iter().flatten().all(|number| number.is_nan())
}
