//! Table packs.
//!
//! Bounds with the sampler filtering: tables hold logarithms of `f_r + με`. The bound `b` of the logarithm is the step
//! times the largest difference of neighbours around the query, summed over the axes; `f_r + με` may be off by the
//! factor `exp(b)`.

use crate::codec::{Measured, TestedCodec};
use crate::engines::{Case, EXACT, Query, brdf_queries, four};
use crate::golden::Hashes;
use crate::golden::values::{Values, directions, of_columns};
use crate::packs::{Numbers, crop};
use crate::sampler::{SAMPLED, STEP, SamplerCase, of_logarithm};
use brdfc_formats::crop::Window;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::{Angles, Axes, Curve, KNOTS, TableDecoder, TableHeader, TablePack, TableSymmetry};
use brdfc_formats::{Pack, PackKind};

/// Tables of both formats and every symmetry, with random texels; then some with a curve.
pub fn tables() -> Vec<(String, TablePack)> {
    let mut packs = Vec::new();
    for bits in 0..16 {
        let symmetry = TableSymmetry::from_bits(bits).expect("four bits");
        for layers in [1, 3] {
            if layers == 1 && bits > 3 {
                continue;
            }
            let axes = Axes { half: 5 + bits, difference: 4, azimuth: 2 + bits % 3, layers };
            let mut numbers = Numbers::new(u64::from(16 * bits + layers));
            let mut knots = [0.0f32; KNOTS];
            for k in 1..KNOTS {
                knots[k] = knots[k - 1] + numbers.between(0.01, 0.1) as f32;
            }
            let last = knots[KNOTS - 1];
            knots = knots.map(|knot| knot / last);
            let header = TableHeader {
                channels: if bits % 2 == 0 { 3 } else { 1 },
                symmetry,
                axes,
                mean: 0.25,
                bias: 1e-4,
                low: [-3.0, -2.5, -2.0],
                span: [5.0, 4.0, 4.5],
                slope: numbers.between(-0.5, 0.6) as f32,
                knots,
            };
            let count = axes.half * axes.difference * axes.azimuth * axes.layers;
            let mut value = || std::array::from_fn(|_| numbers.unit() as f32);
            let values: Vec<[f32; 3]> = (0..count).map(|_| value()).collect();
            let pack = TablePack::new(header, &values).expect("in range");
            packs.push((format!("symmetry {bits}, layers {layers}"), pack));
        }
    }
    let factored = |(name, pack): (String, TablePack)| {
        let levels = if pack.header().symmetry.bits() == 3 { 0 } else { 3 };
        let mut numbers = Numbers::new(packs.len() as u64);
        let count = 9 * (levels + 1);
        let values: Vec<[f32; 3]> =
            (0..count).map(|_| std::array::from_fn(|_| numbers.between(-1.0, 2.0) as f32)).collect();
        let curve = Curve::new(pack.header().channels, levels, &values).expect("in range");
        (format!("{name}, curve"), pack.with_curve(curve).expect("of the same format"))
    };
    let names = ["symmetry 0, layers 1", "symmetry 3, layers 1", "symmetry 15, layers 3"];
    let plain = packs.iter().filter(|(name, _)| names.contains(&name.as_str())).cloned();
    let factored: Vec<_> = plain.map(factored).collect();
    packs.extend(factored);
    let cropped = packs.iter().enumerate().filter(|(k, _)| k % 4 == 1).map(|(k, (name, pack))| {
        let [columns, rows, _] = pack.extent();
        let window = Window { first: [k as u32 % (columns - 1), k as u32 % 3], size: [2, rows - k as u32 % 3] };
        (format!("{name}, cropped"), pack.cropped(crop(window)).expect("within the texture"))
    });
    let cropped: Vec<_> = cropped.collect();
    packs.into_iter().chain(cropped).collect()
}

