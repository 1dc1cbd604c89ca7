//! Properties of the decoder of wavelet packs, on hand-made packs.

use brdfc_formats::direction::{DirectionPair, Parameterisation, cell_centre};
use brdfc_formats::wavelet::{Filter, RowScratch, SliceScale, WaveletDecoder, WaveletPack};
use brdfc_testing::codecs::wavelet::{header, pack};
use brdfc_testing::packs::pairs;

const FILTERS: [Filter; 2] = [Filter::Nearest, Filter::Bilinear];

/// Log-encoded value of `f_r`, from the equation of the encoding.
fn log_value(pack: &WaveletPack, f: f32) -> f64 {
    (f64::from(f) / f64::from(pack.header.mean) + f64::from(pack.header.bias)).ln()
}

/// Whole rows of the table: `[outer cell][channel][inner cell]`.
fn rows(pack: &WaveletPack) -> Vec<Vec<Vec<f32>>> {
    let decoder = WaveletDecoder::new(pack);
    let mut scratch = RowScratch::default();
    let mut row = |cell, channel| {
        let mut output = vec![0.0; pack.header.cells()];
        decoder.decode_row(cell, channel, &mut output, &mut scratch);
        output
    };
    (0..pack.header.cells())
        .map(|cell| (0..pack.header.channels as usize).map(|channel| row(cell, channel)).collect())
        .collect()
}

/// All outer and inner cell numbers, and the direction pairs of their centres if they are above the horizon.
fn centres(pack: &WaveletPack) -> Vec<(usize, usize, DirectionPair)> {
    let n = pack.header.grid();
    let centre = |cell: usize| cell_centre(cell % n, cell / n, n);
    let mut all = Vec::new();
    for outer in 0..n * n {
        for inner in 0..n * n {
            let pair = pack.header.parameterisation.from_axes(centre(outer), centre(inner));
            if pair.is_above_horizon() {
                all.push((outer, inner, pair));
            }
        }
    }
    all
}

/// Packs of both parameterisations and all texel formats.
fn some_packs() -> Vec<WaveletPack> {
    let mut packs = Vec::new();
    for (_, parameterisation) in Parameterisation::NAMES {
        for (levels, channels, bits) in [(1, 1, 8), (2, 3, 8), (3, 1, 16), (3, 3, 12)] {
            packs.push(pack(header(parameterisation, levels, channels, bits), 1 << (2 * levels - 1), 7));
        }
    }
    packs
}

