//! Wavelet packs.
//!
//! Bounds with the sampler filtering: the logarithm is a sum over slices, all filtered with the same weights. Its bound
//! is its change when the outer direction is moved by the step.

use crate::codec::{Files, Measured, TestedCodec};
use crate::engines::{Case, EXACT, Query, brdf_queries, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns};
use crate::packs::{Numbers, crop, pairs, sealed};
use crate::sampler::{SAMPLED, STEP, SamplerCase, of_logarithm};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::crop::Window;
use brdfc_formats::direction::{DirectionPair, Parameterisation, from_tangent_pole, to_tangent_pole};
use brdfc_formats::wavelet::{Filter, Header, RowScratch, SliceScale, WaveletDecoder, WaveletPack};
use brdfc_formats::{ErrorSummary, Pack, PackKind};
use std::f64::consts::PI;

pub fn header(parameterisation: Parameterisation, levels: u32, channels: u32, bits: u32) -> Header {
    Header {
        parameterisation,
        levels,
        stored_levels: levels,
        channels,
        bits,
        mean: 0.25,
        bias: 0.01,
        energy_preserving: false,
    }
}

/// Header of an energy-preserving pack.
pub fn energy_preserving(levels: u32, channels: u32, bits: u32) -> Header {
    Header { energy_preserving: true, ..header(Parameterisation::TangentPole, levels, channels, bits) }
}

/// A pack with made-up slices: `retained` coefficients, spread over the tree, with random texels and scales that keep
/// values in a sensible range.
pub fn pack(header: Header, retained: usize, seed: u64) -> WaveletPack {
    let mut numbers = Numbers::new(seed);
    let cells = header.cells();
    let stored = 1usize << (2 * header.stored_levels);
    assert!((1..=stored).contains(&retained));
    let mut index = vec![0u16; cells];
    let mut next = 0;
    for coefficient in 0..stored {
        // Evenly spread; the scaling coefficient comes first.
        if coefficient * retained / stored >= next || coefficient == 0 {
            next += 1;
            index[coefficient] = next as u16;
        }
    }
    // The scaling coefficient of each tree, and a third of its details.
    let mut scalings = vec![1];
    for level in 0..header.trees() {
        for coefficient in 0..1usize << (2 * level) {
            let is_stored = coefficient % 3 == 0;
            next += usize::from(is_stored);
            index.push(if is_stored { next as u16 } else { 0 });
            scalings.extend((coefficient == 0).then_some(next));
        }
    }
    let slices = next + 1;
    let scales = (0..slices)
        .map(|slice| match slice {
            0 => SliceScale::default(),
            // Of 2^l cells per axis at level l.
            slice if scalings.contains(&slice) => {
                let level = scalings.iter().position(|at| *at == slice).filter(|at| *at > 0);
                let side = level.map_or(header.grid(), |at| 1 << (at - 1)) as f32;
                SliceScale { scale: 2.5 * side, offset: -2.0 * side / header.grid() as f32 }
            }
            _ => {
                let half = numbers.between(0.05, 1.0);
                SliceScale { scale: 2.0 * half as f32, offset: numbers.between(-1.2, -0.8) as f32 * half as f32 }
            }
        })
        .collect();
    let summary = |numbers: &mut Numbers| ErrorSummary {
        samples: numbers.bits(),
        rms: numbers.unit() as f32,
        relative_mean: numbers.unit() as f32,
        relative_p95: numbers.unit() as f32,
        relative_p99: numbers.unit() as f32,
        relative_max: numbers.unit() as f32,
        log_rms: numbers.unit() as f32,
        cosine_log_rms: numbers.unit() as f32,
        albedo_max_difference: numbers.unit() as f32,
        reciprocity: numbers.unit() as f32,
    };
    let (on_grid, off_grid) = (summary(&mut numbers), summary(&mut numbers));
    let texel_bytes = header.texel_format().texel_bytes();
    let mut texels = vec![0u8; slices * cells * texel_bytes];
    for texel in texels[cells * texel_bytes..].chunks_exact_mut(texel_bytes) {
        let colours = if header.channels == 1 { texel_bytes } else { texel_bytes / 4 * 3 };
        texel[colours..].fill(0xff);
        texel[..colours].fill_with(|| numbers.bits() as u8);
    }
    WaveletPack { header, index, scales, on_grid, off_grid, crop: None, texels }
}

