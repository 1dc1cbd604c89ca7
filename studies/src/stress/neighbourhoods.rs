//! Moving least squares with neighbours that barely determine a polynomial, compared with an orthogonal decomposition.

use super::fed::{Numbers, directions};
use super::row::{Measure, StressRow, Worst};
use super::stages::{Neighbourhood, Stages};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::scan::{Row, Scan};
use brdfc_source::ScanSource;
use brdfc_source::scan::fit::{NEIGHBOURS_3D, RIDGE, TERMS_3D};
use nalgebra::{DMatrix, DVector};

/// Arrangement of neighbours.
#[derive(Debug, Clone, Copy)]
enum Lie {
    Spread,
    /// On a line, away from the queried point.
    Line,
    /// On a plane.
    Plane,
    /// All at one point except for 1e-9.
    Cluster,
    /// All at one point.
    Same,
    /// Each twice.
    Twice,
}

const LIES: [Lie; 6] = [Lie::Spread, Lie::Line, Lie::Plane, Lie::Cluster, Lie::Same, Lie::Twice];

fn offsets(lie: Lie, count: usize, numbers: &mut Numbers) -> Vec<[f64; 3]> {
    let aside = [numbers.between(-0.5, 0.5), numbers.between(-0.5, 0.5), numbers.between(-0.5, 0.5)];
    let mut points: Vec<[f64; 3]> = Vec::new();
    for k in 0..count {
        let random: [f64; 3] = std::array::from_fn(|_| numbers.between(-0.57, 0.57));
        points.push(match lie {
            Lie::Spread => random,
            Lie::Line => std::array::from_fn(|axis| aside[axis] * (0.2 + 0.8 * random[0].abs())),
            Lie::Plane => [random[0], random[1], aside[2]],
            Lie::Cluster => std::array::from_fn(|axis| aside[axis] + 1e-9 * random[axis]),
            Lie::Same => aside,
            Lie::Twice if k % 2 == 1 => points[k - 1],
            Lie::Twice => random,
        });
    }
    points
}

fn length(p: [f64; 3]) -> f64 {
    p.iter().map(|c| c * c).sum::<f64>().sqrt()
}

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let rounds = if small { 20 } else { 2_000 };
    let [mut solved, mut variance, mut constants, mut reach] = [Worst::default(); 4];
    for lie in LIES {
        let mut numbers = Numbers::new(13);
        for round in 0..rounds {
            let count = [1, 2, 4, 9, NEIGHBOURS_3D][round % 5];
            let points = offsets(lie, count, &mut numbers);
            let weights: Vec<f64> = points.iter().map(|_| (0.01 + numbers.unit()) / count as f64).collect();
            // Logarithms of 1e-12 to 1e6.
            let residuals: Vec<[f64; 3]> = points.iter().map(|_| [numbers.wide().ln(); 3]).collect();
            against_orthogonal(stages, &points, &weights, &residuals, &mut solved, &mut variance);

            let fitted = |value: &dyn Fn(usize) -> f64| {
                let mut neighbourhood = Neighbourhood::with_capacity(points.len());
                for (k, point) in points.iter().enumerate() {
                    neighbourhood.push(*point, length(*point), [value(k); 3]);
                }
                let range = neighbourhood.range(0);
                ((stages.neighbourhood)(&mut neighbourhood), range)
            };
            constants.add(fitted(&|_| -27.6).0 / -27.6 - 1.0);
            let (value, (low, high)) = fitted(&|k| residuals[k][0]);
            let margin = 0.1 * (high - low) + 1e-12 * high.abs().max(low.abs());
            reach.check((low - margin..=high + margin).contains(&value));
        }
    }
    let fed = "1 to 14 neighbours: spread, on a line, on a plane, 1e-9 apart, at one place, each twice";
    vec![
        solved.row(
            ["moving least squares, f64", fed],
            Measure::Relative,
            CONDITION,
            "elimination against Householder QR: the ridge keeps the condition of 10 terms below 1e10; relative to the largest coefficient",
        ),
        variance.row(
            ["trust in a fit, f64", fed],
            Measure::Relative,
            CONDITION,
            "the variance factor is computed from the same matrix",
        ),
        constants.row(
            ["moving least squares, f64", "the same, equal values"],
            Measure::Relative,
            16.0 * f64::EPSILON,
            "the polynomial is fitted to residuals from the mean, which are 0",
        ),
        reach.row(
            ["moving least squares, f64", "the same, 1e-12 to 1e6"],
            Measure::Count,
            0.0,
            "extrapolation is limited to a tenth of their range below the neighbours, and not above them",
        ),
        scans(stages, small),
    ]
}

