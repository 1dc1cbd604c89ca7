//! Scattered scans as a source: nearest neighbours completed and smoothed by moving least squares, at the asked
//! direction pair itself.

mod coordinates;
mod fit;

use super::{Source, Symmetry, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::measured::scan::Scan;
use fit::Neighbourhood;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

/// Fewest distinct direction pairs of a scan.
pub const FEWEST_ROWS: usize = 8;
/// Positions closer than this, per coordinate, are one direction pair measured twice.
const SAME_POSITION: f64 = 1e-6;
/// Bias of the logarithm `ln(f + bias)`, in units of the scan's median: below it lies dark noise.
const LOG_BIAS: f64 = 0.05;
/// Azimuths of incidence closer than this are one azimuth, radians.
const SAME_AZIMUTH: f64 = 1e-4;

/// What was found while a scan was taken in.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ScanSummary {
    /// Rows of the file.
    pub rows: usize,
    /// Direction pairs after equal ones, symmetric images included, were averaged.
    pub distinct: usize,
    /// Largest difference between rows of one direction pair, as a fraction of the larger value.
    pub largest_disagreement: f64,
    /// Rows with a negative channel (noise, or a colour outside the gamut), raised to 0.
    pub negative: usize,
    /// Rows that are 0 in all channels.
    pub zero: usize,
    /// Whether all rows have one azimuth of incidence, so that the material is taken as isotropic.
    pub isotropic: bool,
}

/// A scan that can be evaluated anywhere.
pub struct ScanSource {
    points: Points,
    /// `ln(f + bias)` of each point.
    values: Vec<[f64; 3]>,
    bias: f64,
    grey: bool,
    summary: ScanSummary,
}

/// Positions in a tree, images included; items are point numbers.
enum Points {
    Isotropic(Tree<3>),
    Anisotropic(Tree<4>),
}

struct Tree<const D: usize> {
    tree: ImmutableKdTree<f64, D>,
    positions: Vec<[f64; D]>,
    /// Which value each position, image or not, has.
    value_of: Vec<u32>,
}

impl std::fmt::Debug for ScanSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ScanSource").field("summary", &self.summary).finish_non_exhaustive()
    }
}

impl ScanSource {
    /// Builds the search tree.
    ///
    /// # Errors
    /// Fewer than [`FEWEST_ROWS`] distinct direction pairs.
    pub fn new(scan: &Scan) -> Result<Self, FormatError> {
        let pairs: Vec<DirectionPair> =
            scan.rows.iter().map(|r| DirectionPair::from_angles(r.theta_i, r.phi_i, r.theta_o, r.phi_o)).collect();
        let first = scan.rows[0].phi_i;
        // At normal incidence there is no azimuth.
        let isotropic = scan.rows.iter().all(|r| r.theta_i < SAME_AZIMUTH || same_azimuth(r.phi_i, first));
        let raised: Vec<[f64; 3]> = scan.rows.iter().map(|r| r.value.map(|v| v.max(0.0))).collect();
        let bias = log_bias(&raised);
        let log = |value: [f64; 3]| value.map(|v| (v + bias).ln());

        let (points, values, largest_disagreement) = if isotropic {
            let positions: Vec<_> = pairs.iter().map(|pair| coordinates::isotropic(*pair)).collect();
            let merged = merge(&positions.iter().map(|p| p.point).collect::<Vec<_>>(), &raised);
            let entries = merged.groups.iter().enumerate().flat_map(|(number, group)| {
                let position = &positions[group.representative];
                std::iter::once(position.point)
                    .chain(coordinates::isotropic_images(position))
                    .map(move |point| (point, number as u32))
            });
            (Points::Isotropic(Tree::new(entries)), merged.values(log), merged.largest_disagreement())
        } else {
            let positions: Vec<_> = pairs.iter().map(|pair| coordinates::anisotropic(*pair)).collect();
            let merged = merge(&positions.iter().map(|p| p.point).collect::<Vec<_>>(), &raised);
            let entries = merged.groups.iter().enumerate().flat_map(|(number, group)| {
                let position = &positions[group.representative];
                std::iter::once(position.point)
                    .chain(coordinates::anisotropic_images(position))
                    .map(move |point| (point, number as u32))
            });
            (Points::Anisotropic(Tree::new(entries)), merged.values(log), merged.largest_disagreement())
        };
        if values.len() < FEWEST_ROWS {
            return Err(FormatError::whole(
                "rows",
                format!("{} distinct direction pairs in {} rows", values.len(), scan.rows.len()),
                format!("at least {FEWEST_ROWS} distinct direction pairs, so that a surface can be fitted"),
            ));
        }
        let summary = ScanSummary {
            rows: scan.rows.len(),
            distinct: values.len(),
            largest_disagreement,
            negative: scan.rows.iter().filter(|r| r.value.iter().any(|v| *v < 0.0)).count(),
            zero: raised.iter().filter(|v| **v == [0.0; 3]).count(),
            isotropic,
        };
        let grey = raised.iter().all(|[r, g, b]| {
            let tolerance = 1e-12 * r.max(*g).max(*b);
            (r - g).abs() <= tolerance && (g - b).abs() <= tolerance
        });
        Ok(Self { points, values, bias, grey, summary })
    }

