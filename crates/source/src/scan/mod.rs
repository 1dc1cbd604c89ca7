//! Scattered scans as sources: nearest neighbours, completed and smoothed by moving least squares at the queried
//! direction pair.

mod coordinates;
mod detector;
mod facts;
pub mod fit;
mod folds;
mod incidence;
mod merge;
mod rise;
mod strength;
mod summary;

pub(crate) use detector::{rounding, saturation};
pub use facts::{AltaHeader, ScanFacts};
pub(crate) use folds::isotropic_distance;
pub(crate) use rise::rise_to_peaks;
pub use summary::ScanSummary;

use super::error::InputError;
use super::format::{Format, Opened};
use super::input::{InputFile, Reading};
use super::smooth::log_bias;
use brdfc_core::StrayRows;
use brdfc_core::source::{Completion, Repeats, Rounding, Saturation};
use brdfc_core::words::counted;
use brdfc_core::{Darkest, Smooth, Source, Symmetry, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::alta::{self, AltaTable};
use brdfc_readers::scan::{self, Row, Scan};
use brdfc_readers::scan_csv;
use coordinates::{Anisotropic, Identity, Isotropic, Space};
use detector::saturation_of_rows;
use incidence::Incidence;
use merge::{Group, merge};
use std::sync::OnceLock;
use strength::{LEAST_NOISE, Rows, Smoothed, Strength, Tree};

/// Minimum number of distinct direction pairs of a scan.
pub const MIN_ROWS: usize = 8;
/// Scans as text.
pub(crate) const fn text_format<F: From<ScanFacts>>() -> Format<F> {
    Format { name: "scan", kind: &scan::KIND, open: open_text }
}

/// Scans as CSV.
pub(crate) const fn csv_format<F: From<ScanFacts>>() -> Format<F> {
    Format { name: "scan", kind: &scan_csv::KIND, open: open_csv }
}

/// Tables of ALTA.
pub(crate) const fn alta_format<F: From<ScanFacts>>() -> Format<F> {
    Format { name: "ALTA", kind: &alta::KIND, open: open_alta }
}

fn open_text<F: From<ScanFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let reading = input.reading;
    input.parse_text(|bytes| opened(&Scan::from_bytes(bytes)?, None, reading))
}

fn open_csv<F: From<ScanFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let reading = input.reading;
    input.parse_text(|bytes| opened(&scan_csv::from_bytes(bytes)?, None, reading))
}

fn open_alta<F: From<ScanFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let reading = input.reading;
    input.parse_text(|bytes| {
        let table = AltaTable::from_bytes(bytes)?;
        opened(&table.scan, Some(&table), reading)
    })
}

/// The requested strength.
///
/// # Errors
/// Returns an error for a radius in cells, which scans do not have.
fn strength(reading: Reading) -> Result<Strength, FormatError> {
    let least_noise = match reading.smooth {
        None => LEAST_NOISE,
        Some(Smooth::Chosen(true)) => 0.0,
        Some(Smooth::Chosen(false)) => f64::INFINITY,
        Some(Smooth::Radius(radius)) => {
            let allowed = "true or false for a scan, which has a number of neighbours instead of a radius";
            return Err(FormatError::whole("smooth", radius.to_string(), allowed));
        }
    };
    Ok(reading.neighbours.map_or(Strength::Chosen { least_noise }, Strength::Neighbours))
}

fn opened<F: From<ScanFacts>>(
    scan: &Scan,
    alta: Option<&AltaTable>,
    reading: Reading,
) -> Result<Opened<F>, FormatError> {
    let source = ScanSource::read(scan, reading)?;
    let left_out = alta.map(|table| table.left_out).filter(|count| *count > 0);
    let summary = ScanSummary { left_out, ..source.summary() };
    let alta = alta.map(|table| AltaHeader {
        directions: table.directions.to_owned(),
        values: table.values.to_owned(),
        channels: table.channels,
    });
    let facts = ScanFacts { wavelengths: scan.wavelengths.clone(), alta, summary };
    Ok(Opened { source: Box::new(source), facts: facts.into() })
}

