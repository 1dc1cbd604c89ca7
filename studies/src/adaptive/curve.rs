//! Error as a function of cost of a method.

use schemars::JsonSchema;
use serde::Serialize;

/// One rendering of a method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Point {
    /// Samples or fetches per surface pixel.
    pub samples: f64,
    /// Seconds to shade, including the bandwidth buffer of adaptive shading.
    pub seconds: f64,
    /// PSNR, at most 99 dB.
    pub psnr: f64,
    /// Mean FLIP on surfaces.
    pub flip: f64,
}

/// Target error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Target {
    /// Minimum PSNR, dB.
    Psnr(f64),
    /// Maximum mean FLIP on surfaces.
    Flip(f64),
}

impl Target {
    /// Error of a rendering in units in which larger is better: dB, or the logarithm of the inverse of FLIP.
    pub(super) fn quality(self, point: &Point) -> f64 {
        match self {
            Self::Psnr(_) => point.psnr,
            Self::Flip(_) => -point.flip.max(1e-9).ln(),
        }
    }

    /// The error of a quality: the inverse of [`Self::quality`].
    pub(super) fn error(self, quality: f64) -> f64 {
        match self {
            Self::Psnr(_) => quality,
            Self::Flip(_) => (-quality).exp(),
        }
    }

    /// The quality of an error.
    pub(super) fn quality_of(self, error: f64) -> f64 {
        match self {
            Self::Psnr(_) => error,
            Self::Flip(_) => -error.ln(),
        }
    }

    fn limit(self) -> f64 {
        match self {
            Self::Psnr(limit) | Self::Flip(limit) => self.quality_of(limit),
        }
    }

    /// Returns true if a rendering meets the target.
    pub fn is_met(self, point: &Point) -> bool {
        self.quality(point) >= self.limit()
    }

    /// The smallest error of the renderings of a method: dB, or FLIP. `None` without renderings.
    pub fn best<'a>(self, points: impl IntoIterator<Item = &'a Point>) -> Option<f64> {
        let best = points.into_iter().max_by(|a, b| self.quality(a).total_cmp(&self.quality(b)))?;
        Some(match self {
            Self::Psnr(_) => best.psnr,
            Self::Flip(_) => best.flip,
        })
    }
}

/// The smallest error of a method within a time, in the unit of the target: that of a rendering, or interpolated to the
/// next one by the logarithm of time. `None` if its first rendering takes longer.
pub fn error_within(curve: &[Point], seconds: f64, target: Target) -> Option<f64> {
    let mut best: Option<f64> = None;
    for (at, point) in curve.iter().enumerate().filter(|(_, point)| point.seconds <= seconds) {
        let quality = target.quality(point);
        let between = |next: &Point| {
            let t = (seconds / point.seconds).ln() / (next.seconds / point.seconds).ln();
            quality + t * (target.quality(next) - quality)
        };
        let next = curve.get(at + 1).filter(|next| next.seconds > seconds).map_or(quality, between);
        best = Some(quality.max(next).max(best.unwrap_or(f64::NEG_INFINITY)));
    }
    best.map(|quality| target.error(quality))
}

/// Cost of a method at a target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Cost {
    /// Samples or fetches per surface pixel.
    pub samples: f64,
    /// Seconds to shade.
    pub seconds: f64,
}

/// Cost of a method for a target: of its first rendering if that meets the target, otherwise interpolated between the
/// first rendering that does and the one before, by the logarithm of cost. `None` if no rendering meets it.
pub fn needed(curve: &[Point], target: Target) -> Option<Cost> {
    let met = curve.iter().position(|point| target.is_met(point))?;
    let b = &curve[met];
    let Some(a) = met.checked_sub(1).map(|before| &curve[before]) else {
        return Some(Cost { samples: b.samples, seconds: b.seconds });
    };
    let (low, high) = (target.quality(a), target.quality(b));
    let t = if high.is_finite() && high > low { (target.limit() - low) / (high - low) } else { 1.0 };
    let between = |x: f64, y: f64| (x.ln() + t * (y / x).ln()).exp();
    Some(Cost { samples: between(a.samples, b.samples), seconds: between(a.seconds, b.seconds) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_interpolated() {
        let point = |n: f64| Point { samples: 2.0 * n, seconds: 0.1 * n, psnr: 10.0 * n.log10(), flip: 0.1 / n.sqrt() };
        let curve: Vec<Point> = [1.0, 10.0, 100.0].map(point).to_vec();
        for (target, n) in
            [(Target::Psnr(15.0), 10f64.powf(1.5)), (Target::Flip(0.02), 25.0), (Target::Psnr(-3.0), 1.0)]
        {
            let found = needed(&curve, target).unwrap();
            assert!((found.samples / (2.0 * n) - 1.0).abs() < 1e-12, "{target:?} {found:?}");
            assert!((found.seconds / (0.1 * n) - 1.0).abs() < 1e-12, "{target:?} {found:?}");
        }
        // Renderings beyond the last one are not extrapolated.
        assert_eq!(needed(&curve, Target::Psnr(20.5)), None);
        assert_eq!(needed(&curve, Target::Flip(0.009)), None);
        assert_eq!(Target::Psnr(0.0).best(&curve), Some(20.0));
        assert_eq!(Target::Flip(0.0).best(&curve), Some(0.01));
        assert_eq!(Target::Psnr(0.0).best(&[]), None);
    }

    #[test]
    fn errors_are_interpolated_by_time() {
        let point = |n: f64| Point { samples: n, seconds: 0.1 * n, psnr: 10.0 * n.log10(), flip: 0.1 / n };
        let curve: Vec<Point> = [1.0, 10.0, 100.0].map(point).to_vec();
        let psnr = |seconds: f64| error_within(&curve, seconds, Target::Psnr(30.0));
        assert!((psnr(0.1 * 10f64.powf(1.5)).unwrap() - 15.0).abs() < 1e-9);
        assert!((error_within(&curve, 0.2, Target::Flip(0.1)).unwrap() - 0.05).abs() < 1e-9);
        // Nothing is extrapolated: a longer time has the error of the last rendering.
        assert_eq!((psnr(0.05), psnr(1e3)), (None, Some(20.0)));
        // A rendering that is worse than a cheaper one does not count.
        let curve = [point(1.0), Point { psnr: -5.0, ..point(2.0) }];
        assert_eq!(error_within(&curve, 1.0, Target::Psnr(30.0)), Some(0.0));
    }

    /// Renderings whose error does not fall in order are taken in order of cost: the first one that meets the target counts.
    #[test]
    fn the_first_rendering_that_meets_a_target_counts() {
        let point = |samples: f64, psnr: f64| Point { samples, seconds: samples, psnr, flip: 0.1 };
        let curve = [point(1.0, 20.0), point(2.0, 31.0), point(4.0, 29.0), point(8.0, 32.0)];
        let found = needed(&curve, Target::Psnr(30.0)).unwrap().samples;
        assert!(1.0 < found && found < 2.0, "{found}");
    }
}