/// Machine precision times the maximum condition of the normal matrix.
const CONDITION: f64 = 1e10 * f64::EPSILON;

/// `(BᵀWB + ridge) a = BᵀW e` as least squares over the rows `√w B` and `√ridge`, by QR.
fn against_orthogonal(
    stages: &Stages,
    points: &[[f64; 3]],
    weights: &[f64],
    residuals: &[[f64; 3]],
    solved: &mut Worst,
    variance: &mut Worst,
) {
    let basis: Vec<[f64; TERMS_3D]> =
        points.iter().map(|[x, y, z]| [1.0, *x, *y, *z, x * x, x * y, x * z, y * y, y * z, z * z]).collect();
    let found = (stages.local_fit)(&basis, weights, residuals);
    for (at, terms) in [4, TERMS_3D].into_iter().enumerate() {
        let rows = points.len() + terms;
        let matrix = DMatrix::from_fn(rows, terms, |row, term| match row.checked_sub(points.len()) {
            None => weights[row].sqrt() * basis[row][term],
            Some(of) if of == term => RIDGE[usize::from(term > 0) + usize::from(term > 3)].sqrt(),
            Some(_) => 0.0,
        });
        let right =
            DVector::from_fn(
                rows,
                |row, _| if row < points.len() { weights[row].sqrt() * residuals[row][0] } else { 0.0 },
            );
        let qr = matrix.qr();
        let r = qr.r();
        let Some(exact) = r.solve_upper_triangular(&(qr.q().transpose() * right)) else { continue };
        solved.add((found[at] - exact[0]) / exact.amax().max(1.0));
        // The corner of the inverse is the squared length of `R⁻ᵀ e₀`.
        let unit = DVector::from_fn(terms, |row, _| if row == 0 { 1.0 } else { 0.0 });
        let Some(corner) = r.transpose().solve_lower_triangular(&unit).map(|v| v.norm_squared()) else { continue };
        variance.add(found[2 + at] / corner - 1.0);
    }
}

/// Scans of one value: rings, lines and duplicated rows.
fn scans(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    let ring: Vec<[f64; 3]> = (0..12).map(|k| [1.57, 1.57, 0.5 * f64::from(k)]).collect();
    let line: Vec<[f64; 3]> = (0..12).map(|k| [0.3, 0.12 * f64::from(k), 0.0]).collect();
    let twice: Vec<[f64; 3]> = line.iter().chain(&line).copied().collect();
    for rows in [ring, line, twice] {
        for value in [0.0, 1e-12, 0.3, 1e6] {
            let row = |[theta_i, theta_o, phi_o]: &[f64; 3]| Row {
                theta_i: *theta_i,
                phi_i: 0.0,
                theta_o: *theta_o,
                phi_o: *phi_o,
                value: [value; 3],
            };
            let lines = (1..=rows.len() as u64).collect();
            let scan = Scan { rows: rows.iter().map(row).collect(), lines, ..Scan::default() };
            let Ok(source) = ScanSource::new(&scan) else {
                worst.add(f64::NAN);
                continue;
            };
            let all = directions(small);
            for (k, incoming) in all.iter().enumerate() {
                let pair = DirectionPair::new(*incoming, all[(7 * k + 3) % all.len()]);
                if pair.is_above_horizon() {
                    let found = (stages.scan)(&source, pair)[0];
                    worst.add(if value == 0.0 { found } else { found / value - 1.0 });
                }
            }
        }
    }
    worst.row(
        [
            "completion of scans, f64",
            "a ring at the horizon, a line, duplicated rows, of one value, 0 and 1e-12 to 1e6",
        ],
        Measure::Relative,
        64.0 * f64::EPSILON,
        "the rounding of a logarithm of up to 28, amplified by its exponential, twice",
    )
}
