//! Compares the decoder with the equations of `formats/src/wavelet/spec.md`, implemented here independently in double
//! precision. With a mistake in these equations the two must disagree.

use std::f64::consts::{PI, SQRT_2};

use brdfc_formats::direction::{DirectionPair, Parameterisation};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_testing::codecs::wavelet::{energy_preserving, header, pack};
use brdfc_testing::packs::pairs;

/// One wrong constant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mistake {
    None,
    LatitudeSign,
    LongitudeSign,
    LongitudeWeight,
    LatitudeWeight,
    ScalingWeight,
    SwappedDetails,
    SwappedAxes,
    ColumnsFirst,
    NoBias,
    NoMean,
    TexelRange,
    CellEdges,
    FinestTree,
    SwappedCells,
    CoarserLevel,
}

struct Equations<'a> {
    pack: &'a WaveletPack,
    mistake: Mistake,
}

impl Equations<'_> {
    fn is(&self, mistake: Mistake) -> bool {
        self.mistake == mistake
    }

    fn sign(&self, mistake: Mistake) -> f64 {
        if self.is(mistake) { -1.0 } else { 1.0 }
    }

    /// Coefficient `k` at an outer cell.
    fn coefficient(&self, k: usize, cell: usize, channel: usize) -> f64 {
        let header = &self.pack.header;
        let slice = usize::from(self.pack.index[k]);
        let components = if header.channels == 1 { 1 } else { 4 };
        let component = ((slice << (2 * header.levels)) + cell) * components + channel.min(components - 1);
        let (stored, full) = if header.bits == 8 {
            (u32::from(self.pack.texels[component]), 255.0)
        } else {
            let low = u32::from(self.pack.texels[2 * component]);
            (low + 256 * u32::from(self.pack.texels[2 * component + 1]), 65535.0)
        };
        let full = if self.is(Mistake::TexelRange) { full + 1.0 } else { full };
        let scale = self.pack.scales[slice];
        f64::from(scale.offset) + f64::from(scale.scale) * f64::from(stored) / full
    }

    /// `v(c, r)` at level of detail `l`.
    fn value(&self, cell: usize, column: usize, row: usize, level: f64, channel: usize) -> f64 {
        let header = &self.pack.header;
        let level = level.clamp(0.0, f64::from(header.levels));
        let of_level = |whole: f64| {
            let depth = whole as u32;
            if !header.energy_preserving || depth >= header.stored_levels || self.is(Mistake::FinestTree) {
                return self.path(0, header.levels, cell, [column, row], whole, channel);
            }
            // Trees of 1, 4, 16, ... coefficients follow the finest one.
            let first = (1usize << (2 * header.levels)) + (0..depth).map(|l| 4usize.pow(l)).sum::<usize>();
            let at = [column, row].map(|at| at >> (header.levels - depth));
            let at = if self.is(Mistake::SwappedCells) { [at[1], at[0]] } else { at };
            self.path(first, depth, cell, at, whole, channel)
        };
        if !header.energy_preserving {
            return self.path(0, header.levels, cell, [column, row], level, channel);
        }
        let part = if self.is(Mistake::CoarserLevel) { 0.0 } else { level.fract() };
        (1.0 - part) * of_level(level.floor()) + part * of_level(level.ceil())
    }

    /// Sum of the tree of `n` levels that starts at the coefficient `first`, up to a level.
    fn path(&self, first: usize, n: u32, cell: usize, [column, row]: [usize; 2], level: f64, channel: usize) -> f64 {
        let coefficient = |k| self.coefficient(first + k, cell, channel);
        let n = n as i32;
        let scaling = if self.is(Mistake::ScalingWeight) { 1 - n } else { -n };
        let mut sum = 2f64.powi(scaling) * coefficient(0);
        for j in 0..n {
            let part = (level - f64::from(j)).clamp(0.0, 1.0);
            let bit = |x: usize, k: i32| (x >> k) & 1;
            let above = |x: usize, k: i32| x >> k;
            let side = 1usize << j;
            let mut latitude = side * side + above(row, n - j) * side + above(column, n - j);
            let mut longitude = 2 * side * side + above(row, n - j - 1) * side + above(column, n - j);
            if self.is(Mistake::SwappedDetails) {
                std::mem::swap(&mut latitude, &mut longitude);
            }
            let plus_or_minus = |bit: usize| if bit == 0 { 1.0 } else { -1.0 };
            let weight = 2f64.powi(j - n);
            let latitude_weight = weight * if self.is(Mistake::LatitudeWeight) { SQRT_2 } else { 1.0 };
            let longitude_weight = weight * if self.is(Mistake::LongitudeWeight) { 1.0 } else { SQRT_2 };
            let of_rows = part * latitude_weight * self.sign(Mistake::LatitudeSign) * coefficient(latitude);
            let of_columns = part * longitude_weight * self.sign(Mistake::LongitudeSign) * coefficient(longitude);
            sum += plus_or_minus(bit(row, n - j - 1)) * of_rows + plus_or_minus(bit(column, n - j - 1)) * of_columns;
        }
        sum
    }

    /// Cells and weights along one axis, for an angle in `[0, π]`.
    fn taps(&self, angle: f64) -> [(usize, f64); 2] {
        let n = self.pack.header.grid() as f64;
        let centre = if self.is(Mistake::CellEdges) { 0.0 } else { 0.5 };
        let x = (angle / PI * n - centre).clamp(0.0, n - 1.0);
        let (lower, weight) = (x.floor(), x.fract());
        [(lower as usize, 1.0 - weight), ((lower + 1.0).min(n - 1.0) as usize, weight)]
    }

    /// Four cells `(column, row)` of a hemisphere and their weights.
    fn footprint(&self, d: [f64; 3]) -> Vec<(usize, usize, f64)> {
        let longitude = self.taps(d[2].atan2(d[0]));
        let colatitude = self.taps(d[1].acos());
        let mut cells = Vec::new();
        for (column, a) in longitude {
            for (row, b) in colatitude {
                let (column, row) = if self.is(Mistake::ColumnsFirst) { (row, column) } else { (column, row) };
                cells.push((column, row, a * b));
            }
        }
        cells
    }

    fn f_r(&self, pair: DirectionPair, level: f64, channel: usize) -> f64 {
        let (mut outer, mut inner) = match self.pack.header.parameterisation {
            Parameterisation::TangentPole => (pair.incoming, pair.outgoing),
            Parameterisation::HalfDifference => half_and_difference(pair),
        };
        if self.is(Mistake::SwappedAxes) {
            std::mem::swap(&mut outer, &mut inner);
        }
        let n = self.pack.header.grid();
        let mut log = 0.0;
        for (outer_column, outer_row, outer_weight) in self.footprint(outer) {
            for (column, row, inner_weight) in self.footprint(inner) {
                let cell = outer_row * n + outer_column;
                log += outer_weight * inner_weight * self.value(cell, column, row, level, channel);
            }
        }
        let bias = if self.is(Mistake::NoBias) { 0.0 } else { f64::from(self.pack.header.bias) };
        let mean = if self.is(Mistake::NoMean) { 1.0 } else { f64::from(self.pack.header.mean) };
        (mean * (log.exp() - bias)).max(0.0)
    }
}

