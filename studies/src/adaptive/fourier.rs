//! Comparison of predicted bandwidth with windowed Fourier transforms of the rendering, and of predicted with measured variance
//! (figure 12 of Bagher et al. 2012).

use super::case::{Case, StudyMaterial};
use super::interpolation::shaded_share;
use super::sample_counts::{SampleCounts, sample_counts};
use super::spectrum::{WINDOW, WindowBandwidth, window_bandwidths};
use super::statistics::{Quantiles, correlation, ranks};
use super::variance::{DeviationRow, compared as compared_deviations, sampled_deviations};
use brdfc_formats::bandwidth::propagation::pyramid_level;
use brdfc_metrics::image::{LinearImage, luminance};
use brdfc_readers::colour::encode_srgb;
use brdfc_render::adaptive::{Prediction, Settings, draw, maximum_bandwidth, predict};
use brdfc_render::rendering::{Panel, difference_panel, octave_map, sheet, to_panel};
use schemars::JsonSchema;
use serde::Serialize;

/// Pixels between windows.
const STRIDE: usize = 4;
/// Mean samples per pixel of the figure's rendering.
const BUDGET: f32 = 64.0;
/// PSNR of renderings whose levels follow the prediction or the transform, dB.
const PSNR: f64 = 30.0;
/// Octaves of the figure's maps below their maximum.
const OCTAVES: f32 = 6.0;

/// Comparison of predictions with the rendering.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FourierRow {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// Windows of 32 x 32 pixels that show only surfaces.
    pub windows: usize,
    /// Share of them whose prediction is within a factor 4, 0 to 1.
    pub within_4: f64,
    /// Share of them whose prediction is too low by more than a factor 2.
    pub too_low_by_2: f64,
    /// Spearman's rank correlation, -1 to 1.
    pub rank_correlation: f64,
    /// The same with the transform's detail, for which the mean of a window counts as a frequency of 0.
    pub rank_correlation_of_detail: f64,
    /// Share of pixels to shade for 30 dB if levels follow the prediction, and shaded pixels have no error; null if that
    /// is not reached.
    pub shaded_by_prediction: Option<f64>,
    /// The same if levels follow the transform instead.
    pub shaded_by_transform: Option<f64>,
    /// Mean prediction of surface pixels in cycles per pixel, and that of the maximum of the directions (figure 6).
    pub mean_and_maximum: [f64; 2],
    /// Share of surface pixels that demand full resolution, more than 1/4 cycle per pixel: by the prediction, and by the
    /// maximum of the directions.
    pub at_full_resolution: [f64; 2],
    /// Ratios of prediction and transform.
    pub ratios: Quantiles,
    /// Predicted standard deviations of samples at the same pixels.
    pub deviation: DeviationRow,
    /// Numbers of samples that follow the prediction.
    pub sample_counts: SampleCounts,
}

/// Predictions of a case and their references.
pub struct FourierCheck {
    prediction: Prediction,
    /// Maximum bandwidth of the directions of each pixel.
    maximum: Vec<f32>,
    /// Centres of the windows, `[column, row]`.
    windows: Vec<[usize; 2]>,
    /// Bandwidth of each window, cycles per pixel.
    bandwidth: Vec<WindowBandwidth>,
    /// Bandwidth of each pixel, by the window around it; predicted where the window leaves the surface.
    transformed: Vec<f32>,
    /// Standard deviation of samples at each centre.
    deviation: Vec<f32>,
}

impl FourierCheck {
    /// Predicts, and computes the references at every window. The rendering is the ground truth as displayed.
    pub fn new(case: &Case<'_>, material: &StudyMaterial<'_>) -> Self {
        let prediction = predict(&case.adaptive, case.frame, case.buffer, &case.settings());
        let maximum = maximum_bandwidth(&case.adaptive, case.frame, case.buffer, &case.settings());
        let (width, height) = (case.frame.width, case.frame.height);
        let shown: Vec<f32> = case
            .truth
            .pixels
            .iter()
            .map(|pixel| {
                luminance(pixel.map(|c| encode_srgb((f64::from(c) * case.exposure).clamp(0.0, 1.0)) as f32)) as f32
            })
            .collect();
        let half = WINDOW / 2;
        let is_surface = |[column, row]: &[usize; 2]| {
            let all = |y: usize| (column - half..column + half).all(|x| case.buffer.part_at(y * width + x).is_some());
            (row - half..row + half).all(all)
        };
        let rows = half..=height.saturating_sub(half);
        let all: Vec<[usize; 2]> = rows
            .flat_map(|row| (half..=width.saturating_sub(half)).map(move |column| [column, row]))
            .filter(is_surface)
            .collect();
        let found = window_bandwidths(&shown, width, &all);
        let mut transformed = prediction.bandwidth.clone();
        all.iter().zip(&found).for_each(|([x, y], found)| transformed[y * width + x] = found.frequency);
        let is_compared = |[x, y]: &[usize; 2]| (x - half).is_multiple_of(STRIDE) && (y - half).is_multiple_of(STRIDE);
        let compared = all.into_iter().zip(found).filter(|(window, _)| is_compared(window));
        let (windows, bandwidth): (Vec<[usize; 2]>, Vec<WindowBandwidth>) = compared.unzip();
        let pixels: Vec<usize> = windows.iter().map(|[x, y]| y * width + x).collect();
        let deviation = sampled_deviations(case, material, &pixels);
        Self { prediction, maximum, windows, bandwidth, transformed, deviation }
    }

