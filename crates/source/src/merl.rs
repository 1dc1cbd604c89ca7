//! MERL tables as sources.

use super::error::InputError;
use super::format::{Format, Opened};
use super::input::InputFile;
use super::read::{MAX_FILE_BYTES, check_length};
use super::scan::{isotropic_distance, rise_to_peaks, rounding, saturation};
use super::smooth::{Axis, Grid, Smoothed, smooth};
use brdfc_core::half_difference::HalfDifference;
use brdfc_core::pair_list::PairBlock;
use brdfc_core::source::{MAX_ROUNDING, Rise, Rounding, Samples, Saturation};
use brdfc_core::{Darkest, Describe};
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::merl::{self, Merl, MerlError};
use std::sync::OnceLock;

/// Largest relative difference between a cell and its image that counts as rounding in a symmetric file.
const SYMMETRY_TOLERANCE: f32 = 1e-5;

/// Maximum share of the cells above the horizon without a measurement in a table whose gaps are not looked for.
const MAX_MISSING: f64 = 1e-3;
/// Step of an angle above which directions may be far from all cells, radians.
const COARSE: f64 = 0.25;
/// Maximum number of azimuths that are compared for the rise to the mirror direction.
const AZIMUTHS: usize = 16;

/// Facts about a MERL table.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct MerlFacts {
    /// Samples along theta_h, theta_d and phi_d.
    pub dimensions: [usize; 3],
    /// Cells with a measurement.
    pub valid_cells: usize,
    /// Cells without a measurement.
    pub invalid_cells: usize,
    /// The darkest cells; absent if all have the same value above 0.
    pub darkest: Option<Darkest>,
    /// Smoothing, if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothed: Option<Smoothed>,
}

impl Describe for MerlFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self { dimensions: [h, d, p], valid_cells, invalid_cells, smoothed, .. } = self;
        let mut lines = vec![
            ("kind", "MERL table".to_owned()),
            ("samples (theta_h x theta_d x phi_d)", format!("{h} x {d} x {p}")),
            ("azimuths cover", if *p == 4 * d { "a full turn" } else { "half a turn" }.to_owned()),
            ("valid cells", format!("{valid_cells} of {}", valid_cells + invalid_cells)),
        ];
        lines.extend(smoothed.iter().flat_map(Smoothed::lines));
        lines
    }

    fn samples(&self) -> u64 {
        self.valid_cells as u64
    }

    fn darkest(&self) -> Option<Darkest> {
        self.darkest
    }
}

/// MERL tables as inputs.
pub(crate) const fn format<F: From<MerlFacts>>() -> Format<F> {
    Format { name: "MERL", kind: &merl::KIND, open }
}

fn open<F: From<MerlFacts>>(mut input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let smoothing = input.reading.smoothing().map_err(|error| InputError::format(input.path, error))?;
    check_length(input.length, MAX_FILE_BYTES).map_err(|error| InputError::format(input.path, error))?;
    let mut table = match Merl::read(&mut input.file, input.length) {
        Ok(table) => table,
        Err(MerlError::Format(error)) => return Err(input.wrong(error)),
        Err(MerlError::Io(error)) => return Err(InputError::io(input.path, error)),
    };
    let n = table.dimensions;
    // Along θ_h and θ_d the table ends; azimuths start again.
    let shape = [n.theta_half, n.theta_difference, n.phi_difference];
    let grid = Grid { shape, axes: [Axis::Open, Axis::Open, Axis::Periodic] };
    let marks = Marks::of(&table);
    let smoothed = smoothing.map(|radius| smooth(&mut table.values, grid, radius));
    // Smoothing hides them.
    let source = MerlSource { marks, ..MerlSource::new(table) };
    let valid_cells = source.table().valid_cells;
    let darkest = marks.darkest;
    let facts = MerlFacts { dimensions: shape, valid_cells, invalid_cells: n.cells() - valid_cells, darkest, smoothed };
    Ok(Opened { source: Box::new(source), facts: facts.into() })
}

/// Marks of a detector or of decimals in the values of a table.
#[derive(Debug, Clone, Copy)]
struct Marks {
    saturation: Option<Saturation>,
    rounding: Option<Rounding>,
    darkest: Option<Darkest>,
}

/// A MERL table, interpolated trilinearly in `(sqrt(theta_h), theta_d, phi_d)`.
#[derive(Debug)]
pub struct MerlSource {
    table: Merl,
    symmetry: Symmetry,
    marks: Marks,
    nearest: OnceLock<Vec<u32>>,
}

