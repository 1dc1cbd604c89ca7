//! Polynomial degree per subband (section 2, "the polynomial degree is chosen per subband"): the degree with the best
//! leave-one-out prediction, so that more terms never increase the error at held-out lights.

use crate::design::Design;
use crate::image::Plane;
use crate::tree::{PacketTree, Subband};
use brdfc_formats::pwt::LightBasis;
use rayon::prelude::*;

/// Maximum number of coefficients of a subband that are evaluated.
const MAX_COEFFICIENTS: usize = 2048;

/// Degree of a subband, and its errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubbandDegree {
    /// The subband.
    pub subband: Subband,
    /// Highest degree of the terms that are stored; `None` if it is best to store none.
    pub degree: Option<u32>,
    /// Mean square of its coefficients over the lights.
    pub energy: f64,
    /// Mean squared leave-one-out error with these terms; for a single light, the error of the fit.
    pub held_out: f64,
}

/// Chooses the degree of every subband of a channel. `planes` are the untransformed channel under each light. `defined`
/// marks defined texels (1, others 0): a coefficient is weighted by the share of defined texels that it covers.
pub fn degrees(design: &Design, tree: &PacketTree, planes: Vec<Plane>, defined: Option<&Plane>) -> Vec<SubbandDegree> {
    let subbands = tree.subbands();
    let shares: Vec<Option<Vec<f32>>> =
        subbands.iter().map(|subband| defined.map(|plane| shares(plane, subband))).collect();
    // For each light, the sampled coefficients, subband by subband.
    let sampled: Vec<Vec<Vec<f32>>> = planes
        .into_par_iter()
        .map(|mut plane| {
            tree.analyse(&mut plane);
            let counted = |(subband, shares): (&Subband, &Option<Vec<f32>>)| {
                let mut values = coefficients(&plane, subband);
                // Each coefficient is fitted independently, so scaling values weights their squares.
                values.iter_mut().zip(shares.iter().flatten()).for_each(|(value, share)| *value *= share.sqrt());
                values
            };
            subbands.iter().zip(&shares).map(counted).collect()
        })
        .collect();
    (0..subbands.len())
        .into_par_iter()
        .map(|k| {
            let lights: Vec<&[f32]> = sampled.iter().map(|light| &light[k][..]).collect();
            let numbers = lights.first().map_or(0, |light| light.len()) as f64;
            let counted = shares[k].as_ref().map_or(numbers, |shares| shares.iter().map(|s| f64::from(*s)).sum());
            of_subband(design, subbands[k], &lights, counted)
        })
        .collect()
}

/// Sampled rows of a subband, evenly spread.
fn sampled_rows(subband: &Subband) -> impl Iterator<Item = usize> + use<> {
    let [width, height] = subband.rectangle.size;
    let rows = (MAX_COEFFICIENTS / width.max(1)).clamp(1, height.max(1));
    (0..rows).map(move |k| k * height / rows)
}

fn coefficients(plane: &Plane, subband: &Subband) -> Vec<f32> {
    sampled_rows(subband).flat_map(|row| plane.row(subband.rectangle, row)).copied().collect()
}

/// Means of a plane over the texels that the coefficients of [`coefficients`] cover.
fn shares(plane: &Plane, subband: &Subband) -> Vec<f32> {
    let [width, height] = subband.rectangle.size;
    let [across, down] = [plane.size[0] / width.max(1), plane.size[1] / height.max(1)];
    let mean = |row: usize, column: usize| {
        let rows = plane.values.chunks_exact(plane.size[0]).skip(row * down).take(down);
        let sum: f32 = rows.flat_map(|texels| &texels[column * across..(column + 1) * across]).sum();
        sum / (across * down).max(1) as f32
    };
    sampled_rows(subband).flat_map(|row| (0..width).map(move |column| (row, column))).map(|(y, x)| mean(y, x)).collect()
}

fn of_subband(design: &Design, subband: Subband, lights: &[&[f32]], counted: f64) -> SubbandDegree {
    let terms = design.terms();
    let count = (lights.len() as f64 * counted).max(f64::MIN_POSITIVE);
    let mean = |sum: f64| sum / count;
    let square = |values: &[f32]| values.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
    let energy = mean(lights.iter().map(|light| square(light)).sum());
    let mut best = (None, energy);
    let mut residuals: Vec<Vec<f32>> = lights.iter().map(|light| light.to_vec()).collect();
    let mut first = 0;
    for degree in 0..=design.basis.degree {
        let last = LightBasis { degree, ..design.basis }.terms();
        for term in first..last.min(terms) {
            let mut coefficients = vec![0.0f32; residuals[0].len()];
            for (light, values) in lights.iter().enumerate() {
                let weight = design.row(light)[term] as f32;
                coefficients.iter_mut().zip(*values).for_each(|(sum, value)| *sum += weight * value);
            }
            for (light, residual) in residuals.iter_mut().enumerate() {
                let weight = design.row(light)[term] as f32;
                residual.iter_mut().zip(&coefficients).for_each(|(value, c)| *value -= weight * c);
            }
        }
        first = last;
        let leverages = match design.leverages(degree) {
            Some(leverages) => leverages,
            // A single light cannot be held out: its image is fitted exactly.
            None if degree == 0 => vec![0.0; lights.len()],
            None => continue,
        };
        let errors = residuals.iter().zip(leverages).map(|(residual, h)| square(residual) / (1.0 - h).powi(2));
        let error = mean(errors.sum());
        if error < best.1 {
            best = (Some(degree), error);
        }
    }
    SubbandDegree { subband, degree: best.0, energy, held_out: best.1 }
}
