//! Least squares of the weights of lobes, for each view and channel, with weights of 0 or more.

use super::candidate::Candidate;
use super::non_negative::minimise;
use super::views::{View, Views};
use brdfc_metrics::lab::XYZ;
use std::sync::Arc;

/// Weight of the squared diagonal that makes nearly equal lobes solvable.
const RIDGE: f64 = 1e-6;

/// Look-ups of a candidate for each view and frame, in units of visible error.
pub type Column = Vec<Vec<[f32; 3]>>;

/// The radiance of all views, in units of visible error.
pub struct Target {
    /// Factors of radiance for each view, frame and channel: the derivative of L*a*b*, by a channel.
    scales: Vec<Vec<[f32; 3]>>,
    values: Column,
    /// Sums of squares for each view and channel.
    squares: Vec<[f64; 3]>,
}

/// Visible change per change of a channel of an exposed colour: the length of the derivative of L*a*b*. A floor keeps it
/// finite for black.
fn visibility(colour: [f64; 3]) -> [f64; 3] {
    const FLOOR: f64 = 0.01;
    let slopes = XYZ.map(|row| {
        let sum: f64 = (0..3).map(|k| row[k] * colour[k]).sum();
        (sum + FLOOR).powf(-2.0 / 3.0) / 3.0
    });
    [0, 1, 2].map(|k| {
        let [x, y, z] = [0, 1, 2].map(|row| slopes[row] * XYZ[row][k]);
        let lab = [116.0 * y, 500.0 * (x - y), 200.0 * (y - z)];
        lab.iter().map(|c| c * c).sum::<f64>().sqrt()
    })
}

impl Target {
    /// Scales the radiance of views.
    pub fn new(views: &Views<'_>) -> Self {
        let scales_of = |view: &View| -> Vec<[f32; 3]> {
            let scale = |(number, value): (usize, &[f64; 3])| {
                let exposure = views.frame(number).2;
                visibility(value.map(|c| c * exposure)).map(|v| (v * exposure * view.area.sqrt()) as f32)
            };
            view.radiance.iter().enumerate().map(scale).collect()
        };
        let scales: Vec<Vec<[f32; 3]>> = views.views.iter().map(scales_of).collect();
        let scaled = |(view, scales): (&View, &Vec<[f32; 3]>)| -> Vec<[f32; 3]> {
            let product = |(value, scale): (&[f64; 3], &[f32; 3])| [0, 1, 2].map(|k| value[k] as f32 * scale[k]);
            view.radiance.iter().zip(scales).map(product).collect()
        };
        let values: Column = views.views.iter().zip(&scales).map(scaled).collect();
        let squares = values.iter().map(|values| product(values, values)).collect();
        Self { scales, values, squares }
    }

    /// Look-ups of a candidate, scaled as the target.
    pub fn column(&self, candidate: &Candidate, views: &Views<'_>) -> Column {
        let of_view = |(view, scales): (&View, &Vec<[f32; 3]>)| -> Vec<[f32; 3]> {
            let look = |(number, scale): (usize, &[f32; 3])| {
                let (environment, frame, _) = views.frame(number);
                let light = candidate.radiance(environment, frame, view.outgoing);
                [0, 1, 2].map(|k| light[k] * scale[k])
            };
            scales.iter().enumerate().map(look).collect()
        };
        views.views.iter().zip(&self.scales).map(of_view).collect()
    }
}

fn product(a: &[[f32; 3]], b: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (a, b) in a.iter().zip(b) {
        (0..3).for_each(|k| sum[k] += f64::from(a[k]) * f64::from(b[k]));
    }
    sum
}

/// Candidates with their weights.
#[derive(Clone, Default)]
pub struct System {
    /// Candidates, in the order of their selection.
    pub candidates: Vec<Candidate>,
    columns: Vec<Arc<Column>>,
    /// For each view: products of columns, products with the target, and weights.
    views: Vec<Normal>,
    /// Sum of squared visible errors.
    pub error: f64,
}

/// Normal equations of a view.
#[derive(Clone, Default)]
struct Normal {
    gram: Vec<Vec<[f64; 3]>>,
    right: Vec<[f64; 3]>,
    weights: Vec<[f64; 3]>,
}