impl MerlSource {
    /// Measures the symmetries of the table.
    ///
    /// The layout makes it isotropic, and reciprocal if it stores half a turn. Mirror symmetry is a property of the
    /// data, and measured files need not have it.
    pub fn new(table: Merl) -> Self {
        let symmetry = Symmetry {
            isotropic: true,
            mirror: table.is_mirror_symmetric(SYMMETRY_TOLERANCE),
            reciprocal: table.is_reciprocal(SYMMETRY_TOLERANCE),
        };
        Self { marks: Marks::of(&table), table, symmetry, nearest: OnceLock::new() }
    }

    /// Table that was read; NaN in cells without a valid measurement.
    pub fn table(&self) -> &Merl {
        &self.table
    }
}

impl Source for MerlSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if pair.is_above_horizon() { self.at(HalfDifference::of(pair), tally) } else { [0.0; 3] }
    }

    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        tally.evaluations += values.len() as u64;
        for ((value, pair), place) in values.iter_mut().zip(block.pairs()).zip(block.half_difference()) {
            *value = if pair.is_above_horizon() { self.at(*place, tally) } else { [0.0; 3] };
        }
    }

    fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// Tables with gaps, coarse ones and saturated ones are as doubtful as scans are.
    fn samples(&self) -> Option<&dyn Samples> {
        let Merl { dimensions: n, valid_cells, missing_cells, .. } = &self.table;
        let has_gaps = *missing_cells as f64 > MAX_MISSING * (valid_cells + missing_cells) as f64;
        let [_, difference, azimuth] = n.sample_angles(0, 1, 1);
        // The last step is the largest one.
        let half = n.sample_angles(n.theta_half, 0, 0)[0] - n.sample_angles(n.theta_half - 1, 0, 0)[0];
        let is_coarse = half.max(difference).max(azimuth) > COARSE;
        (has_gaps || is_coarse || self.marks.are_doubtful()).then_some(self)
    }
}

impl Samples for MerlSource {
    fn distance(&self, pair: DirectionPair) -> f64 {
        let corners = self.corners_at(HalfDifference::of(pair)).map(|(cell, _)| cell);
        let distance = |cell: usize| {
            let sample = pair_of_cell(&self.table, cell);
            isotropic_distance(pair, sample).min(isotropic_distance(pair, sample.exchanged()))
        };
        let valid = corners.into_iter().filter(|cell| !self.table.values[*cell][0].is_nan());
        let nearest = valid.map(distance).reduce(f64::min);
        nearest.unwrap_or_else(|| distance(self.nearest_valid(corners[0])))
    }

    fn rise(&self) -> Option<Rise> {
        let n = self.table.dimensions;
        let step = n.phi_difference.div_ceil(AZIMUTHS);
        let cells = (0..n.cells()).filter(|cell| (cell % n.phi_difference).is_multiple_of(step));
        let valid = cells.filter(|cell| !self.table.values[*cell][0].is_nan());
        let luminance = |cell: usize| self.table.values[cell].iter().map(|v| f64::from(*v)).sum();
        rise_to_peaks(valid.map(|cell| (pair_of_cell(&self.table, cell), luminance(cell))))
    }

    fn saturation(&self) -> Option<Saturation> {
        self.marks.saturation
    }

    fn rounding(&self) -> Option<Rounding> {
        self.marks.rounding
    }
}

impl Marks {
    fn of(table: &Merl) -> Self {
        let count = table.values.len();
        let value = |cell: usize| table.values[cell].map(f64::from);
        Self {
            saturation: saturation(count, value, |cell| pair_of_cell(table, cell)),
            rounding: rounding(count, value, None),
            darkest: Darkest::of((0..count).map(value)),
        }
    }

    fn are_doubtful(&self) -> bool {
        self.saturation.is_some() || self.rounding.is_some_and(|rounding| rounding.error > MAX_ROUNDING)
    }
}

fn pair_of_cell(table: &Merl, cell: usize) -> DirectionPair {
    let n = table.dimensions;
    let (ring, k) = (cell / n.phi_difference, cell % n.phi_difference);
    n.pair(ring / n.theta_difference, ring % n.theta_difference, k)
}