#[test]
fn a_constant_pack_is_constant() {
    for (_, parameterisation) in Parameterisation::NAMES {
        for levels in 1..=6 {
            let mut pack = pack(header(parameterisation, levels, 1, 8), 1, 0);
            pack.scales[1] = SliceScale { scale: 0.0, offset: 1.5 * pack.header.grid() as f32 };
            let decoder = WaveletDecoder::new(&pack);
            let expected = 0.25 * (1.5f64.exp() - 0.01);
            for pair in pairs(50, 1) {
                for filter in FILTERS {
                    for level in [0.0, 0.5, 1.0, levels as f32] {
                        for value in decoder.eval(pair, level, filter) {
                            assert!((f64::from(value) / expected - 1.0).abs() < 1e-5, "{value} {expected}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn the_nearest_cell_is_the_cell_of_the_row() {
    for pack in some_packs() {
        let (decoder, rows) = (WaveletDecoder::new(&pack), rows(&pack));
        let levels = pack.header.levels as f32;
        for (outer, inner, pair) in centres(&pack) {
            let value = decoder.eval(pair, levels, Filter::Nearest);
            for channel in 0..3 {
                let expected = rows[outer][channel.min(rows[outer].len() - 1)][inner];
                let found = log_value(&pack, value[channel]);
                assert!((found - f64::from(expected)).abs() < 1e-4, "{found} {expected}");
                let relative = value[channel] / decoder.from_log(expected) - 1.0;
                assert!(relative.abs() < 1e-5, "{relative}");
            }
        }
    }
}

#[test]
fn bilinear_at_cell_centres_is_the_nearest_cell() {
    for pack in some_packs() {
        let decoder = WaveletDecoder::new(&pack);
        for (_, _, pair) in centres(&pack) {
            for level in [0.0, 1.0, 1.5, 3.0] {
                let nearest = decoder.eval(pair, level, Filter::Nearest);
                let bilinear = decoder.eval(pair, level, Filter::Bilinear);
                for channel in 0..3 {
                    assert!((bilinear[channel] / nearest[channel] - 1.0).abs() < 1e-4, "{bilinear:?} {nearest:?}");
                }
            }
        }
    }
}

#[test]
fn a_level_of_detail_is_the_mean_of_the_cells_below_it() {
    for pack in some_packs() {
        let (decoder, rows) = (WaveletDecoder::new(&pack), rows(&pack));
        let (n, levels) = (pack.header.grid(), pack.header.levels as usize);
        for (outer, inner, pair) in centres(&pack) {
            for level in 0..=levels {
                let side = n >> level;
                let (first_column, first_row) = (inner % n / side * side, inner / n / side * side);
                let value = decoder.eval(pair, level as f32, Filter::Nearest);
                for channel in 0..pack.header.channels as usize {
                    let mut sum = 0.0;
                    for row in first_row..first_row + side {
                        for column in first_column..first_column + side {
                            sum += f64::from(rows[outer][channel][row * n + column]);
                        }
                    }
                    let expected = sum / (side * side) as f64;
                    let found = log_value(&pack, value[channel]);
                    assert!((found - expected).abs() < 1e-4, "level {level}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_fractional_level_blends_its_neighbours_in_the_log_domain() {
    for pack in some_packs() {
        let decoder = WaveletDecoder::new(&pack);
        for pair in pairs(30, 3) {
            for filter in FILTERS {
                for lower in 0..pack.header.levels {
                    let [a, b, mid] = [0.0, 1.0, 0.25]
                        .map(|part| decoder.eval(pair, lower as f32 + part, filter).map(|f| log_value(&pack, f)));
                    for channel in 0..3 {
                        let expected = 0.75 * a[channel] + 0.25 * b[channel];
                        assert!((mid[channel] - expected).abs() < 1e-4, "{mid:?} {a:?} {b:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn levels_outside_the_range_are_clamped() {
    let pack = pack(header(Parameterisation::TangentPole, 3, 3, 8), 20, 2);
    let decoder = WaveletDecoder::new(&pack);
    for pair in pairs(20, 4) {
        for (outside, inside) in [(-1.0, 0.0), (f32::NEG_INFINITY, 0.0), (3.5, 3.0), (f32::INFINITY, 3.0)] {
            let [a, b] = [outside, inside].map(|level| decoder.eval(pair, level, Filter::Bilinear));
            assert_eq!(a, b);
        }
    }
}

#[test]
fn dropped_coefficients_contribute_nothing() {
    let full = pack(header(Parameterisation::TangentPole, 2, 3, 8), 16, 9);
    let slice_bytes = full.header.cells() * 4;
    for dropped in 1..16 {
        // The same coefficient as a slice of zeros and as a 0 in the index map.
        let mut zeros = full.clone();
        zeros.scales[dropped + 1] = SliceScale::default();
        let mut absent = full.clone();
        for entry in &mut absent.index[dropped..] {
            *entry -= 1;
        }
        absent.index[dropped] = 0;
        absent.scales.remove(dropped + 1);
        absent.texels.drain((dropped + 1) * slice_bytes..(dropped + 2) * slice_bytes);
        let absent = WaveletPack::from_bytes(&absent.to_bytes(false)).unwrap();
        let [full, zeros, absent] = [&full, &zeros, &absent].map(WaveletDecoder::new);
        let mut changed = 0;
        for pair in pairs(40, 6) {
            for filter in FILTERS {
                assert_eq!(zeros.eval(pair, 2.0, filter), absent.eval(pair, 2.0, filter));
                changed += usize::from(full.eval(pair, 2.0, filter) != absent.eval(pair, 2.0, filter));
            }
        }
        assert!(changed > 0, "coefficient {dropped} has no effect in this test");
    }
}

#[test]
fn grey_packs_repeat_their_channel() {
    for bits in [8, 16] {
        let decoder = WaveletDecoder::new(&pack(header(Parameterisation::HalfDifference, 3, 1, bits), 30, 4));
        for pair in pairs(50, 8) {
            for filter in FILTERS {
                let [r, g, b] = decoder.eval(pair, 3.0, filter);
                assert!(r > 0.0 && r == g && g == b);
            }
        }
    }
}

#[test]
fn nothing_is_reflected_at_or_below_the_horizon() {
    let up = DirectionPair::from_angles(0.4, 1.0, 0.7, 2.0);
    for (_, parameterisation) in Parameterisation::NAMES {
        let decoder = WaveletDecoder::new(&pack(header(parameterisation, 2, 3, 8), 9, 4));
        for filter in FILTERS {
            assert!(decoder.eval(up, 2.0, filter)[0] > 0.0);
            for below in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [0.0, 0.0, -1.0]] {
                for pair in [DirectionPair::new(below, up.outgoing), DirectionPair::new(up.incoming, below)] {
                    assert_eq!(decoder.eval(pair, 2.0, filter), [0.0; 3]);
                }
            }
        }
    }
}

/// Number of the coefficient to which a half turn of the inner image maps `k`; all details change sign.
fn half_turn(k: usize) -> usize {
    let first = 1usize << (k.ilog2() / 2 * 2);
    // Each kind of detail is one block, in reading order: latitude in [first, 2 first), longitude up to 4 first.
    if k < 2 * first { 3 * first - 1 - k } else { 6 * first - 1 - k }
}

#[test]
fn half_difference_packs_with_half_turn_symmetry_are_reciprocal() {
    let plain = pack(header(Parameterisation::HalfDifference, 2, 3, 8), 16, 11);
    let mut symmetric = plain.clone();
    let slice_bytes = plain.header.cells() * 4;
    for k in 1..16 {
        let image = half_turn(k);
        assert_eq!(half_turn(image), k);
        let [from, to] = [k, image].map(|k| usize::from(plain.index[k]));
        if image == k {
            symmetric.scales[to] = SliceScale::default();
        } else if image > k {
            let SliceScale { scale, offset } = plain.scales[from];
            symmetric.scales[to] = SliceScale { scale, offset: -(offset + scale) };
            for byte in 0..slice_bytes {
                symmetric.texels[to * slice_bytes + byte] = 255 - plain.texels[from * slice_bytes + byte];
            }
        }
    }
    let asymmetry = |pack: &WaveletPack| {
        let decoder = WaveletDecoder::new(pack);
        let mut largest = 0.0f32;
        for pair in pairs(200, 12) {
            for level in [1.0, 2.0] {
                let [a, b] = [pair, pair.exchanged()].map(|p| decoder.eval(p, level, Filter::Bilinear));
                largest = (0..3).fold(largest, |m, k| m.max((a[k] / b[k] - 1.0).abs()));
            }
        }
        largest
    };
    assert!(asymmetry(&symmetric) < 1e-4, "{}", asymmetry(&symmetric));
    assert!(asymmetry(&plain) > 0.1, "without the symmetry the check must fail");
}
