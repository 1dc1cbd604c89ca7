//! Figures of an independent prototype of the method for the full 32 x 32 x 32 x 32 table, one channel.

use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::ErrorSummary;
use brdfc_formats::direction::{DirectionPair, Parameterisation, Vector, from_tangent_pole, to_tangent_pole};
use brdfc_formats::wavelet::{WaveletDecoder, WaveletPack};
use brdfc_wavelet::encode::{Encoded, encode};
use brdfc_wavelet::log_encode::{DEFAULT_BIAS, LogEncoding, log_encode};
use brdfc_wavelet::measure::grid_error;
use brdfc_wavelet::quantise::quantise;
use brdfc_wavelet::recipe::{Recipe, Target};
use brdfc_wavelet::resample::resample;
use brdfc_wavelet::table::Grid;
use brdfc_wavelet::{haar, threshold};

const GRID: Grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 5 };

struct Known {
    address: &'static str,
    mean: f64,
    /// `ε_r` before quantisation at 4:1, 16:1 and 32:1, a fraction.
    relative: [f64; 3],
}

const LEWIS: Known =
    Known { address: "synth:lewis?kd=0.6&ks=0.3&n=20", mean: 0.246_335, relative: [0.019_734, 0.043_707, 0.059_339] };
const WARD: Known = Known {
    address: "synth:ward?kd=0.2&ks=0.1&ax=0.15&ay=0.5",
    mean: 0.081_077,
    relative: [0.025_143, 0.062_858, 0.082_903],
};
const RATIOS: [f64; 3] = [4.0, 16.0, 32.0];

fn source(known: &Known) -> Box<dyn Source> {
    parse_synth(known.address).unwrap()
}

fn encoded(source: &dyn Source, ratio: f64, bits: u32, bias: f64) -> Encoded {
    let target = Target::Ratio(ratio);
    let recipe = Recipe { target, bits, bias, measure_off_grid: false, supercompress: false, ..Recipe::default() };
    encode(source, &recipe, &()).unwrap()
}

/// `ε_r` on the grid.
fn error(source: &dyn Source, ratio: f64, bits: u32) -> f64 {
    encoded(source, ratio, bits, DEFAULT_BIAS).on_grid.norms.relative_mean
}

/// Within 0.5 % of a known figure.
fn agrees(found: f64, known: f64) -> bool {
    (found / known - 1.0).abs() <= 0.005
}

fn check_ratios(known: &Known) {
    let source = source(known);
    for (ratio, expected) in RATIOS.into_iter().zip(known.relative) {
        let fine = encoded(source.as_ref(), ratio, 16, DEFAULT_BIAS);
        let found = fine.on_grid.norms.relative_mean;
        println!("{} {ratio}:1: {:.4} %", known.address, 100.0 * found);
        assert!(agrees(f64::from(fine.pack.header.mean), known.mean), "{}", fine.pack.header.mean);
        assert_eq!(fine.pack.slices() - 1, (1024.0 / ratio) as usize);
        assert!(agrees(found, expected), "{} {ratio}:1: {found}", known.address);
        let coarse = error(source.as_ref(), ratio, 8);
        assert!(coarse - found <= 0.001, "{} {ratio}:1: 8 bits add {}", known.address, coarse - found);
    }
}

#[test]
fn lewis_at_three_ratios() {
    check_ratios(&LEWIS);
}

#[test]
fn ward_at_three_ratios() {
    check_ratios(&WARD);
}

#[test]
fn with_every_slice_only_quantisation_is_left() {
    for known in [&LEWIS, &WARD] {
        let source = source(known);
        let [coarse, fine] = [8, 16].map(|bits| error(source.as_ref(), 1.0, bits));
        println!("{} 1:1: {:.4} % at 8 bits, {:.6} % at 16", known.address, 100.0 * coarse, 100.0 * fine);
        assert!(coarse <= 0.002, "{}: {coarse}", known.address);
        assert!(fine <= 0.000_01, "{}: {fine}", known.address);
        assert!(fine > 0.0 && coarse > fine, "quantisation is visible: {fine} {coarse}");
    }
}

/// A source with exchanged longitude and colatitude, so that the transform splits colatitude first.
struct Transposed(Box<dyn Source>);

impl Source for Transposed {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        let exchange = |d: Vector| {
            let [longitude, colatitude] = to_tangent_pole(d);
            from_tangent_pole([colatitude, longitude])
        };
        self.0.eval(DirectionPair::new(exchange(pair.incoming), exchange(pair.outgoing)), tally)
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry { isotropic: false, ..self.0.symmetry() }
    }

    fn is_grey(&self) -> bool {
        true
    }
}

#[test]
fn splitting_the_other_axis_first_is_noticed() {
    for known in [&LEWIS, &WARD] {
        let transposed = Transposed(source(known));
        let same_mean = encoded(&transposed, 4.0, 16, DEFAULT_BIAS);
        assert!(agrees(f64::from(same_mean.pack.header.mean), known.mean));
        let found = same_mean.on_grid.norms.relative_mean;
        println!("{} transposed: {:.4} %", known.address, 100.0 * found);
        assert!(!agrees(found, known.relative[0]), "{}: {found}", known.address);
    }
}

#[test]
fn another_bias_is_noticed() {
    let found = encoded(source(&WARD).as_ref(), 32.0, 16, 0.1).on_grid.norms.relative_mean;
    println!("{} 32:1, bias 0.1: {:.4} %", WARD.address, 100.0 * found);
    assert!(!agrees(found, WARD.relative[2]), "{found}");
}

/// `ε_r` of a pack of chosen slices, put together from the stages.
fn error_of_slices(known: &Known, choose: impl Fn(&[u32]) -> Vec<u32>) -> f64 {
    let (table, _) = resample(source(known).as_ref(), GRID);
    let encoding = LogEncoding::of(&table, DEFAULT_BIAS);
    let coefficients = haar::transform(&log_encode(&table, encoding));
    let mut slices = choose(&threshold::ranking(&threshold::slice_energies(&coefficients), 5));
    slices.sort_unstable();
    let header = brdfc_formats::wavelet::Header {
        parameterisation: GRID.parameterisation,
        levels: 5,
        stored_levels: 5,
        channels: 1,
        bits: 16,
        mean: encoding.mean as f32,
        bias: encoding.bias as f32,
        energy_preserving: false,
    };
    let quantised = quantise(&coefficients, &slices, &header);
    let mut index = vec![0u16; header.cells()];
    for (slice, k) in (1..).zip(&slices) {
        index[*k as usize] = slice;
    }
    let pack = WaveletPack {
        header,
        index,
        scales: quantised.scales,
        on_grid: ErrorSummary::default(),
        off_grid: ErrorSummary::default(),
        crop: None,
        texels: quantised.texels,
    };
    grid_error(&table, &WaveletDecoder::new(&pack), brdfc_formats::crop::DirectionRange::ALL).norms.relative_mean
}

#[test]
fn keeping_the_weakest_slices_is_far_worse() {
    let strongest = error_of_slices(&LEWIS, |ranking| ranking[..256].to_vec());
    assert!(agrees(strongest, LEWIS.relative[0]), "{strongest}");
    let weakest = error_of_slices(&LEWIS, |ranking| [&ranking[..1], &ranking[ranking.len() - 255..]].concat());
    assert!(weakest > 5.0 * strongest, "{weakest}");
}
