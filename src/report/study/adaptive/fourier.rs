//! Predicted bandwidth against windowed Fourier transforms of the picture (figure 12 of Bagher et al. 2012).

use super::case::Case;
use crate::metrics::image::{WINDOW, luminance, window_bandwidths};
use crate::render::adaptive::predict;
use brdfc_formats::colour::encode_srgb;
use schemars::JsonSchema;
use serde::Serialize;

/// Pixels between windows.
const STRIDE: usize = 4;

/// How predictions compare with the picture.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FourierRow {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// Windows of 32 x 32 pixels that show nothing but surface.
    pub windows: usize,
    /// Share of them whose prediction is within a factor 4, 0 to 1.
    pub within_4: f64,
    /// Share of them whose prediction is too low by more than a factor 2.
    pub too_low_by_2: f64,
    /// Spearman's rank correlation, -1 to 1.
    pub rank_correlation: f64,
    /// Quantiles of prediction over transform: 5 %, 50 % and 95 %.
    pub ratios: [f64; 3],
}

/// Compares at every window; the picture is that of the ground truth as a display shows it.
pub fn fourier_check(case: &Case<'_>, material: &str, shape: &str) -> FourierRow {
    let prediction = predict(&case.adaptive, case.frame, case.buffer, &case.settings());
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
    let rows = (half..=height.saturating_sub(half)).step_by(STRIDE);
    let windows: Vec<[usize; 2]> = rows
        .flat_map(|row| (half..=width.saturating_sub(half)).step_by(STRIDE).map(move |column| [column, row]))
        .filter(is_surface)
        .collect();
    let reference = window_bandwidths(&shown, width, &windows);
    let predicted: Vec<f32> = windows.iter().map(|[x, y]| prediction.bandwidth[y * width + x]).collect();
    compared(&predicted, &reference, material, shape)
}

fn compared(predicted: &[f32], reference: &[f32], material: &str, shape: &str) -> FourierRow {
    let mut ratios: Vec<f64> =
        predicted.iter().zip(reference).map(|(p, r)| f64::from(*p) / f64::from(r.max(1e-6))).collect();
    let rank_correlation = correlation(&ranks(predicted), &ranks(reference));
    ratios.sort_by(f64::total_cmp);
    let count = ratios.len().max(1) as f64;
    let share = |is: &dyn Fn(f64) -> bool| ratios.iter().filter(|ratio| is(**ratio)).count() as f64 / count;
    let quantile = |q: f64| ratios.get((q * (count - 1.0)).round() as usize).copied().unwrap_or(0.0);
    FourierRow {
        material: material.to_owned(),
        shape: shape.to_owned(),
        windows: ratios.len(),
        within_4: share(&|ratio| (0.25..=4.0).contains(&ratio)),
        too_low_by_2: share(&|ratio| ratio < 0.5),
        rank_correlation,
        ratios: [0.05, 0.5, 0.95].map(quantile),
    }
}

/// Mean ranks of equal values.
fn ranks(values: &[f32]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut start = 0;
    while start < order.len() {
        let equal = order[start..].iter().take_while(|i| values[**i] == values[order[start]]).count();
        let mean = start as f64 + 0.5 * (equal as f64 - 1.0);
        order[start..start + equal].iter().for_each(|i| ranks[*i] = mean);
        start += equal;
    }
    ranks
}

/// Pearson's, of as many values each.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (ma, mb) = (mean(a), mean(b));
    let (mut products, mut squares_a, mut squares_b) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        products += (x - ma) * (y - mb);
        squares_a += (x - ma) * (x - ma);
        squares_b += (y - mb) * (y - mb);
    }
    let spread = (squares_a * squares_b).sqrt();
    if spread > 0.0 { products / spread } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_do_not_mind_monotone_changes() {
        let values = [0.3f32, 0.1, 0.2, 0.2, 0.9];
        assert_eq!(ranks(&values), [3.0, 0.0, 1.5, 1.5, 4.0]);
        let squared = values.map(|v| v * v);
        let row = compared(&values, &squared, "", "");
        assert!((row.rank_correlation - 1.0).abs() < 1e-12);
        assert_eq!((row.windows, row.within_4), (5, 0.6));
        // The control: the order reversed.
        let reversed = values.map(|v| -v);
        assert!((correlation(&ranks(&values), &ranks(&reversed)) + 1.0).abs() < 1e-12);
        assert_eq!(compared(&[0.1, 0.1], &[0.3, 0.1], "", "").too_low_by_2, 0.5);
    }
}
