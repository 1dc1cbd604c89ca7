//! Quantiles and rank correlation of predictions and references.

use schemars::JsonSchema;
use serde::Serialize;

/// Quantiles of the ratios.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Quantiles {
    /// 5 % quantile.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// 95 % quantile.
    pub high: f64,
}

impl Quantiles {
    /// Quantiles of sorted values; 0 without any.
    pub(super) fn of(sorted: &[f64]) -> Self {
        let last = sorted.len().saturating_sub(1) as f64;
        let quantile = |q: f64| sorted.get((q * last).round() as usize).copied().unwrap_or(0.0);
        Self { low: quantile(0.05), median: quantile(0.5), high: quantile(0.95) }
    }
}

/// Ranks, averaged over equal values.
pub(super) fn ranks(values: &[f32]) -> Vec<f64> {
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

/// Pearson's correlation of two series of the same length.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
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