/// A scan that can be evaluated anywhere.
pub struct ScanSource {
    points: Points,
    /// The distinct direction pairs, as measured.
    pairs: Vec<DirectionPair>,
    /// `ln(f + bias)` of each pair, as measured.
    measured: Vec<[f64; 3]>,
    /// Number of neighbours of each pair and its fitted log values, for a noisy scan.
    smoothed: Option<(Vec<usize>, Vec<[f64; 3]>)>,
    /// Number of neighbours of fits at queried pairs.
    neighbours: usize,
    bias: f64,
    grey: bool,
    repeats: Option<Repeats>,
    saturation: Option<Saturation>,
    rounding: Option<Rounding>,
    /// Index of the incidence of each pair, and the number of incidences; computed by the first cross-validation.
    incidences: OnceLock<(Vec<usize>, usize)>,
    summary: ScanSummary,
}

/// Search space of the scan.
enum Points {
    Isotropic(Tree<4>),
    Anisotropic(Tree<5>),
}

impl std::fmt::Debug for ScanSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ScanSource").field("summary", &self.summary).finish_non_exhaustive()
    }
}

impl ScanSource {
    /// Completes a scan, with a strength that left-out rows choose.
    ///
    /// # Errors
    /// Returns an error for fewer than [`MIN_ROWS`] distinct direction pairs.
    pub fn new(scan: &Scan) -> Result<Self, FormatError> {
        Self::read(scan, Reading::default())
    }

    /// Builds the search tree. Without a number of neighbours, left-out rows choose it. Rows whose azimuth
    /// of incidence differs from the common one are taken as isotropic, and compared with the others.
    ///
    /// # Errors
    /// Returns an error for fewer than [`MIN_ROWS`] distinct direction pairs, and for fewer pairs than neighbours,
    /// and for a radius.
    pub fn read(scan: &Scan, reading: Reading) -> Result<Self, FormatError> {
        let source = Self::completed(scan, &strength(reading)?)?;
        let (pairs, raised): (Vec<_>, Vec<_>) = scan.rows.iter().map(|row| (pair_of(row), raised(row))).unzip();
        let (saturation, rounding) =
            (saturation_of_rows(&raised, &pairs), rounding(raised.len(), |row| raised[row], scan.step));
        Ok(Self { saturation, rounding, ..source })
    }

    fn completed(scan: &Scan, strength: &Strength) -> Result<Self, FormatError> {
        let strays = match Incidence::of(&scan.rows) {
            Incidence::Several => return Self::of_rows(&scan.rows, false, strength),
            Incidence::One(strays) => strays,
        };
        let Some(first) = strays.first().copied() else { return Self::of_rows(&scan.rows, true, strength) };
        let mut next = strays.iter().copied().peekable();
        let others: Vec<Row> =
            (0..scan.rows.len()).filter(|row| next.next_if_eq(row).is_none()).map(|row| scan.rows[row]).collect();
        let Ok(others) = Self::of_rows(&others, true, &Strength::Chosen { least_noise: LEAST_NOISE }) else {
            // Too few rows for a comparison.
            return Self::of_rows(&scan.rows, false, strength);
        };
        let strays = StrayRows {
            rows: strays.len(),
            of: scan.rows.len(),
            line: scan.lines.get(first).copied(),
            azimuth: scan.rows[first].phi_i.to_degrees(),
            difference: mean_difference(strays.iter().map(|row| &scan.rows[*row]), &others),
        };
        drop(others);
        let mut source = Self::of_rows(&scan.rows, true, strength)?;
        source.summary.strays = Some(strays);
        Ok(source)
    }

    fn of_rows(rows: &[Row], isotropic: bool, strength: &Strength) -> Result<Self, FormatError> {
        let pairs: Vec<DirectionPair> = rows.iter().map(pair_of).collect();
        let raised: Vec<[f64; 3]> = rows.iter().map(raised).collect();
        let negative = rows.iter().filter(|r| r.value.iter().any(|v| *v < 0.0)).count();
        let source = Self::of_pairs(&pairs, &raised, isotropic, strength)?;
        if let Strength::Neighbours(count) = strength
            && !(1..=source.pairs.len()).contains(count)
        {
            let allowed = format!("1 to {}, the number of distinct direction pairs", source.pairs.len());
            return Err(FormatError::whole("neighbours", count.to_string(), allowed));
        }
        Ok(Self { summary: ScanSummary { negative, ..source.summary }, ..source })
    }

