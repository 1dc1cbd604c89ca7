//! Samples and time that methods need for the same error: adaptive shading (section 5 of Bagher et al. 2012), and the
//! simpler methods that compete with it.

use super::case::Case;
use super::curve::{Cost, Point, Target, error_within, needed};
use super::method::{Budget, Density, LookUps, Method, Prefiltered, Variant, draw};
use brdfc_metrics::image::{PIXELS_PER_DEGREE, flip};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Targets of the comparison.
pub const TARGETS: [Target; 4] = [Target::Psnr(25.0), Target::Psnr(30.0), Target::Flip(0.15), Target::Flip(0.1)];
/// Values of [`Variant::caution`] to try.
pub const CAUTIONS: [f32; 3] = [0.35, 0.5, 1.0];
/// Filtered samples that each point takes from another place of the sequence, and that all points share.
const STARTS: [bool; 2] = [false, true];
/// Numbers of look-ups of lobes to try.
pub const FETCHES: [usize; 5] = [1, 2, 4, 8, 16];
/// Maximum number of samples per surface pixel.
pub const MAX_SAMPLES: f64 = 32.0;
/// PSNR of renderings without a difference, dB.
const MAX_PSNR: f64 = 99.0;
/// Improvements from one rendering to the next below which a method has converged: dB, and share of FLIP.
const CONVERGED: (f64, f64) = (0.1, 0.02);

/// All methods in one case.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CaseRow {
    /// The material.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// The environment.
    pub environment: String,
    /// Pixels per side of the rendering.
    pub pixels: usize,
    /// Pixels that show a surface.
    pub surface_pixels: usize,
    /// Samples per pixel of the ground truth.
    pub truth_samples: usize,
    /// PSNR of the ground truth, from the difference of its two halves, dB; null without a difference.
    pub truth_psnr: Option<f64>,
    /// Mean FLIP of a rendering with half of the samples of the ground truth.
    pub truth_flip: f64,
    /// All methods.
    pub methods: Vec<MethodRow>,
}

/// A method in one case.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MethodRow {
    /// The method.
    pub method: Method,
    /// Cost for each target, of the curve with the fewest samples; null if the method does not reach the target.
    pub needed: Vec<Option<Cost>>,
    /// Smallest error, in the unit of each target; null without renderings.
    pub best: Vec<Option<f64>>,
    /// Smallest error within the time that adaptive shading needs for each target, in its unit (figures 14 and 15 of Bagher
    /// et al. 2012); null if adaptive shading does not reach the target, and if the method takes longer.
    pub at_equal_time: Vec<Option<f64>>,
    /// Renderings by cost, for each variant of the method.
    pub curves: Vec<Curve>,
}

/// Renderings of a method by cost.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Curve {
    /// Settings of the method.
    #[serde(flatten)]
    pub variant: Variant,
    /// The renderings.
    pub points: Vec<Point>,
}

/// Draws a case by all methods. `names` are of the material, shape and environment.
pub fn compare(case: &Case<'_>, prefiltered: Prefiltered<'_>, names: [&str; 3]) -> CaseRow {
    let [material, shape, environment] = names.map(str::to_owned);
    let adaptive = of_method(case, prefiltered, Method::Adaptive, 0.0);
    let times: Vec<Option<f64>> = adaptive.needed.iter().map(|cost| Some(cost.as_ref()?.seconds)).collect();
    let last = times.iter().flatten().copied().fold(0.0, f64::max);
    let of = |(method, _): &(Method, &str)| match method {
        Method::Adaptive => adaptive.clone(),
        method => of_method(case, prefiltered, *method, last),
    };
    let mut methods: Vec<MethodRow> = Method::ALL.iter().map(of).collect();
    for of in &mut methods {
        let within = |(target, seconds): (&Target, &Option<f64>)| {
            let errors = of.curves.iter().filter_map(|curve| error_within(&curve.points, (*seconds)?, *target));
            errors.max_by(|a, b| target.quality_of(*a).total_cmp(&target.quality_of(*b)))
        };
        of.at_equal_time = TARGETS.iter().zip(&times).map(within).collect();
    }
    CaseRow {
        material,
        shape,
        environment,
        pixels: case.frame.width,
        surface_pixels: case.surface,
        truth_samples: case.truth_samples,
        truth_psnr: Some(case.truth_psnr).filter(|psnr| psnr.is_finite()),
        truth_flip: case.truth_flip,
        methods,
    }
}

