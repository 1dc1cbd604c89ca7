//! View-dependent coherency: variation of the appearance of texels with the view (section 4.3 and table 2 of Hadim et
//! al. 2009).

use super::rows::Spread;
use brdfc_metrics::lab::{distance_squared, lab};

/// Running variance over views, in L*a*b*, of the values of texels under one light (Welford 1962).
#[derive(Debug, Clone)]
pub struct ViewVariance {
    means: Vec<[f32; 3]>,
    /// Sums of squared distances from the mean.
    squares: Vec<f32>,
    counts: Vec<u16>,
}

impl ViewVariance {
    /// Variance of `texels` texels.
    pub fn new(texels: usize) -> Self {
        Self { means: vec![[0.0; 3]; texels], squares: vec![0.0; texels], counts: vec![0; texels] }
    }

    /// Adds the values of one more view; with a mask only those of its texels.
    pub fn add(&mut self, image: &[[f32; 3]], mask: Option<&[bool]>) {
        for (texel, value) in image.iter().enumerate() {
            if mask.is_some_and(|mask| !mask[texel]) {
                continue;
            }
            let value = lab(*value);
            self.counts[texel] += 1;
            let (mean, count) = (&mut self.means[texel], f32::from(self.counts[texel]));
            let before = distance_squared(value, *mean);
            (0..3).for_each(|k| mean[k] += (value[k] - mean[k]) / count);
            self.squares[texel] += before * (count - 1.0) / count;
        }
    }

    /// Variance of each texel; `None` for texels in fewer than two views.
    pub fn variances(&self) -> impl Iterator<Item = Option<f32>> + '_ {
        self.squares.iter().zip(&self.counts).map(|(square, count)| (*count > 1).then(|| square / f32::from(*count)))
    }
}

/// Variance over the views of each texel, mean over lights; `None` for texels that are visible in fewer than two views.
pub(super) type TexelVariances = Vec<Option<f64>>;

/// Means over lights.
pub(super) fn texel_variances<'a>(lights: impl Iterator<Item = &'a ViewVariance>) -> TexelVariances {
    let mut sums: Vec<(f64, u32)> = Vec::new();
    for light in lights {
        for (texel, variance) in light.variances().enumerate() {
            if sums.len() <= texel {
                sums.push((0.0, 0));
            }
            if let Some(variance) = variance {
                sums[texel].0 += f64::from(variance);
                sums[texel].1 += 1;
            }
        }
    }
    sums.into_iter().map(|(sum, n)| (n > 0).then(|| sum / f64::from(n))).collect()
}

/// Mean and maximum over texels.
pub(super) fn spread(variances: &TexelVariances) -> Spread {
    let count = variances.iter().flatten().count();
    Spread {
        mean: variances.iter().flatten().sum::<f64>() / count.max(1) as f64,
        max: variances.iter().flatten().copied().fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_the_added_views() {
        let views = [[0.1f32, 0.4, 0.7], [0.3, 0.2, 0.1], [0.9, 0.8, 0.9], [0.5, 0.5, 0.5]];
        let mut variance = ViewVariance::new(2);
        for (k, value) in views.iter().enumerate() {
            variance.add(&[*value, *value], Some(&[true, k == 2]));
        }
        let labs = views.map(lab);
        let mean = [0, 1, 2].map(|k| labs.iter().map(|l| l[k]).sum::<f32>() / 4.0);
        let expected = labs.iter().map(|l| distance_squared(*l, mean)).sum::<f32>() / 4.0;
        let found: Vec<_> = variance.variances().collect();
        assert!((found[0].unwrap() - expected).abs() < 1e-3 * expected && found[1].is_none(), "{found:?} {expected}");
    }

    #[test]
    fn constant_values_have_no_variance() {
        let mut variance = ViewVariance::new(1);
        (0..81).for_each(|_| variance.add(&[[0.3, 0.2, 0.6]], None));
        assert!(variance.variances().all(|v| v.unwrap() < 1e-9));
    }
}