impl System {
    /// A system without candidates.
    pub fn new(target: &Target) -> Self {
        let error = target.squares.iter().flatten().sum();
        Self { views: vec![Normal::default(); target.values.len()], error, ..Self::default() }
    }

    /// Number of look-ups.
    pub fn fetches(&self) -> usize {
        self.candidates.iter().map(Candidate::fetches).sum()
    }

    /// Weights of a candidate for each view.
    pub fn weights(&self, candidate: usize) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.views.iter().map(move |view| view.weights[candidate])
    }

    /// The system with one more candidate, or with another one in place of number `at`.
    pub fn with(&self, at: Option<usize>, candidate: Candidate, column: Arc<Column>, target: &Target) -> Self {
        let mut next = self.clone();
        let place = at.unwrap_or(self.candidates.len());
        match at {
            Some(at) => (next.candidates[at], next.columns[at]) = (candidate, column),
            None => {
                next.candidates.push(candidate);
                next.columns.push(column);
            }
        }
        for (number, view) in next.views.iter_mut().enumerate() {
            if at.is_none() {
                view.gram.iter_mut().for_each(|row| row.push([0.0; 3]));
                view.gram.push(vec![[0.0; 3]; place + 1]);
                view.right.push([0.0; 3]);
                view.weights.push([0.0; 3]);
            }
            for (other, column) in next.columns.iter().enumerate() {
                let found = product(&next.columns[place][number], &column[number]);
                (view.gram[place][other], view.gram[other][place]) = (found, found);
            }
            view.right[place] = product(&next.columns[place][number], &target.values[number]);
        }
        next.solve(target);
        next
    }

    /// The system without a candidate.
    pub fn without(&self, at: usize, target: &Target) -> Self {
        let mut next = self.clone();
        next.candidates.remove(at);
        next.columns.remove(at);
        for view in &mut next.views {
            view.gram.remove(at);
            for row in &mut view.gram {
                row.remove(at);
            }
            view.right.remove(at);
            view.weights.remove(at);
        }
        next.solve(target);
        next
    }

    fn solve(&mut self, target: &Target) {
        self.error = 0.0;
        for (view, squares) in self.views.iter_mut().zip(&target.squares) {
            for channel in 0..3 {
                self.error += view.solve(channel, squares[channel]);
            }
        }
    }

    /// Target minus the weighted sum of all columns.
    pub fn residual(&self, target: &Target) -> Column {
        let mut residual = target.values.clone();
        for (number, (rest, view)) in residual.iter_mut().zip(&self.views).enumerate() {
            for (column, weights) in self.columns.iter().zip(&view.weights) {
                for (rest, look) in rest.iter_mut().zip(&column[number]) {
                    (0..3).for_each(|k| rest[k] -= weights[k] as f32 * look[k]);
                }
            }
        }
        residual
    }
}

/// Share of a residual that a column alone would remove with weights of 0 or more.
pub fn gain(column: &Column, residual: &Column) -> f64 {
    let of_view = |(column, residual): (&Vec<[f32; 3]>, &Vec<[f32; 3]>)| -> f64 {
        let (common, own) = (product(column, residual), product(column, column));
        (0..3).map(|k| if own[k] > 0.0 { common[k].max(0.0).powi(2) / own[k] } else { 0.0 }).sum()
    };
    column.iter().zip(residual).map(of_view).sum()
}

impl Normal {
    /// Minimises the squared error of a channel from the present weights; returns the error.
    fn solve(&mut self, channel: usize, squares: f64) -> f64 {
        let count = self.right.len();
        let mut gram: Vec<f64> = self.gram.iter().flatten().map(|products| products[channel]).collect();
        (0..count).for_each(|k| gram[k * count + k] *= 1.0 + RIDGE);
        let right: Vec<f64> = self.right.iter().map(|products| products[channel]).collect();
        let mut weights: Vec<f64> = self.weights.iter().map(|weight| weight[channel]).collect();
        minimise(&gram, &right, &mut weights);
        let mut error = squares;
        for k in 0..count {
            self.weights[k][channel] = weights[k];
            let sum: f64 = (0..count).map(|j| gram[k * count + j] * weights[j]).sum();
            error += weights[k] * (sum - 2.0 * right[k]);
        }
        error.max(0.0)
    }
}