/// Budgets of a method, from small to large, until its curve ends.
pub(super) fn budgets(method: Method, prefiltered: Prefiltered<'_>) -> Vec<Budget> {
    match method.parts().1 {
        LookUps::Lobes => (0..prefiltered.lobes.len()).map(Budget::Pack).collect(),
        LookUps::Gaussians => (0..prefiltered.gaussians.len()).map(Budget::Pack).collect(),
        LookUps::SplitSum => vec![Budget::Samples(prefiltered.split_sum.fetches())],
        // MAX_SAMPLES ends a curve; this bound is for renderings without surfaces.
        LookUps::Samples | LookUps::FilteredSamples => (0..12).map(|k| Budget::Samples(1 << k)).collect(),
    }
}

/// Draws a case by a method; its curves reach a time in seconds if more samples, at most [`MAX_SAMPLES`], allow it.
fn of_method(case: &Case<'_>, prefiltered: Prefiltered<'_>, method: Method, until: f64) -> MethodRow {
    let variants: Vec<Variant> = match method.parts() {
        (_, LookUps::Lobes | LookUps::SplitSum | LookUps::Gaussians) | (Density::Level(_), LookUps::Samples) => {
            vec![Variant::default()]
        }
        (Density::Level(_), LookUps::FilteredSamples) => STARTS.map(|shared| Variant { shared, caution: None }).into(),
        (Density::Adaptive, look_ups) => {
            let starts = if look_ups == LookUps::Samples { &STARTS[..1] } else { &STARTS[..] };
            let variant = |shared: &bool| CAUTIONS.map(|caution| Variant { shared: *shared, caution: Some(caution) });
            starts.iter().flat_map(variant).collect()
        }
    };
    let budgets = budgets(method, prefiltered);
    let curve = |variant| Curve { variant, points: points(case, prefiltered, (method, variant), &budgets, until) };
    let curves: Vec<Curve> = variants.into_iter().map(curve).collect();
    let least = |target: &Target| {
        let costs = curves.iter().filter_map(|curve| needed(&curve.points, *target));
        costs.min_by(|a, b| a.samples.total_cmp(&b.samples))
    };
    let best = |target: &Target| target.best(curves.iter().flat_map(|curve| &curve.points));
    let (needed, best) = (TARGETS.iter().map(least).collect(), TARGETS.iter().map(best).collect());
    MethodRow { method, needed, best, at_equal_time: Vec::new(), curves }
}

/// Renderings with increasing budgets, until all targets are met and the time is over, or the error stays.
fn points(
    case: &Case<'_>,
    prefiltered: Prefiltered<'_>,
    (method, variant): (Method, Variant),
    budgets: &[Budget],
    until: f64,
) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    let mut idle = 0;
    for budget in budgets {
        let started = Instant::now();
        let (image, samples) = draw(case, prefiltered, method, variant, *budget);
        let seconds = started.elapsed().as_secs_f64();
        let flip = flip(&image, &case.truth, case.exposure, PIXELS_PER_DEGREE).mean_on_surfaces;
        let samples = samples as f64 / case.surface.max(1) as f64;
        let point = Point { samples, seconds, psnr: case.psnr(&image).min(MAX_PSNR), flip };
        if point.samples > MAX_SAMPLES {
            break;
        }
        let improves =
            |last: &Point| point.psnr > last.psnr + CONVERGED.0 || point.flip < last.flip * (1.0 - CONVERGED.1);
        idle = if points.iter().all(improves) { 0 } else { idle + 1 };
        points.push(point);
        // Errors do not fall with every doubling, so one that does not is not the end.
        let met = TARGETS.iter().all(|target| target.is_met(&point)) && seconds >= until;
        if met || (idle == 2 && !matches!(budget, Budget::Pack(_))) {
            break;
        }
    }
    points
}
