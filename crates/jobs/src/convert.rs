//! Converts any source to a measured file for other programs, and measures the error of the conversion.

use crate::error::Error;
use brdfc_codec::AveragingCost;
use brdfc_core::Source;
use brdfc_core::pair_list::PairList;
use brdfc_formats::FormatError;
use brdfc_formats::direction::DirectionPair;
use brdfc_metrics::compare::{Comparison, Reference, compare};
use brdfc_metrics::sampling::PairSet;
use brdfc_metrics::values::values_of_list;
use brdfc_readers::colour::rgb_weights;
use brdfc_readers::merl::{self, Dimensions, Merl, MerlError, pair_of_angles};
use brdfc_readers::rgl::Rgl;
use brdfc_readers::scan::Row;
use brdfc_readers::scan_csv;
use brdfc_source::rgl::resample::RglGrid;
use brdfc_source::scan::ScanSource;
use brdfc_source::{MerlSource, RglSource};
use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;

/// Largest polar angle of rows, degrees.
const MAX_POLAR_DEGREES: f64 = 85.0;
/// Number of incoming azimuths in a list of an anisotropic material.
const INCOMING_AZIMUTHS: usize = 8;

/// Largest relative change of an isotropic material's values when pairs are turned. Wavelet packs of isotropic materials at 16:1 stay
/// below it; materials whose roughness differs by a third between the axes do not.
const MAX_ANISOTROPY: f64 = 0.08;
/// Number of azimuths over which tables average, if a material does not declare itself isotropic.
const TURNS: usize = 4;

/// File format to convert to, with its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A MERL table, for isotropic materials.
    Merl(Dimensions),
    /// A list of direction pairs with their values.
    Csv(PairGrid),
    /// A material of the RGL database, in RGB.
    Rgl,
}

/// Directions of a list: polar angles evenly from 0 to 85 degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairGrid {
    /// Number of incoming polar angles.
    pub incoming: usize,
    /// Number of outgoing polar angles.
    pub outgoing: usize,
    /// Number of outgoing azimuths over the full turn; at the normal there is one.
    pub azimuths: usize,
}

/// Result of a conversion: the file, and its error compared with the source.
#[derive(Debug, Clone)]
pub struct Converted {
    /// Contents of the file, in the target's format.
    pub bytes: Vec<u8>,
    /// Number of values in it.
    pub values: usize,
    /// Comparison of the file, as this program reads it, with the source.
    pub comparison: Comparison,
    /// Cause of a visible error; `None` below a mean ΔE of 1.
    pub loss: Option<String>,
}

/// Mean ΔE above which a conversion reports its cause.
const VISIBLE: f64 = 1.0;
/// Share of an error above which one property of the file is its cause.
const MAIN_SHARE: f64 = 0.5;

/// Reason why a source cannot be converted to the target.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ConvertError {
    /// A MERL table of an anisotropic material.
    #[error("material: anisotropic, but MERL tables have no azimuth; write a .csv or .bsdf file instead")]
    Anisotropic,
    /// The file is invalid: a table or a list is too small.
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl From<ConvertError> for Error {
    fn from(error: ConvertError) -> Self {
        match error {
            ConvertError::Anisotropic => Self::input(error),
            ConvertError::Format(error) => Self::own_layout(error),
        }
    }
}

impl From<MerlError> for ConvertError {
    fn from(error: MerlError) -> Self {
        match error {
            MerlError::Format(error) => Self::Format(error),
            MerlError::Io(error) => unreachable!("memory can be read: {error}"),
        }
    }
}

