//! The stages under test, each as a replaceable function, since the tests must detect broken stages.

use brdfc_bandwidth::daubechies;
use brdfc_core::Source;
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::propagation::{Bandwidth, BandwidthAverage, BandwidthSurface, pyramid_level};
use brdfc_formats::direction::{DirectionPair, Parameterisation, Vector, polynomial_atan2, to_tangent_pole};
use brdfc_formats::table::{Angles, TableDecoder, TablePack};
use brdfc_formats::vector_math;
use brdfc_formats::wavelet::haar::inverse;
use brdfc_formats::wavelet::{Filter, Header, WaveletDecoder, WaveletPack};
use brdfc_jobs::encode::EncodeError;
use brdfc_source::ScanSource;
use brdfc_source::scan::fit;
use brdfc_source::smooth::{Grid, Smoothed, smooth};
use brdfc_table::encode::Prepared;
use brdfc_table::lattice::Equations;
use brdfc_table::recipe::TableRecipe;
use brdfc_wavelet::encode::Encoded;
use brdfc_wavelet::energy::means;
use brdfc_wavelet::haar::forward;
use brdfc_wavelet::log_encode::{LogEncoding, log_encode};
use brdfc_wavelet::quantise::{Quantised, quantise};
use brdfc_wavelet::recipe::Recipe;
use brdfc_wavelet::table::Table;
use brdfc_wavelet::threshold::{keep, ranking, slice_energies};

/// Basis, weights and residuals of a local fit. Returns its values at the queried point, linear and quadratic, and
/// their variance factors.
pub type LocalFit = fn(&[[f64; fit::TERMS_3D]], &[f64], &[[f64; 3]]) -> [f64; 4];

/// Neighbours of a point in three dimensions.
pub type Neighbourhood = fit::Neighbourhood<3, { fit::TERMS_3D }>;

/// Stages under test. [`Stages::default`] has the program's own.
#[derive(Debug, Clone, Copy)]
pub struct Stages {
    /// Direction to longitude and colatitude.
    pub to_tangent_pole: fn(Vector) -> [f64; 2],
    /// Direction pair to half and difference vector.
    pub to_half_difference: fn(DirectionPair) -> (Vector, Vector),
    /// Angles of decoders.
    pub atan2: fn(f32, f32) -> f32,
    /// Half-difference angles of tables.
    pub angles: fn(DirectionPair) -> Angles,
    /// Logarithm.
    pub ln: fn(f32) -> f32,
    /// Exponential.
    pub exp: fn(f32) -> f32,
    /// Log encoding of a table.
    pub log_encode: fn(&Table, LogEncoding) -> Table,
    /// Log decoding of one value.
    pub from_log: fn(&WaveletDecoder, f32) -> f32,
    /// Smoothing of a table with a radius.
    pub smooth: fn(&mut [[f32; 3]], Grid, Option<usize>) -> Smoothed,
    /// Table at a level of detail, with the albedos of the finest.
    pub means: fn(&Table, u32) -> Table,
    /// Haar analysis of a square image of this side.
    pub haar: fn(&[f32], usize) -> Vec<f32>,
    /// Haar synthesis.
    pub haar_inverse: fn(&[f32], usize) -> Vec<f32>,
    /// Energy of each slice of a table of coefficients.
    pub energies: fn(&Table) -> Vec<f64>,
    /// Selection of slices by energies, levels and number.
    pub threshold: fn(&[f64], u32, usize) -> Vec<u32>,
    /// Texels of slices.
    pub quantise: fn(&Table, &[u32], &Header) -> Quantised,
    /// Wavelet pack to bytes.
    pub write: fn(&WaveletPack) -> Vec<u8>,
    /// Wavelet pack from bytes.
    pub read: fn(&[u8]) -> Result<WaveletPack, FormatError>,
    /// Logarithm that a wavelet pack decodes to, at a level of detail.
    pub decode: fn(&WaveletDecoder, DirectionPair, f32) -> [f32; 3],
    /// Logarithm that a table pack decodes to.
    pub decode_table: fn(&TableDecoder, DirectionPair) -> [f32; 3],
    /// Solution of a table's normal equations, from a first guess.
    pub solve: fn(&Equations<1>, &mut [[f32; 1]]),
    /// A table pack, its nodes rounded to texels.
    pub table_pack: fn(&Prepared, &TableRecipe) -> Result<TablePack, EncodeError>,
    /// Moving least squares at one point.
    pub local_fit: LocalFit,
    /// First value that a neighbourhood of a scan gives at the queried point.
    pub neighbourhood: fn(&mut Neighbourhood) -> f64,
    /// Value of a scan at a pair.
    pub scan: fn(&ScanSource, DirectionPair) -> [f64; 3],
    /// Bandwidth over one reflection.
    pub one_bounce: fn(Bandwidth, f32, BandwidthSurface, f32) -> Bandwidth,
    /// Mean bandwidth of incoming directions.
    pub mean_bandwidth: fn(BandwidthAverage) -> Bandwidth,
    /// Level of the pyramid for a bandwidth.
    pub pyramid_level: fn(f32, i32) -> i32,
    /// Daubechies transform of a square image, followed by its inverse.
    pub daubechies: fn(&[f32], usize) -> Vec<f32>,
    /// Source to wavelet pack.
    pub encode: fn(&dyn Source, &Recipe) -> Result<Encoded, EncodeError>,
}

/// Steps of conjugate gradients, as in a fit.
pub const STEPS: usize = 30;

impl Default for Stages {
    fn default() -> Self {
        Self {
            to_tangent_pole,
            to_half_difference: |pair| Parameterisation::HalfDifference.to_axes(pair),
            atan2: polynomial_atan2,
            angles: Angles::of,
            ln: vector_math::ln,
            exp: vector_math::exp,
            log_encode,
            from_log: WaveletDecoder::from_log,
            smooth,
            means,
            haar: |samples, n| {
                let mut coefficients = vec![0.0; n * n];
                forward(samples, n, &mut coefficients, &mut Vec::new());
                coefficients
            },
            haar_inverse: |coefficients, n| {
                let mut samples = vec![0.0; n * n];
                inverse(coefficients, n, &mut samples, &mut Vec::new());
                samples
            },
            energies: slice_energies,
            threshold: |energies, levels, count| keep(&ranking(energies, levels), count),
            quantise,
            write: |pack| pack.to_bytes(true),
            read: WaveletPack::from_bytes,
            decode: |decoder, pair, level| decoder.log_value(pair, level, Filter::Bilinear),
            decode_table: |decoder, pair| decoder.log_values(pair, decoder.levels() as f32).fine,
            solve: |equations, x| equations.solve(x, STEPS),
            table_pack: |prepared, recipe| prepared.pack(recipe, &()),
            local_fit: |basis, weights, residuals| {
                let solved = fit::solve::<3, { fit::TERMS_3D }>(basis, weights, residuals);
                [solved.linear[0][0], solved.quadratic[0][0], solved.variance[0], solved.variance[1]]
            },
            neighbourhood: |neighbourhood| neighbourhood.fit(1, &mut brdfc_core::Tally::default())[0],
            scan: |source, pair| source.eval(pair, &mut brdfc_core::Tally::default()),
            one_bounce: Bandwidth::one_bounce,
            mean_bandwidth: BandwidthAverage::mean,
            pyramid_level,
            daubechies: |image, n| daubechies::inverse(&daubechies::forward(image, n, n)),
            encode: |source, recipe| brdfc_wavelet::encode::encode(source, recipe, &()),
        }
    }
}