/// Packs of every texel format, both parameterisations, several sizes, down to two slices.
pub fn packs() -> Vec<(String, WaveletPack)> {
    let mut packs = Vec::new();
    for levels in 1..=5u32 {
        for channels in [1, 3] {
            for bits in [8, 12, 16] {
                for retained in [1, 2, 3, 1 << levels] {
                    let seed = packs.len() as u64;
                    let parameterisation = Parameterisation::NAMES[(levels + bits / 4) as usize % 2].1;
                    let made = pack(header(parameterisation, levels, channels, bits), retained, seed);
                    packs.push((
                        format!("levels {levels}, channels {channels}, bits {bits}, retained {retained}"),
                        made,
                    ));
                }
            }
        }
    }
    for (levels, channels, bits) in [(1, 1, 16), (2, 3, 12), (4, 3, 8), (5, 1, 8), (6, 3, 16)] {
        let made = pack(energy_preserving(levels, channels, bits), 1 << levels, packs.len() as u64);
        packs.push((format!("energy-preserving, levels {levels}, channels {channels}, bits {bits}"), made));
    }
    let cropped = packs.iter().enumerate().filter(|(k, _)| k % 9 == 5).map(|(k, (name, pack))| {
        let grid = pack.header.grid() as u32;
        let first = [k as u32 % grid, k as u32 / 3 % grid];
        let size = [0, 1].map(|axis| 1 + (k as u32 + axis as u32) % (grid - first[axis]));
        (format!("{name}, cropped"), pack.cropped(crop(Window { first, size })).expect("within the grid"))
    });
    let cropped: Vec<_> = cropped.collect();
    packs.extend(cropped);
    packs
}

/// The pack whose bytes are in `formats/src/container/spec.md` and `formats/src/wavelet/spec.md`.
pub fn example() -> WaveletPack {
    let header = Header {
        parameterisation: Parameterisation::HalfDifference,
        levels: 1,
        stored_levels: 1,
        channels: 1,
        bits: 8,
        mean: 0.5,
        bias: 0.01,
        energy_preserving: false,
    };
    let summary = ErrorSummary { samples: 16, rms: 0.25, reciprocity: 0.125, ..ErrorSummary::default() };
    WaveletPack {
        header,
        index: vec![1, 0, 2, 0],
        scales: vec![
            SliceScale::default(),
            SliceScale { scale: 2.0, offset: -1.0 },
            SliceScale { scale: 0.5, offset: -0.25 },
        ],
        on_grid: summary,
        off_grid: summary,
        crop: None,
        texels: vec![0, 0, 0, 0, 0, 85, 170, 255, 255, 170, 85, 0],
    }
}

/// Reads bytes with any checksum. If they are a pack, decodes it at some points and checks that `f_r` is finite.
pub fn survives(bytes: &[u8]) -> bool {
    let Ok(pack) = WaveletPack::from_bytes(&sealed(bytes.to_vec())) else { return false };
    let decoder = WaveletDecoder::new(&pack);
    for (k, pair) in pairs(3, 5).into_iter().enumerate() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let value = decoder.eval(pair, [9.0, 0.5, 1.25][k], filter);
            assert!(value.iter().all(|v| v.is_finite() && *v >= 0.0), "{value:?}");
        }
    }
    true
}

/// Wavelet packs for every kind of look-up.
fn some_wavelets() -> Vec<(String, WaveletPack, Filter)> {
    let filters = [Filter::Nearest, Filter::Slices, Filter::Bilinear];
    let is_selected = |name: &str| {
        name.starts_with("energy-preserving") || name.contains("cropped") || name.contains("levels 4, channels 3")
    };
    let some = packs().into_iter().filter(|(name, _)| is_selected(name)).step_by(3).enumerate();
    let some: Vec<_> = some.map(|(k, (name, pack))| (name, pack, filters[k % 3])).collect();
    assert!(some.len() > 4);
    some
}