/// Resamples a source, and compares the file with it at the direction pairs of packs.
///
/// # Errors
/// Returns an error if an anisotropic source is converted to a MERL table, or if the size is too small.
pub fn convert(source: &dyn Source, target: Target) -> Result<Converted, ConvertError> {
    let set = PairSet::within(source.directions());
    match target {
        Target::Merl(dimensions) => {
            // Wavelet packs do not declare isotropy, so it is measured.
            if !source.symmetry().isotropic && anisotropy(source) > MAX_ANISOTROPY {
                return Err(ConvertError::Anisotropic);
            }
            let (bytes, values) = merl_table(source, dimensions);
            let table = Merl::from_bytes(&bytes)?;
            let reference = Reference::new(source, set);
            let comparison = reference.compare(&MerlSource::new(table));
            let loss = loss(&comparison, || merl_cause(source, dimensions, &comparison, &reference));
            Ok(Converted { bytes, values, comparison, loss })
        }
        Target::Rgl => {
            let (bytes, values) = rgl(source)?;
            let found = RglSource::new(Rgl::from_bytes(&bytes)?, rgb_weights)?;
            let comparison = compare(source, &found, &set).0;
            let loss = loss(&comparison, || "the grid of directions of the .bsdf file is too coarse for it".to_owned());
            Ok(Converted { bytes, values, comparison, loss })
        }
        Target::Csv(grid) => {
            let rows = rows(source, grid);
            let mut bytes = Vec::new();
            scan_csv::write(&mut bytes, &rows).expect("memory can be written to");
            let scan = ScanSource::new(&scan_csv::from_bytes(&bytes)?)?;
            let comparison = compare(source, &scan, &set).0;
            let loss = loss(&comparison, || {
                let PairGrid { incoming, outgoing, azimuths } = grid;
                format!(
                    "the list of {incoming}x{outgoing}x{azimuths} directions is too coarse for it; --grid sets another"
                )
            });
            Ok(Converted { bytes, values: rows.len(), comparison, loss })
        }
    }
}

/// Sentence about a visible error of a conversion.
fn loss(comparison: &Comparison, cause: impl FnOnce() -> String) -> Option<String> {
    let found = &comparison.rendering.delta_e;
    let is_visible = found.mean > VISIBLE;
    is_visible.then(|| {
        let cause = cause();
        format!(
            "the file differs from its source by a mean ΔE of {:.2}, 95 % below {:.2}: {cause}",
            found.mean, found.p95
        )
    })
}

/// The property of a MERL table with the largest part in its error.
fn merl_cause(source: &dyn Source, size: Dimensions, comparison: &Comparison, reference: &Reference) -> String {
    let of_all = comparison.rendering.delta_e.mean;
    if !source.symmetry().reciprocal && !size.is_full_turn() {
        let alone = AveragingCost::of(source, reference).delta_e;
        if alone > MAIN_SHARE * of_all {
            return format!(
                "a MERL table has one value for both orders of light and viewer, the mean of the source's two values, which \
                 alone costs a ΔE of {alone:.2}; .csv and .bsdf files keep both"
            );
        }
    }
    let Dimensions { theta_half, theta_difference, phi_difference } = size;
    let coarse = format!("{theta_half}x{theta_difference}x{phi_difference} cells are too few for it");
    if source.symmetry().isotropic {
        format!("{coarse}, or it is noisy; --dimensions sets others")
    } else {
        format!("a MERL table has no azimuth of incidence, or {coarse}")
    }
}

/// Bytes of a MERL table, and the number of cells with a value. Where the table has a single value for both orders of light and
/// viewer, and the source two, it is their mean.
fn merl_table(source: &dyn Source, dimensions: Dimensions) -> (Vec<u8>, usize) {
    let write = |value: &dyn Fn([f64; 3]) -> Option<[f64; 3]>| {
        let mut bytes = Vec::new();
        merl::write(&mut bytes, dimensions, value).expect("memory can be written to");
        bytes
    };
    // The first pass collects the directions to evaluate them together; the second writes the values.
    let asked = RefCell::new(Vec::new());
    let above = |angles| Some(pair_of_angles(angles)).filter(|pair| pair.is_above_horizon());
    write(&|angles| {
        asked.borrow_mut().extend(above(angles));
        None
    });
    let pairs = asked.into_inner();
    let mut values = means_over_azimuths(source, &pairs);
    if !source.symmetry().reciprocal && !dimensions.is_full_turn() {
        let exchanged: Vec<DirectionPair> = pairs.iter().map(|pair| pair.exchanged()).collect();
        for (value, other) in values.iter_mut().zip(means_over_azimuths(source, &exchanged)) {
            *value = std::array::from_fn(|channel| 0.5 * (value[channel].max(0.0) + other[channel].max(0.0)));
        }
    }
    let next = Cell::new(0);
    let bytes = write(&|angles| {
        above(angles)?;
        next.set(next.get() + 1);
        Some(values[next.get() - 1].map(|f| f.max(0.0)))
    });
    (bytes, values.len())
}

