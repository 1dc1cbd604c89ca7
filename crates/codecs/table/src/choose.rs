//! Sizes and warps of tables, chosen by small trial fits.

use super::fit::fit_roughly;
use super::lattice::Lattice;
use super::recipe::Aim;
use super::samples::Samples;
use super::targets::Targets;
use brdfc_formats::container::MAX_EXTENT;
use brdfc_formats::table::{Axes, Folded, KNOTS, TableHeader, TableSymmetry};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Samples of a trial per node, and their minimum.
const TRIAL_SAMPLES: usize = 4;
const MIN_TRIAL_SAMPLES: usize = 8 << 10;
/// Maximum number of samples that test a trial.
const JUDGES: usize = 8 << 10;
/// Tried numbers of layers of anisotropic tables.
const LAYERS: [u32; 7] = [4, 2, 3, 5, 6, 8, 12];

/// Spacing of the columns over `θ_h`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Warp {
    /// Equal steps of the angle's power.
    Power(f64),
    /// Equal steps of `ln(1 + θ/a)`: dense near the normal, ever wider beyond.
    Logarithm(f64),
    /// Equal steps of `ln(1 + (θ/a)²)`: densest around `a`, for lobes with a flat top.
    Lobe(f64),
}

const WARPS: [Warp; 10] = [
    Warp::Lobe(0.1),
    Warp::Power(0.5),
    Warp::Logarithm(0.4),
    Warp::Logarithm(0.1),
    Warp::Lobe(0.04),
    Warp::Lobe(0.2),
    Warp::Lobe(0.4),
    Warp::Logarithm(1.5),
    Warp::Power(0.8),
    Warp::Logarithm(0.25),
];

/// Shares of columns, rows and slices, as powers of two; the budget decides their product.
const SHAPES: [[f64; 3]; 11] = [
    [0.6, -0.3, -0.3],
    [0.9, 0.0, -0.9],
    [0.9, -0.9, 0.0],
    [1.2, -0.6, -0.6],
    [1.8, -0.9, -0.9],
    [0.3, 0.3, -0.6],
    [0.3, 0.0, -0.3],
    [0.0, 0.0, 0.0],
    [0.0, -0.3, 0.3],
    [0.45, -0.15, -0.3],
    [0.75, -0.15, -0.6],
];

/// Slopes of the rows.
const SLOPES: [f32; 3] = [0.3, 0.6, 0.0];

impl Warp {
    fn share(self, theta: f64) -> f64 {
        match self {
            Self::Power(power) => theta.powf(power),
            Self::Logarithm(a) => (theta / a).ln_1p(),
            Self::Lobe(a) => (theta / a).powi(2).ln_1p(),
        }
    }

    fn knots(self) -> [f32; KNOTS] {
        let last = self.share(FRAC_PI_2);
        let mut knots = std::array::from_fn(|k| {
            let root = k as f64 / (KNOTS - 1) as f64;
            (self.share(root * root * FRAC_PI_2) / last) as f32
        });
        knots[KNOTS - 1] = 1.0;
        knots
    }
}

/// Texels of the largest tables that are tried: larger tables have the same warps, and axes in the same proportion.
const MAX_TRIED: usize = 4096;
const MAX_TRIED_ANISOTROPIC: usize = 8192;

/// Chooses the table of at most `texels` texels whose small fit is closest to test samples.
///
/// The order is warps, shapes, slopes and warps again. Each step uses the best result of the steps before.
pub fn choose(trial: &Trial<'_>, symmetry: TableSymmetry, texels: usize, isotropic: bool) -> TableHeader {
    let (targets, mut trials) = (trial.targets, Trials::of(trial));
    let layers = if isotropic { 1 } else { LAYERS[0] };
    let tried = texels.min(if isotropic { MAX_TRIED } else { MAX_TRIED_ANISOTROPIC });
    let mut header = trials.warped(start(targets, symmetry, shaped(SHAPES[0], tried, layers, symmetry)));
    header = trials.best(header, &SHAPES, |header, shape| header.axes = shaped(*shape, tried, layers, symmetry));
    if !isotropic {
        let shape = shape_of(header.axes, symmetry);
        header = trials.best(header, &LAYERS, |header, layers| header.axes = shaped(shape, tried, *layers, symmetry));
    }
    header = trials.sloped(header);
    header = trials.warped(header);
    if tried < texels {
        let larger = (texels as f64 / tried as f64).powf(if isotropic { 0.0 } else { 0.25 });
        let layers = (f64::from(header.axes.layers) * larger).round() as u32;
        header.axes = shaped(shape_of(header.axes, symmetry), texels, layers, symmetry);
    }
    header
}

/// Scales a table to at most `texels` texels, with its axes in the same proportion.
pub fn scaled(header: TableHeader, texels: usize) -> TableHeader {
    let symmetry = header.symmetry;
    TableHeader { axes: shaped(shape_of(header.axes, symmetry), texels, header.axes.layers, symmetry), ..header }
}

/// Chooses the warps for these axes whose small fit is closest.
pub fn choose_warps(trial: &Trial<'_>, symmetry: TableSymmetry, axes: Axes) -> TableHeader {
    let mut trials = Trials::of(trial);
    let mut header = trials.warped(start(trial.targets, symmetry, axes));
    header = trials.sloped(header);
    trials.warped(header)
}