/// The half vector, and the incoming direction rotated about `half x normal` by the angle between them (Rodrigues).
fn half_and_difference(pair: DirectionPair) -> ([f64; 3], [f64; 3]) {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |v: [f64; 3]| v.map(|c| c / dot(v, v).sqrt());
    let (i, o) = (pair.incoming, pair.outgoing);
    let half = unit([i[0] + o[0], i[1] + o[1], i[2] + o[2]]);
    let axis = unit(cross(half, [0.0, 0.0, 1.0]));
    let (cosine, sine) = (half[2], (1.0 - half[2] * half[2]).sqrt());
    let (turned, along) = (cross(axis, i), dot(axis, i) * (1.0 - cosine));
    (half, [0, 1, 2].map(|k| i[k] * cosine + turned[k] * sine + axis[k] * along))
}

/// Largest relative difference between decoder and equations over directions, levels and channels.
fn difference(pack: &WaveletPack, mistake: Mistake) -> f64 {
    differences(pack, mistake, 120)[0]
}

/// Largest differences over `count` directions: relative to `f`, and to `f + μ ε`.
fn differences(pack: &WaveletPack, mistake: Mistake, count: usize) -> [f64; 2] {
    let decoder = WaveletDecoder::new(pack);
    let equations = Equations { pack, mistake };
    let offset = f64::from(pack.header.mean) * f64::from(pack.header.bias);
    let mut largest = [0.0f64; 2];
    for pair in pairs(count, 21) {
        for level in [0.0, 0.75, 1.0, 2.5, 9.0] {
            let found = decoder.eval(pair, level, Filter::Bilinear);
            for channel in 0..3 {
                let expected = equations.f_r(pair, f64::from(level), channel.min(pack.header.channels as usize - 1));
                let off = (f64::from(found[channel]) - expected).abs();
                let relative = if expected > 0.0 { off / expected } else { 0.0 };
                largest = [largest[0].max(relative), largest[1].max(off / (expected + offset))];
            }
        }
    }
    largest
}