/// Values at pairs, as means over azimuths if the source is not known to be isotropic.
fn means_over_azimuths(source: &dyn Source, pairs: &[DirectionPair]) -> Vec<[f64; 3]> {
    let turns = if source.symmetry().isotropic { 1 } else { TURNS };
    let mut sums = vec![[0.0; 3]; pairs.len()];
    for turn in 0..turns {
        let angle = TAU * turn as f64 / turns as f64;
        let turned: Vec<DirectionPair> = pairs.iter().map(|pair| turned(*pair, angle)).collect();
        let (values, _) = values_of_list(source, &PairList::new(turned));
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum = std::array::from_fn(|channel| sum[channel] + value[channel] / turns as f64);
        }
    }
    sums
}

/// Relative change of values when pairs are turned about the normal, weighted by both cosines.
fn anisotropy(source: &dyn Source) -> f64 {
    let at = |k: u32, step: f64| (f64::from(k) * step).fract();
    let pair = |k: u32| {
        DirectionPair::from_angles(
            1.2 * at(k, 0.754_877_7),
            TAU * at(k, 0.569_840_3),
            1.2 * at(k, 0.362_437),
            TAU * at(k, 0.819_172_5),
        )
    };
    let pairs: Vec<DirectionPair> = (1..400).map(pair).collect();
    let values =
        |angle: f64| values_of_list(source, &PairList::new(pairs.iter().map(|pair| turned(*pair, angle)).collect())).0;
    let first = values(0.0);
    let (mut apart, mut all) = (0.0, 0.0);
    for turn in 1..5 {
        for ((pair, a), b) in pairs.iter().zip(&first).zip(values(0.6 * f64::from(turn))) {
            let weight = pair.incoming[2] * pair.outgoing[2];
            for channel in 0..3 {
                apart += weight * (a[channel] - b[channel]).abs();
                all += weight * a[channel].max(b[channel]);
            }
        }
    }
    if all > 0.0 { apart / all } else { 0.0 }
}

/// Turns both directions about the normal.
fn turned(pair: DirectionPair, angle: f64) -> DirectionPair {
    let (sine, cosine) = angle.sin_cos();
    let turn = |[x, y, z]: [f64; 3]| [cosine * x - sine * y, sine * x + cosine * y, z];
    if angle == 0.0 { pair } else { DirectionPair::new(turn(pair.incoming), turn(pair.outgoing)) }
}

/// Bytes of an RGL material, and the number of values in it.
fn rgl(source: &dyn Source) -> Result<(Vec<u8>, usize), FormatError> {
    let evaluated = |pairs: &[DirectionPair]| values_of_list(source, &PairList::new(pairs.to_vec())).0;
    let grid = RglGrid::of(source.symmetry().isotropic);
    let distributions = grid.distributions(&evaluated(&grid.retro_pairs()))?;
    let pairs = distributions.pairs();
    let values = evaluated(&pairs);
    let description = format!("resampled by brdfc {}", env!("CARGO_PKG_VERSION"));
    Ok((distributions.finish(&values, description).to_bytes(), values.len()))
}

/// Rows over a grid of directions.
fn rows(source: &dyn Source, grid: PairGrid) -> Vec<Row> {
    let polar = |k: usize, count: usize| (MAX_POLAR_DEGREES * k as f64 / (count - 1).max(1) as f64).to_radians();
    let turned = if source.symmetry().isotropic { 1 } else { INCOMING_AZIMUTHS };
    let mut angles = Vec::new();
    for i in 0..grid.incoming {
        // At the normal there is one azimuth.
        for phi_i in (0..if i == 0 { 1 } else { turned }).map(|k| TAU * k as f64 / turned as f64) {
            for o in 0..grid.outgoing {
                let azimuths = if o == 0 { 1 } else { grid.azimuths };
                let phi_o = (0..azimuths).map(|k| TAU * k as f64 / azimuths as f64);
                angles.extend(phi_o.map(|phi_o| [polar(i, grid.incoming), phi_i, polar(o, grid.outgoing), phi_o]));
            }
        }
    }
    let pair =
        |[theta_i, phi_i, theta_o, phi_o]: &[f64; 4]| DirectionPair::from_angles(*theta_i, *phi_i, *theta_o, *phi_o);
    let (values, _) = values_of_list(source, &PairList::new(angles.iter().map(pair).collect()));
    let row =
        |([theta_i, phi_i, theta_o, phi_o], value): ([f64; 4], [f64; 3])| Row { theta_i, phi_i, theta_o, phi_o, value };
    angles.into_iter().zip(values).map(row).collect()
}