impl MerlSource {
    /// The eight cells around a place, with their weights.
    #[inline]
    fn corners_at(&self, place: HalfDifference) -> [(usize, f64); 8] {
        let n = self.table.dimensions;
        let HalfDifference { half_root, difference_share, phi_difference } = place;
        let h = edge_position(half_root * n.theta_half as f64, n.theta_half);
        let d = edge_position(difference_share * n.theta_difference as f64, n.theta_difference);
        let turns = phi_difference / n.azimuth_period();
        let azimuth = (turns - turns.floor()) * n.phi_difference as f64;
        let k0 = (azimuth as usize).min(n.phi_difference - 1);
        let k = (k0, if k0 + 1 == n.phi_difference { 0 } else { k0 + 1 }, azimuth - k0 as f64);
        let mut corners = [(0, 0.0); 8];
        for (a, (i, wi)) in [(h.0, 1.0 - h.2), (h.1, h.2)].into_iter().enumerate() {
            for (b, (j, wj)) in [(d.0, 1.0 - d.2), (d.1, d.2)].into_iter().enumerate() {
                let ring = (i * n.theta_difference + j) * n.phi_difference;
                for (c, (k, wk)) in [(k.0, 1.0 - k.2), (k.1, k.2)].into_iter().enumerate() {
                    corners[4 * a + 2 * b + c] = (ring + k, wi * wj * wk);
                }
            }
        }
        corners
    }

    fn at(&self, place: HalfDifference, tally: &mut Tally) -> [f64; 3] {
        let corners = self.corners_at(place);
        let mut sum = [0.0; 3];
        for (cell, weight) in corners {
            let value = self.table.values[cell];
            (0..3).for_each(|channel| sum[channel] += weight * f64::from(value[channel]));
        }
        // A NaN makes the sum NaN.
        if sum[0].is_nan() { self.repaired(&corners, tally) } else { sum }
    }

    /// Mean of the valid cells, or else the nearest valid one. Cells without weight do not count as missing.
    #[cold]
    fn repaired(&self, corners: &[(usize, f64); 8], tally: &mut Tally) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let (mut valid, mut missed) = (0.0, false);
        for (cell, weight) in corners.iter().filter(|(_, weight)| *weight != 0.0) {
            let value = self.table.values[*cell];
            if value[0].is_nan() || weight.is_nan() {
                missed = true;
                continue;
            }
            valid += weight;
            (0..3).for_each(|channel| sum[channel] += weight * f64::from(value[channel]));
        }
        if !missed {
            return sum;
        }
        if valid > 0.0 {
            tally.partly_invalid += 1;
            return sum.map(|s| s / valid);
        }
        tally.nearest_valid += 1;
        self.table.values[self.nearest_valid(corners[0].0)].map(f64::from)
    }

    /// The valid cell nearest to a cell in steps along the axes; ties go to the cell reached first. For pairs above the
    /// horizon whose eight cells are all invalid. They are rare, so the map is built at first use.
    fn nearest_valid(&self, cell: usize) -> usize {
        self.nearest.get_or_init(|| nearest_valid_cells(&self.table))[cell] as usize
    }
}

/// For each cell, the closest valid cell, found by a breadth-first search from all valid cells.
fn nearest_valid_cells(table: &Merl) -> Vec<u32> {
    let n = table.dimensions;
    let mut nearest = vec![u32::MAX; n.cells()];
    let mut queue = std::collections::VecDeque::new();
    for (cell, value) in table.values.iter().enumerate() {
        if !value[0].is_nan() {
            nearest[cell] = cell as u32;
            queue.push_back(cell);
        }
    }
    while let Some(cell) = queue.pop_front() {
        let (ring, k) = (cell / n.phi_difference, cell % n.phi_difference);
        let (i, j) = (ring / n.theta_difference, ring % n.theta_difference);
        let ring_cells = n.theta_difference * n.phi_difference;
        let first = cell - k;
        let mut neighbours =
            vec![first + (k + 1) % n.phi_difference, first + (k + n.phi_difference - 1) % n.phi_difference];
        neighbours.extend((j > 0).then(|| cell - n.phi_difference));
        neighbours.extend((j + 1 < n.theta_difference).then(|| cell + n.phi_difference));
        neighbours.extend((i > 0).then(|| cell - ring_cells));
        neighbours.extend((i + 1 < n.theta_half).then(|| cell + ring_cells));
        for neighbour in neighbours {
            if nearest[neighbour] == u32::MAX {
                nearest[neighbour] = nearest[cell];
                queue.push_back(neighbour);
            }
        }
    }
    nearest
}

/// Lower and upper sample along an axis, and the fraction between them.
type Edge = (usize, usize, f64);