    /// Compares predictions with references.
    pub fn row(&self, case: &Case<'_>, material: &str, shape: &str) -> FourierRow {
        let at_windows = |values: &[f32]| -> Vec<f32> {
            self.windows.iter().map(|[x, y]| values[y * case.frame.width + x]).collect()
        };
        let deviation = compared_deviations(&at_windows(&self.prediction.deviation), &self.deviation);
        let surfaces = (0..case.buffer.part.len()).filter(|pixel| case.buffer.part_at(*pixel).is_some());
        let surfaces: Vec<usize> = surfaces.collect();
        let of_surfaces = |number: &dyn Fn(f32) -> f64| {
            [&self.prediction.bandwidth, &self.maximum]
                .map(|all| surfaces.iter().map(|pixel| number(all[*pixel])).sum::<f64>() / surfaces.len().max(1) as f64)
        };
        FourierRow {
            mean_and_maximum: of_surfaces(&f64::from),
            at_full_resolution: of_surfaces(&|bandwidth| f64::from(u8::from(pyramid_level(bandwidth, 1) == 0))),
            shaded_by_prediction: shaded_share(case, &self.prediction.bandwidth, PSNR),
            shaded_by_transform: shaded_share(case, &self.transformed, PSNR),
            sample_counts: sample_counts(case, &self.prediction),
            ..compared(&at_windows(&self.prediction.bandwidth), &self.bandwidth, deviation, material, shape)
        }
    }

    /// Figure 12, from left to right: predicted standard deviation of samples and that of samples, predicted bandwidth and
    /// that of the rendering, adaptive shading, and its ΔE.
    pub fn figure(&self, case: &Case<'_>) -> Panel {
        let (width, height) = (case.frame.width, case.frame.height);
        let map = |values: &[f32]| octave_map(values, width, height, OCTAVES);
        let spread = |values: &[f32]| {
            let mut all = vec![0.0; width * height];
            for ([x, y], value) in self.windows.iter().zip(values) {
                for (down, right) in (0..STRIDE).flat_map(|down| (0..STRIDE).map(move |right| (down, right))) {
                    all[(y + down - STRIDE / 2) * width + x + right - STRIDE / 2] = *value;
                }
            }
            map(&all)
        };
        let drawn = drawn(case);
        sheet(&[
            map(&self.prediction.deviation),
            spread(&self.deviation),
            map(&self.prediction.bandwidth),
            spread(&self.bandwidth.iter().map(|found| found.frequency).collect::<Vec<_>>()),
            to_panel(&drawn, case.exposure),
            difference_panel(&drawn, &case.truth, case.exposure),
        ])
    }

    /// Figure 6, from left to right: adaptive shading, the maximum of the directions' bandwidths, and their mean, on the
    /// same scale.
    pub fn combining(&self, case: &Case<'_>) -> Panel {
        let (width, height) = (case.frame.width, case.frame.height);
        let both: Vec<f32> = self.maximum.iter().chain(&self.prediction.bandwidth).copied().collect();
        let mut maximum = octave_map(&both, width, 2 * height, OCTAVES);
        let mean = Panel { width, height, rgb: maximum.rgb.split_off(maximum.rgb.len() / 2) };
        maximum.height = height;
        sheet(&[to_panel(&drawn(case), case.exposure), maximum, mean])
    }
}

/// The figures' rendering.
fn drawn(case: &Case<'_>) -> LinearImage {
    let settings = Settings { samples: BUDGET, ..case.settings() };
    draw(&case.adaptive, case.frame, case.buffer, &settings).image
}

