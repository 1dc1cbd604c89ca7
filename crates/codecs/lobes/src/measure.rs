//! Error of lobes in environments that the fit did not use.

use super::views::{View, Views};
use brdfc_formats::lobes::LobesPack;
use brdfc_metrics::lab::{distance_squared, lab};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Colour difference (ΔE of 1976) between renderings of a ball by lobes and by the integral.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct RenderingError {
    /// Mean over the ball and all environments.
    pub mean: f64,
    /// 95th percentile.
    pub p95: f64,
}

/// Error of a pack over all views, weighted by their share of a ball.
pub fn rendering_error(pack: &LobesPack, views: &Views<'_>) -> RenderingError {
    let of_view = |view: &View| -> Vec<(f64, f64)> {
        let outgoing = view.outgoing.map(|c| c as f32);
        let difference = |(number, expected): (usize, &[f64; 3])| {
            let (environment, frame, exposure) = views.frame(number);
            let found = pack.radiance(environment, frame.axes(), outgoing);
            let [a, b] = [found.map(f64::from), *expected].map(|colour| lab(colour.map(|c| (c * exposure) as f32)));
            (f64::from(distance_squared(a, b)).sqrt(), view.area)
        };
        view.radiance.iter().enumerate().map(difference).collect()
    };
    let mut all: Vec<(f64, f64)> = views.views.par_iter().flat_map_iter(of_view).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = all.iter().map(|(_, area)| area).sum();
    let mean = all.iter().map(|(difference, area)| difference * area).sum::<f64>() / total;
    let mut left = 0.95 * total;
    let p95 = all.iter().find(|(_, area)| {
        left -= area;
        left <= 0.0
    });
    RenderingError { mean, p95: p95.map_or(0.0, |(difference, _)| *difference) }
}