/// Position among samples at integer positions; clamped at the last.
fn edge_position(position: f64, count: usize) -> Edge {
    let lower = (position as usize).min(count - 1);
    if lower + 1 == count { (lower, lower, 0.0) } else { (lower, lower + 1, position - lower as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::half_difference::half_difference_angles;
    use brdfc_formats::direction::{from_polar, rotate_from_normal};
    use brdfc_readers::merl::{Dimensions, write};
    use std::f64::consts::FRAC_PI_2;

    /// A pair with these half and difference angles; the half vector is at the tangent's azimuth.
    fn pair_at([theta_h, theta_d, phi_d]: [f64; 3]) -> DirectionPair {
        let h = from_polar(theta_h, 0.0);
        let d = from_polar(theta_d, phi_d);
        let o = from_polar(theta_d, phi_d + std::f64::consts::PI);
        DirectionPair::new(rotate_from_normal(h, d), rotate_from_normal(h, o))
    }

    fn source(dimensions: Dimensions, value: impl Fn([f64; 3]) -> Option<[f64; 3]>) -> MerlSource {
        let mut bytes = Vec::new();
        write(&mut bytes, dimensions, value).unwrap();
        MerlSource::new(Merl::from_bytes(&bytes).unwrap())
    }

    #[test]
    fn angles_of_a_pair_built_from_angles() {
        for angles in [[0.3, 0.5, 1.0], [0.1, 0.2, -2.0], [0.6, 0.1, 3.0]] {
            let found = half_difference_angles(pair_at(angles));
            for (a, b) in found.into_iter().zip(angles) {
                assert!((a - b).abs() < 1e-12, "{found:?} {angles:?}");
            }
        }
    }

    /// The values are linear in the warped coordinates, so trilinear interpolation is exact if and only if samples are
    /// on the lower bin edges; with bin centres the value would be off by half a step.
    #[test]
    fn samples_are_on_edges_not_centres() {
        let n = Dimensions { theta_half: 10, theta_difference: 12, phi_difference: 24 };
        let warp = |theta_h: f64| (theta_h / FRAC_PI_2).sqrt();
        let s = source(n, |[h, d, _]| Some([1.0 + warp(h), 1.0 + d, 1.0]));
        let mut tally = Tally::default();
        for angles in [[0.2, 0.3, 0.4], [0.05, 0.6, 2.0], [0.5, 0.45, 3.0]] {
            let value = s.eval(pair_at(angles), &mut tally);
            assert!((value[0] - 1.0 - warp(angles[0])).abs() < 1e-6, "{value:?}");
            assert!((value[1] - 1.0 - angles[1]).abs() < 1e-6, "{value:?}");
            let half_a_step = 0.5 / 10.0;
            assert!((value[0] - (1.0 + warp(angles[0]) + half_a_step)).abs() > 0.01);
        }
        assert_eq!(tally, Tally { evaluations: 3, ..Tally::default() });
    }

    #[test]
    fn azimuth_wraps_after_half_a_turn() {
        let n = Dimensions { theta_half: 4, theta_difference: 8, phi_difference: 16 };
        let s = source(n, |[.., p]| Some([2.0 + (2.0 * p).cos(), 2.0 + (2.0 * p).sin(), 1.0]));
        let mut tally = Tally::default();
        let at = |phi: f64, tally: &mut Tally| s.eval(pair_at([0.3, 0.4, phi]), tally);
        let (a, b) = (at(0.3, &mut tally), at(0.3 - std::f64::consts::PI, &mut tally));
        assert!((a[1] - b[1]).abs() < 1e-9 && (a[0] - b[0]).abs() < 1e-9);
        let last = n.sample_angles(0, 0, 15)[2];
        let beyond = at(last + 0.05, &mut tally)[1];
        let expected_between = (2.0 + (2.0 * last).sin(), 2.0);
        assert!(beyond > expected_between.0 && beyond < expected_between.1);
        assert!(!s.symmetry().mirror && s.symmetry().reciprocal && s.symmetry().isotropic);
    }

    #[test]
    fn invalid_cells_are_left_out_and_counted() {
        let n = Dimensions { theta_half: 6, theta_difference: 6, phi_difference: 12 };
        let limit = n.sample_angles(0, 3, 0)[1];
        let s = source(n, |[_, d, _]| (d < limit - 1e-9).then_some([3.0; 3]));
        let mut tally = Tally::default();
        assert!((s.eval(pair_at([0.2, 0.1, 0.5]), &mut tally)[2] - 3.0).abs() < 1e-6);
        let repaired = s.eval(pair_at([0.2, limit - 0.1, 0.5]), &mut tally);
        assert!((repaired[0] - 3.0).abs() < 1e-6, "zeros or -1 must not leak in: {repaired:?}");
        let far = s.eval(pair_at([0.0, 1.3, 0.5]), &mut tally);
        assert!((far[0] - 3.0).abs() < 1e-6);
        assert_eq!((tally.partly_invalid, tally.nearest_valid), (1, 1));
    }
}