    /// Creates a source from direction pairs with values of 0 or more.
    fn of_pairs(
        pairs: &[DirectionPair],
        raised: &[[f64; 3]],
        isotropic: bool,
        strength: &Strength,
    ) -> Result<Self, FormatError> {
        let (points, groups) = if isotropic {
            let (entries, groups) = entries::<3, 4, Isotropic>(pairs, raised);
            (Points::Isotropic(Tree::new(entries)), groups)
        } else {
            let (entries, groups) = entries::<4, 5, Anisotropic>(pairs, raised);
            (Points::Anisotropic(Tree::new(entries)), groups)
        };
        if groups.len() < MIN_ROWS {
            return Err(FormatError::whole(
                "rows",
                format!("{} in {}", counted(groups.len(), "distinct direction pair"), counted(pairs.len(), "row")),
                format!("at least {MIN_ROWS} distinct direction pairs"),
            ));
        }
        let bias = log_bias(raised);
        let repeats = repeats_of(&groups);
        let summary = ScanSummary {
            rows: pairs.len(),
            distinct: groups.len(),
            largest_disagreement: repeats.map_or(0.0, |repeats| repeats.largest),
            negative: 0,
            darkest: Darkest::of(raised.iter().copied()),
            isotropic,
            strays: None,
            left_out: None,
            noise: 0.0,
            neighbours: [0; 2],
        };
        let grey = raised.iter().all(|[r, g, b]| {
            let tolerance = 1e-12 * r.max(*g).max(*b);
            (r - g).abs() <= tolerance && (g - b).abs() <= tolerance
        });
        let measured: Vec<[f64; 3]> = groups.iter().map(|group| group.mean().map(|v| (v + bias).ln())).collect();
        let pairs: Vec<DirectionPair> = groups.iter().map(|group| pairs[group.representative]).collect();
        let neighbours = if isotropic { fit::NEIGHBOURS_3D } else { fit::NEIGHBOURS_4D };
        let incidences = OnceLock::new();
        let mut source = Self {
            points,
            pairs,
            measured,
            smoothed: None,
            neighbours,
            bias,
            grey,
            repeats,
            saturation: None,
            rounding: None,
            incidences,
            summary,
        };
        source.smooth(strength);
        Ok(source)
    }

    /// Smooths the rows by the requested strength.
    fn smooth(&mut self, strength: &Strength) {
        let default = self.neighbours;
        if let Strength::Neighbours(count) = strength {
            self.neighbours = default.min(*count).max(1);
        }
        let spread = self.repeats.map_or(0.0, |repeats| repeats.spread);
        let Smoothed { rows: smoothed, noise } = match &self.points {
            Points::Isotropic(tree) => {
                self.rows(tree).smoothed::<3, { fit::TERMS_3D }, Isotropic>(default, strength, spread)
            }
            Points::Anisotropic(tree) => {
                self.rows(tree).smoothed::<4, { fit::TERMS_4D }, Anisotropic>(default, strength, spread)
            }
        };
        self.summary.noise = noise;
        let sizes = smoothed.iter().flat_map(|(sizes, _)| sizes.iter().copied());
        self.summary.neighbours = match (sizes.clone().min(), sizes.max()) {
            (Some(least), Some(most)) => [least, most],
            _ => [self.neighbours; 2],
        };
        self.smoothed = smoothed;
    }

    /// Counts and repairs of the scan.
    pub fn summary(&self) -> ScanSummary {
        self.summary
    }

    fn rows<'a, const S: usize>(&'a self, tree: &'a Tree<S>) -> Rows<'a, S> {
        let values = self.smoothed.as_ref().map_or(&self.measured, |(_, values)| values);
        Rows { tree, pairs: &self.pairs, values, bias: self.bias, channels: if self.grey { 1 } else { 3 } }
    }