pub(super) fn start(targets: &Targets, symmetry: TableSymmetry, axes: Axes) -> TableHeader {
    TableHeader {
        channels: if targets.grey { 1 } else { 3 },
        symmetry,
        axes,
        mean: targets.mean,
        bias: targets.bias,
        low: [0.0; 3],
        span: [0.0; 3],
        slope: SLOPES[0],
        knots: WARPS[0].knots(),
    }
}

/// Shares of columns, rows and slices, as powers of two.
fn shape_of(axes: Axes, symmetry: TableSymmetry) -> [f64; 3] {
    let slices = axes.azimuth + u32::from(!symmetry.mirror);
    let counts = [axes.half, axes.difference, slices].map(f64::from);
    let side = counts.iter().product::<f64>().cbrt();
    counts.map(|count| (count / side).log2())
}

/// Axes of at most `texels` texels, including the repeated slice; with fewer layers if the texels do not suffice.
fn shaped(shape: [f64; 3], texels: usize, layers: u32, symmetry: TableSymmetry) -> Axes {
    let guard = u32::from(!symmetry.mirror);
    let side = (texels as f64 / f64::from(layers)).cbrt();
    let [_, difference, azimuth] = shape.map(|power| ((side * power.exp2()).round() as u32).clamp(2, 256));
    let mut axes = Axes { half: 2, difference, azimuth: azimuth.saturating_sub(guard).max(2), layers };
    let column = |axes: &Axes| axes.difference * (axes.azimuth + guard) * axes.layers;
    let deep = |axes: &Axes| (axes.azimuth + guard) * axes.layers > MAX_EXTENT;
    while 2 * column(&axes) as usize > texels || deep(&axes) {
        let largest = [axes.difference, axes.azimuth, axes.layers];
        match largest {
            [difference, azimuth, _] if difference >= azimuth && difference > 2 && !deep(&axes) => axes.difference -= 1,
            [_, azimuth, _] if azimuth > 2 => axes.azimuth -= 1,
            [_, _, layers] if layers > 2 => axes.layers -= 1,
            _ => break,
        }
    }
    // Columns take the remaining texels.
    axes.half = ((texels as u32) / column(&axes)).clamp(2, 256);
    axes
}

/// Input of trial fits.
pub struct Trial<'a> {
    /// Samples to fit.
    pub samples: &'a Samples,
    /// Folded angles of the samples.
    pub folded: &'a [Folded],
    /// Targets of the fit.
    pub targets: &'a Targets,
}

/// Results of trials; repeated tables are not fitted again.
struct Trials<'a> {
    trial: &'a Trial<'a>,
    errors: Vec<(TableHeader, f64)>,
}

impl<'a> Trials<'a> {
    fn of(trial: &'a Trial<'a>) -> Self {
        Self { trial, errors: Vec::new() }
    }

    fn warped(&mut self, header: TableHeader) -> TableHeader {
        self.best(header, &WARPS, |header, warp| header.knots = warp.knots())
    }

    fn sloped(&mut self, header: TableHeader) -> TableHeader {
        self.best(header, &SLOPES, |header, slope| header.slope = *slope)
    }

    /// Sets the first of the choices with the smallest error.
    fn best<C>(&mut self, header: TableHeader, choices: &[C], set: impl Fn(&mut TableHeader, &C)) -> TableHeader {
        let with = |choice: &C| {
            let mut header = header;
            set(&mut header, choice);
            header
        };
        let headers: Vec<TableHeader> = choices.iter().map(with).collect();
        let mut new: Vec<TableHeader> = Vec::new();
        for header in &headers {
            if self.error(header).is_none() && !new.contains(header) {
                new.push(*header);
            }
        }
        let errors: Vec<f64> = new.par_iter().map(|header| self.trial.error(header)).collect();
        self.errors.extend(new.into_iter().zip(errors));
        let errors: Vec<Option<f64>> = headers.iter().map(|header| self.error(header)).collect();
        let first = |best: usize, k: usize| if errors[k] < errors[best] { k } else { best };
        headers[(1..headers.len()).fold(0, first)]
    }

    fn error(&self, header: &TableHeader) -> Option<f64> {
        self.errors.iter().find(|(tried, _)| tried == header).map(|(_, error)| *error)
    }
}

impl Trial<'_> {
    /// Sum of differences, of colours or ratios, over samples that were not in the fit.
    fn error(&self, header: &TableHeader) -> f64 {
        let Self { samples, folded, targets } = self;
        let lattice = Lattice::new(header);
        let fitted = (TRIAL_SAMPLES * lattice.len()).max(MIN_TRIAL_SAMPLES).min(2 * samples.len() / 3);
        let count = (fitted + JUDGES).min(samples.len());
        let taps = |k: usize| lattice.taps(&header.place(folded[k]));
        let nodes = fit_roughly(lattice, (0..fitted).map(taps), targets);
        // Ratios count everywhere.
        let judged = |k: &usize| targets.aim == Aim::Ratios || Samples::is_on_ball(*k);
        let found = |k: usize| (k, lattice.value(&taps(k), &nodes), samples.cosines[k]);
        targets.sum_of_differences((fitted..count).filter(judged).map(found))
    }
}