fn cases() -> Vec<WaveletPack> {
    let mut cases = Vec::new();
    for (_, parameterisation) in Parameterisation::NAMES {
        for (levels, channels, bits) in [(1, 3, 8), (2, 1, 8), (2, 3, 16), (3, 1, 12), (3, 3, 8)] {
            cases.push(pack(header(parameterisation, levels, channels, bits), 1 << (2 * levels - 1), 31));
        }
    }
    for (levels, channels, bits) in [(1, 3, 8), (3, 1, 12), (3, 3, 8)] {
        cases.push(pack(energy_preserving(levels, channels, bits), 1 << (2 * levels - 1), 31));
    }
    cases
}

#[test]
fn the_decoder_follows_the_equations() {
    for pack in cases() {
        let difference = difference(&pack, Mistake::None);
        assert!(difference < 1e-5, "{difference:e} for {:?}", pack.header);
    }
}

/// Checks the bound on the page, up to the largest grids. Texels are random, so that neighbouring cells differ more
/// than in any material.
#[test]
fn the_decoder_is_within_the_bound_of_the_page() {
    let page = include_str!("../../src/wavelet/spec.md");
    assert!(
        page.contains(
            "abs(f' - f) <= 2e-5 (f + μ ε)          on grids of up to 32 x 32 cells, 4e-5 (f + μ ε) on 64 x 64"
        )
    );
    let mut largest = 0.0f64;
    for (_, parameterisation) in Parameterisation::NAMES {
        for (levels, bits) in [(1, 8), (2, 16), (3, 12), (4, 8), (5, 16), (6, 8)] {
            let mut made = pack(header(parameterisation, levels, 1, bits), 1 << levels, 31);
            // Unchanged, and with values about ε.
            for darker in [0.0, 5.5] {
                made.scales[1].offset -= darker * made.header.grid() as f32;
                let found = differences(&made, Mistake::None, 500);
                println!("{parameterisation:?}, {levels} levels, {darker} darker: {found:?}");
                let bound = if levels == 6 { 4e-5 } else { 2e-5 };
                assert!(found[1] < bound, "{levels}: {found:?}");
                largest = largest.max(found[0]);
            }
        }
    }
    assert!(largest > 1e-4, "relative to f alone there is no such bound: {largest}");
}

#[test]
fn mistakes_in_energy_preserving_packs_are_detected() {
    for mistake in [
        Mistake::FinestTree,
        Mistake::SwappedCells,
        Mistake::CoarserLevel,
        Mistake::ScalingWeight,
        Mistake::LatitudeSign,
    ] {
        let difference = difference(&pack(energy_preserving(3, 3, 8), 64, 31), mistake);
        assert!(difference > 1e-3, "{mistake:?}: {difference:e}");
    }
}

#[test]
fn every_mistake_is_detected() {
    use Mistake::{
        CellEdges, ColumnsFirst, LatitudeSign, LatitudeWeight, LongitudeSign, LongitudeWeight, NoBias, NoMean,
        ScalingWeight, SwappedAxes, SwappedDetails, TexelRange,
    };
    for mistake in [
        LatitudeSign,
        LongitudeSign,
        LongitudeWeight,
        LatitudeWeight,
        ScalingWeight,
        SwappedDetails,
        SwappedAxes,
        ColumnsFirst,
        NoBias,
        NoMean,
        TexelRange,
        CellEdges,
    ] {
        for (_, parameterisation) in Parameterisation::NAMES {
            let pack = pack(header(parameterisation, 3, 3, 8), 64, 31);
            let difference = difference(&pack, mistake);
            assert!(difference > 1e-3, "{mistake:?}: {difference:e}");
        }
    }
}