    fn fit<const D: usize, const S: usize, const M: usize, P: Space<D, S>>(
        &self,
        tree: &Tree<S>,
        pair: DirectionPair,
        tally: &mut Tally,
    ) -> [f64; 3] {
        let rows = self.rows(tree);
        let (neighbourhood, _) = rows.around::<D, M, P>(pair, self.neighbours);
        let channels = rows.channels;
        let fitted = neighbourhood.fit(channels, tally);
        let mut value = [0.0; 3];
        for channel in 0..channels {
            let least = 0.5 * (neighbourhood.range(channel).0.exp() - self.bias);
            value[channel] = (fitted[channel].exp() - self.bias).max(least).max(0.0);
        }
        if self.grey { [value[0]; 3] } else { value }
    }
}

impl Source for ScanSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        match &self.points {
            Points::Isotropic(tree) => self.fit::<3, 4, { fit::TERMS_3D }, Isotropic>(tree, pair, tally),
            Points::Anisotropic(tree) => self.fit::<4, 5, { fit::TERMS_4D }, Anisotropic>(tree, pair, tally),
        }
    }

    /// The fit is not reciprocal: exchanged rows have less weight than direct ones.
    fn symmetry(&self) -> Symmetry {
        let isotropic = self.summary.isotropic;
        Symmetry { isotropic, mirror: isotropic, reciprocal: false }
    }

    fn is_grey(&self) -> bool {
        self.grey
    }

    fn completion(&self) -> Option<&dyn Completion> {
        Some(self)
    }
}

/// Search positions with the index of their group.
type Entries<const S: usize> = (Vec<[f64; S]>, Vec<u32>);

fn entries<const D: usize, const S: usize, P: Space<D, S>>(
    pairs: &[DirectionPair],
    values: &[[f64; 3]],
) -> (Entries<S>, Vec<Group>) {
    let places: Vec<[f64; D]> = pairs.iter().map(|pair| P::place(*pair)).collect();
    let identities: Vec<Identity> = pairs.iter().map(|pair| P::identity(*pair)).collect();
    let groups = merge(&identities, &places, values);
    let entries = groups
        .iter()
        .zip(0u32..)
        .flat_map(|(group, number)| P::images(pairs[group.representative]).into_iter().map(move |at| (at, number)))
        .unzip();
    (entries, groups)
}

/// The value of a row, without negative channels.
fn raised(row: &Row) -> [f64; 3] {
    row.value.map(|value| value.max(0.0))
}

fn pair_of(row: &Row) -> DirectionPair {
    DirectionPair::from_angles(row.theta_i, row.phi_i, row.theta_o, row.phi_o)
}

/// Repeated direction pairs.
fn repeats_of(groups: &[Group]) -> Option<Repeats> {
    let repeated = || groups.iter().filter(|group| group.repeats());
    let pairs = repeated().count();
    let sum = |of: fn(&Group) -> f64| repeated().map(of).sum::<f64>();
    let (highest, spread) = (sum(Group::highest), sum(Group::spread));
    (pairs > 0).then(|| Repeats {
        pairs,
        share: pairs as f64 / groups.len() as f64,
        spread: if highest > 0.0 { spread / highest } else { 0.0 },
        largest: repeated().map(Group::disagreement).fold(0.0, f64::max),
    })
}

/// Mean difference of rows from a source, as a fraction of the larger value.
fn mean_difference<'a>(rows: impl ExactSizeIterator<Item = &'a Row>, source: &ScanSource) -> f64 {
    let count = rows.len() as f64;
    let difference = |row: &Row| {
        let (raised, fitted) = (row.value.map(|v| v.max(0.0)), source.eval(pair_of(row), &mut Tally::default()));
        let sum = |of: fn(f64, f64) -> f64| (0..3).map(|c| of(raised[c], fitted[c])).sum::<f64>();
        let larger = sum(f64::max);
        if larger > 0.0 { sum(|a, b| (a - b).abs()) / larger } else { 0.0 }
    };
    rows.map(difference).sum::<f64>() / count
}