/// Error bound for the logarithm of a wavelet pack at a pair: its change when the outer direction is moved.
fn bound(decoder: &WaveletDecoder, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
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
pub fn sampler_case(name: &str, pack: &WaveletPack, filter: Filter) -> SamplerCase {
    let decoder = WaveletDecoder::new(pack);
    let (pairs, mut queries) = brdf_queries(pack.header.levels, 12);
    queries.iter_mut().for_each(|[_, b, _]| b[3] = 1.0);
    let floor = pack.header.mean * pack.header.bias;
    // A sampler filters slices even if the nearest inner cell is used.
    let on_cpu = if filter == Filter::Nearest { Filter::Slices } else { filter };
    let answer = |(pair, [a, ..]): (&DirectionPair, &Query)| {
        let value = decoder.eval(*pair, a[3], on_cpu);
        (of_logarithm(bound(&decoder, *pair, a[3], on_cpu), value, floor), (four(value, 0.0), floor))
    };
    let (allowed, expected) = pairs.iter().zip(&queries).map(answer).unzip();
    let (bindings, files) = (pack.bindings().into_owned(), Vec::new());
    let frame = FrameBlock { blend: filter, ..SAMPLED };
    let (name, is_filtered) = (format!("{name}, {filter:?}"), pack.extent()[0] > 1);
    let case = Case { name, decoder: PackKind::Wavelet, bindings, frame, files, queries, expected };
    SamplerCase { case, allowed, is_filtered }
}

/// The tested codec.
pub struct Wavelet;

impl TestedCodec for Wavelet {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        example().to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |(k, (name, pack, filter)): (usize, (String, WaveletPack, Filter))| {
            let decoder = WaveletDecoder::new(&pack);
            let (pairs, queries) = brdf_queries(pack.header.levels, 12);
            let floor = pack.header.mean * pack.header.bias;
            let expected =
                pairs.iter().zip(&queries).map(|(pair, [a, ..])| (four(decoder.eval(*pair, a[3], filter), 0.0), floor));
            let expected = expected.collect();
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(k % 2 == 0)]);
            let (name, decoder) = (format!("{name}, {filter:?}"), PackKind::Wavelet);
            let frame = FrameBlock { blend: filter, ..EXACT };
            Case { name, decoder, bindings, frame, files, queries, expected }
        };
        some_wavelets().into_iter().enumerate().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        some_wavelets().iter().map(|(name, pack, filter)| sampler_case(name, pack, *filter)).collect()
    }

    fn committed(&self) -> Files {
        // Texels of 12 bits that are not multiples of a step, with random values in the fourth component.
        let twelve = pack(header(Parameterisation::HalfDifference, 2, 3, 12), 5, 1).to_bytes(false);
        let mut coarse = header(Parameterisation::TangentPole, 3, 1, 8);
        coarse.stored_levels = 1;
        let coarse = pack(coarse, 3, 2);
        let mut made = vec![
            ("page-example".to_owned(), example().to_bytes(false)),
            ("coarse-levels-8-grey".to_owned(), coarse.to_bytes(false)),
            ("coarse-levels-8-grey-zstandard".to_owned(), coarse.to_bytes(true)),
            ("any-texels-12-rgb".to_owned(), twelve.clone()),
        ];
        made.extend(foreign_forms("any-texels-12-rgb", &twelve));
        made
    }

    /// Hashes of a pack: `values` are log-encoded, all rows of the table and filtered ones; `reflectances` are their
    /// exponentials; `errors` are those in the pack's metadata.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Wavelet(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let decoder = WaveletDecoder::new(&pack);
        let (mut values, mut reflectances, mut errors) = (Values::default(), Values::default(), Values::default());
        let h = &pack.header;
        values.words([h.parameterisation.code(), h.levels, h.stored_levels, h.channels, h.bits, pack.slices() as u32]);
        values.add([h.mean, h.bias]);
        let (mut row, mut scratch) = (vec![0.0; h.cells()], RowScratch::default());
        for cell in 0..h.cells() {
            for channel in 0..h.channels as usize {
                decoder.decode_row(cell, channel, &mut row, &mut scratch);
                values.add(row.iter().copied());
            }
        }
        for pair in directions().flat_map(|i| directions().map(move |o| DirectionPair::new(i, o))) {
            for (level, filter) in [(9.0, Filter::Nearest), (1.25, Filter::Slices), (0.5, Filter::Bilinear)] {
                if pair.is_above_horizon() {
                    values.add(decoder.log_value(pair, level, filter));
                }
                reflectances.add(decoder.eval(pair, level, filter));
            }
        }
        for e in [pack.on_grid, pack.off_grid] {
            errors.summary(&e);
        }
        of_columns([("values", values), ("reflectances", reflectances), ("errors", errors)])
    }

    fn measured(&self) -> &'static [Measured] {
        &[("brdfc.wavelet.errors", None)]
    }
}
