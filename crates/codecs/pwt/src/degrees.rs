//! Section 2, "the polynomial degree is chosen per subband": the one whose prediction of lights left out is best, so that
//! more terms never make unseen lights worse.

use crate::design::Design;
use crate::image::Plane;
use crate::tree::{PacketTree, Subband};
use brdfc_formats::pwt::LightBasis;
use rayon::prelude::*;

/// Most coefficients of a subband that are looked at.
const MOST: usize = 2048;

/// The degree of a subband, and what it gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubbandDegree {
    /// The subband.
    pub subband: Subband,
    /// Terms up to this degree are kept; none at all where that is best.
    pub degree: Option<u32>,
    /// Mean square of its coefficients over the lights.
    pub energy: f64,
    /// Mean squared error at lights left out, with these terms.
    pub held_out: f64,
}

/// The degree of every subband of a channel. `planes` are the channel under each light, not transformed yet.
pub fn degrees(design: &Design, tree: &PacketTree, planes: Vec<Plane>) -> Vec<SubbandDegree> {
    let subbands = tree.subbands();
    // Of each light the coefficients that are looked at, subband by subband.
    let sampled: Vec<Vec<Vec<f32>>> = planes
        .into_par_iter()
        .map(|mut plane| {
            tree.analyse(&mut plane);
            subbands.iter().map(|subband| coefficients(&plane, subband)).collect()
        })
        .collect();
    (0..subbands.len())
        .into_par_iter()
        .map(|k| {
            let lights: Vec<&[f32]> = sampled.iter().map(|light| &light[k][..]).collect();
            of_subband(design, subbands[k], &lights)
        })
        .collect()
}

/// Whole rows, evenly spread.
fn coefficients(plane: &Plane, subband: &Subband) -> Vec<f32> {
    let [width, height] = subband.rectangle.size;
    let rows = (MOST / width.max(1)).clamp(1, height.max(1));
    (0..rows).flat_map(|k| plane.row(subband.rectangle, k * height / rows)).copied().collect()
}

fn of_subband(design: &Design, subband: Subband, lights: &[&[f32]]) -> SubbandDegree {
    let terms = design.terms();
    let count = (lights.len() * lights.first().map_or(0, |light| light.len())).max(1) as f64;
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
        let leverages = design.leverages(degree);
        let errors = residuals.iter().zip(leverages).map(|(residual, h)| square(residual) / (1.0 - h).powi(2));
        let error = mean(errors.sum());
        if error < best.1 {
            best = (Some(degree), error);
        }
    }
    SubbandDegree { subband, degree: best.0, energy, held_out: best.1 }
}