    /// What was found while the scan was taken in.
    pub fn summary(&self) -> ScanSummary {
        self.summary
    }

    fn fit<const D: usize>(&self, tree: &Tree<D>, point: [f64; D], neighbours: usize, tally: &mut Tally) -> [f64; 3] {
        let count = NonZero::new(neighbours + 1).expect("at least one");
        let found = tree.tree.query(&point).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        // The support reaches just past the first neighbour left out, so that neighbours come and go at weight 0.
        let radius = (1.001 * found.last().map_or(0.0, |f| f.distance.sqrt())).max(1e-6);
        let mut neighbourhood = Neighbourhood::<D>::default();
        for item in found.iter().take(neighbours) {
            let at = tree.positions[item.item as usize];
            let mut offset = [0.0; D];
            for axis in 0..D {
                offset[axis] = (at[axis] - point[axis]) / radius;
            }
            neighbourhood.push(offset, self.values[tree.value_of[item.item as usize] as usize]);
        }
        let channels = if self.grey { 1 } else { 3 };
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
            Points::Isotropic(tree) => self.fit(tree, coordinates::isotropic(pair).point, fit::NEIGHBOURS_3D, tally),
            Points::Anisotropic(tree) => {
                self.fit(tree, coordinates::anisotropic(pair).point, fit::NEIGHBOURS_4D, tally)
            }
        }
    }

    fn symmetry(&self) -> Symmetry {
        let isotropic = self.summary.isotropic;
        Symmetry { isotropic, mirror: isotropic, reciprocal: true }
    }

    fn is_grey(&self) -> bool {
        self.grey
    }
}

impl<const D: usize> Tree<D> {
    fn new(entries: impl Iterator<Item = ([f64; D], u32)>) -> Self
    where
        ImmutableKdTree<f64, D>: Sized,
    {
        let (positions, value_of): (Vec<_>, Vec<_>) = entries.unzip();
        let tree = ImmutableKdTree::new_from_slice(&positions).expect("positions are finite");
        Self { tree, positions, value_of }
    }
}

fn same_azimuth(a: f64, b: f64) -> bool {
    let turns = (a - b) / std::f64::consts::TAU;
    (turns - turns.round()).abs() * std::f64::consts::TAU < SAME_AZIMUTH
}

/// A fraction of the median of all positive values; 1 for a black scan.
fn log_bias(values: &[[f64; 3]]) -> f64 {
    let mut positive: Vec<f64> = values.iter().flatten().copied().filter(|v| *v > 0.0).collect();
    if positive.is_empty() {
        return 1.0;
    }
    let middle = positive.len() / 2;
    let (_, median, _) = positive.select_nth_unstable_by(middle, f64::total_cmp);
    LOG_BIAS * *median
}

/// Rows of one direction pair.
struct Group {
    representative: usize,
    sum: [f64; 3],
    lowest: [f64; 3],
    highest: [f64; 3],
    count: f64,
}

struct Merged {
    groups: Vec<Group>,
}

impl Merged {
    fn values(&self, log: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
        self.groups.iter().map(|g| log(g.sum.map(|s| s / g.count))).collect()
    }

    fn largest_disagreement(&self) -> f64 {
        self.groups
            .iter()
            .flat_map(|g| (0..3).map(|c| if g.highest[c] > 0.0 { 1.0 - g.lowest[c] / g.highest[c] } else { 0.0 }))
            .fold(0.0, f64::max)
    }
}

/// Groups rows whose positions are equal to within [`SAME_POSITION`].
fn merge<const D: usize>(positions: &[[f64; D]], values: &[[f64; 3]]) -> Merged {
    let key = |row: usize| positions[row].map(|c| (c / SAME_POSITION).round() as i64);
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by_key(|row| (key(*row), *row));
    let mut groups: Vec<Group> = Vec::new();
    for row in order {
        let value = values[row];
        match groups.last_mut() {
            Some(group) if key(group.representative) == key(row) => {
                group.count += 1.0;
                for channel in 0..3 {
                    group.sum[channel] += value[channel];
                    group.lowest[channel] = group.lowest[channel].min(value[channel]);
                    group.highest[channel] = group.highest[channel].max(value[channel]);
                }
            }
            _ => groups.push(Group { representative: row, sum: value, lowest: value, highest: value, count: 1.0 }),
        }
    }
    Merged { groups }
}