fn compared(
    predicted: &[f32],
    reference: &[WindowBandwidth],
    deviation: DeviationRow,
    material: &str,
    shape: &str,
) -> FourierRow {
    let details: Vec<f32> = reference.iter().map(|found| found.detail).collect();
    let reference: Vec<f32> = reference.iter().map(|found| found.frequency).collect();
    let mut ratios: Vec<f64> =
        predicted.iter().zip(&reference).map(|(p, r)| f64::from(*p) / f64::from(r.max(1e-6))).collect();
    let [rank_correlation, rank_correlation_of_detail] =
        [&reference, &details].map(|values| correlation(&ranks(predicted), &ranks(values)));
    ratios.sort_by(f64::total_cmp);
    let count = ratios.len().max(1) as f64;
    let share = |is: &dyn Fn(f64) -> bool| ratios.iter().filter(|ratio| is(**ratio)).count() as f64 / count;
    FourierRow {
        material: material.to_owned(),
        shape: shape.to_owned(),
        windows: ratios.len(),
        within_4: share(&|ratio| (0.25..=4.0).contains(&ratio)),
        too_low_by_2: share(&|ratio| ratio < 0.5),
        rank_correlation,
        rank_correlation_of_detail,
        mean_and_maximum: [0.0; 2],
        at_full_resolution: [0.0; 2],
        shaded_by_prediction: None,
        shaded_by_transform: None,
        ratios: Quantiles::of(&ratios),
        deviation,
        sample_counts: SampleCounts::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptive::{Lighting, TruthSamples};
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::{dot, normalize};
    use brdfc_render::adaptive::Start;
    use brdfc_render::scene::{Environment, Frame};
    use brdfc_render::scenes::Builtin;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn ranks_are_invariant_to_monotone_changes() {
        let values = [0.3f32, 0.1, 0.2, 0.2, 0.9];
        assert_eq!(ranks(&values), [3.0, 0.0, 1.5, 1.5, 4.0]);
        let reference = |frequency: f32, detail: f32| WindowBandwidth { frequency, detail };
        let of = |a: &[f32], b: &[WindowBandwidth]| compared(a, b, compared_deviations(a, a), "", "");
        let row = of(&values, &values.map(|v| reference(v * v, -v)));
        assert!((row.rank_correlation - 1.0).abs() < 1e-12 && (row.rank_correlation_of_detail + 1.0).abs() < 1e-12);
        assert_eq!((row.windows, row.within_4), (5, 0.4));
        // The control: the reversed order.
        let reversed = values.map(|v| -v);
        assert!((correlation(&ranks(&values), &ranks(&reversed)) + 1.0).abs() < 1e-12);
        assert_eq!(of(&[0.1, 0.1], &[reference(0.3, 0.0), reference(0.1, 0.0)]).too_low_by_2, 0.5);
    }

    /// Light with the same amount of detail everywhere.
    fn waves() -> Environment {
        let (width, height) = (256, 128);
        let axes =
            [[1.0, 0.2, 0.1], [0.1, 1.0, 0.3], [-0.3, 0.2, 1.0], [0.7, 0.7, -0.2], [-0.6, 0.1, 0.8]].map(normalize);
        let pixel = |index: usize| {
            let theta = PI * ((index / width) as f64 + 0.5) / height as f64;
            let phi = TAU * ((index % width) as f64 + 0.5) / width as f64;
            let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            let sum: f64 = axes.iter().map(|axis| (TAU * 5.0 * dot(d, *axis)).cos()).sum();
            [(1.0 + 0.15 * sum) as f32; 3]
        };
        Environment { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    /// Figure 12 on a glossy sphere. The negative control uses bandwidths of a surface without curvature.
    #[test]
    fn predictions_follow_the_rendering() {
        let source = parse_synth("synth:ggx?kd=0&f0=0.9&alpha=0.05").unwrap();
        let material = StudyMaterial::new("metal".to_owned(), source.as_ref()).unwrap();
        let lighting = Lighting::new(waves()).unwrap();
        let frame = Frame { width: 128, height: 128, samples: 1 };
        let truth = TruthSamples::Fixed(256, Start::Shared);
        Case::with(&material, &Builtin::Sphere.scene(), &lighting, frame, truth, |case| {
            let check = FourierCheck::new(case, &material);
            let row = check.row(case, "metal", "sphere");
            assert!(row.windows > 100 && row.within_4 >= 0.9 && row.too_low_by_2 <= 0.05, "{row:?}");
            let [share, by_transform] = [row.shaded_by_prediction, row.shaded_by_transform].map(Option::unwrap);
            assert!(share > 0.01 && share < 0.5 && by_transform > 0.01 && by_transform < 0.5, "{row:?}");
            // A smaller error takes more pixels.
            let finer = shaded_share(case, &check.prediction.bandwidth, PSNR + 6.0).unwrap();
            assert!(finer > 1.2 * share, "{finer} {share}");
            // The control: samples in inverse proportion to the prediction.
            assert!(row.sample_counts.prediction > row.sample_counts.uniform, "{row:?}");
            let mut other = check.prediction.clone();
            other.deviation.iter_mut().for_each(|deviation| *deviation = 1.0 / deviation.max(1e-3));
            assert!(sample_counts(case, &other).prediction < row.sample_counts.uniform, "{row:?}");
            let mut flat = case.buffer.clone();
            let facing = flat.normal[64 * 128 + 64];
            flat.normal.iter_mut().for_each(|normal| *normal = facing);
            let case = Case { buffer: &flat, truth: case.truth.clone(), ..*case };
            let row = FourierCheck::new(&case, &material).row(&case, "metal", "sphere");
            assert!(row.too_low_by_2 > 0.5, "{row:?}");
        });
    }
}