/// Tables for every kind of look-up.
fn some_tables() -> Vec<(String, TablePack)> {
    let names = [
        "symmetry 3, layers 1",
        "symmetry 12, layers 3",
        "symmetry 0, layers 1, curve",
        "symmetry 15, layers 3, curve",
        "symmetry 5, layers 3, cropped",
    ];
    let some: Vec<_> = tables().into_iter().filter(|(name, _)| names.contains(&name.as_str())).collect();
    assert!(some.len() > 3);
    some
}

/// Sums over axes of the differences of neighbours around a position, in the cells that it is in when it is moved by a
/// step.
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

/// Error bound for the logarithm of a table at a pair.
fn bound(pack: &TablePack, values: &[[f32; 3]], pair: DirectionPair, level: f32) -> [f32; 3] {
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
pub fn sampler_case(name: &str, pack: &TablePack) -> SamplerCase {
    let (decoder, values) = (TableDecoder::new(pack), pack.values());
    let (pairs, mut queries) = brdf_queries(pack.levels(), 11);
    queries.iter_mut().for_each(|[_, b, _]| b[3] = 1.0);
    let floor = pack.header().mean * pack.header().bias;
    let answer = |(pair, [a, ..]): (&DirectionPair, &Query)| {
        let value = decoder.eval_at(*pair, a[3]);
        (of_logarithm(bound(pack, &values, *pair, a[3]), value, floor), (four(value, 0.0), floor))
    };
    let (allowed, expected) = pairs.iter().zip(&queries).map(answer).unzip();
    let (bindings, frame) = (pack.bindings().into_owned(), SAMPLED);
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::Table, bindings, frame, files, queries, expected };
    SamplerCase { case, allowed, is_filtered: true }
}

/// The tested codec.
pub struct Table;

impl TestedCodec for Table {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let (_, table) = tables().into_iter().find(|(name, _)| name == "symmetry 3, layers 1, curve").unwrap();
        table.to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |(name, pack): (String, TablePack)| {
            let decoder = TableDecoder::new(&pack);
            let (pairs, queries) = brdf_queries(pack.levels(), 11);
            let floor = pack.header().mean * pack.header().bias;
            let expected =
                pairs.iter().zip(&queries).map(|(pair, [a, ..])| (four(decoder.eval_at(*pair, a[3]), 0.0), floor));
            let expected = expected.collect();
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
            Case { name, decoder: PackKind::Table, bindings, frame: EXACT, files, queries, expected }
        };
        some_tables().into_iter().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        some_tables().iter().map(|(name, pack)| sampler_case(name, pack)).collect()
    }

    /// Hashes of a table: `values` are texels and filtered logarithms; `reflectances` are their exponentials; `errors`
    /// are those in the pack's metadata.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Table(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let decoder = TableDecoder::new(&pack);
        let (mut values, mut reflectances, mut errors) = (Values::default(), Values::default(), Values::default());
        let header = pack.header();
        let axes = header.axes;
        values.words([header.channels, header.symmetry.bits(), axes.half, axes.difference, axes.azimuth, axes.layers]);
        values.add([header.mean, header.bias, header.slope]);
        values.add(header.low.into_iter().chain(header.span).chain(header.knots));
        values.add(pack.values().into_iter().flatten());
        if let Some(curve) = pack.curve() {
            values.add(curve.values().into_iter().flatten());
        }
        for pair in directions().flat_map(|i| directions().map(move |o| DirectionPair::new(i, o))) {
            for level in 0..=decoder.levels() {
                if pair.is_above_horizon() {
                    values.add(decoder.log_values(pair, level as f32).fine);
                }
                reflectances.add(decoder.eval_at(pair, level as f32));
            }
        }
        errors.summary(&pack.off_grid);
        errors.add([pack.rendering.mean, pack.rendering.p95, pack.rendering.max]);
        of_columns([("values", values), ("reflectances", reflectances), ("errors", errors)])
    }

    fn measured(&self) -> &'static [Measured] {
        &[("brdfc.table.errors", None)]
    }
}
