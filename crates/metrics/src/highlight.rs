//! Light in the highlight. Renderings of a ball hide errors of highlights that are narrower than a pixel, and clipping
//! at white hides errors of brighter highlights.

use super::sampling::AlbedoPairs;
use brdfc_core::words::percent;

/// The highlight is where `f_r` is more than this share of its peak.
const OF_PEAK: f64 = 0.1;
/// Maximum share of the hemisphere's projected solid angle that a highlight covers: renderings show wider highlights.
const WIDEST: f64 = 0.25;
/// Minimum share of the reflected light in a highlight that counts.
const LEAST_LIGHT: f64 = 0.01;
/// Maximum incoming polar angle of measured highlights, degrees: beyond it half of a lobe is below the horizon.
const STEEPEST: f64 = 75.0;

/// Retained light of a highlight, at the incoming direction where the approximation retains least.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct HighlightError {
    /// Incoming polar angle, degrees.
    pub theta: f64,
    /// Share of the reflected light that is in the highlight.
    pub share: f64,
    /// `∫ f cos θo dωo` of the approximation over the reference's highlight, as a ratio to the reference's: 1 if no
    /// light is lost. The sum of the channels.
    pub light: f64,
    /// Largest value of the approximation in the highlight, as a ratio to the reference's.
    pub peak: f64,
    /// Largest value of the reference, 1/sr, mean of the channels.
    pub reference_peak: f64,
}

impl HighlightError {
    /// Retained share of the light, at most 1.
    pub fn retained(&self) -> f64 {
        self.light.min(1.0)
    }

    /// Summary: `37 % of its light at 15°, peak 1/265`.
    pub fn summary(&self) -> String {
        let peak = match self.peak {
            0.0 => "none".to_owned(),
            peak if peak < 0.5 => format!("1/{:.0}", 1.0 / peak),
            peak => percent(peak),
        };
        format!("{} of its light at {:.0}°, peak {peak}", percent(self.light), self.theta)
    }
}

/// The highlight of a reference at one incoming direction.
#[derive(Debug, Clone)]
pub(super) struct Highlight {
    theta: f64,
    /// Samples within.
    inside: Vec<u32>,
    light: f64,
    share: f64,
    peak: f64,
}

impl Highlight {
    /// Finds the highlight in values at the pairs of an albedo; `None` if no highlight counts.
    pub(super) fn of(at: &AlbedoPairs, values: &[[f64; 3]]) -> Option<Self> {
        let grey: Vec<f64> = values.iter().map(mean).collect();
        let peak = grey.iter().copied().fold(0.0, f64::max);
        let inside: Vec<u32> = (0..).zip(&grey).filter(|(_, f)| **f > OF_PEAK * peak).map(|(k, _)| k).collect();
        let covered: f64 = inside.iter().map(|k| at.counted[*k as usize]).sum();
        let light = light(&inside, at, &grey);
        let all: f64 = grey.iter().zip(&at.counted).map(|(f, counted)| f * counted).sum();
        let share = light / all;
        let counts = at.angles[0] <= STEEPEST && covered < WIDEST * std::f64::consts::PI && share > LEAST_LIGHT;
        (peak > 0.0 && counts).then_some(Self { theta: at.angles[0], inside, light, share, peak })
    }

    /// Measures the light that an approximation retains, from its values at the same pairs.
    pub(super) fn retained(&self, at: &AlbedoPairs, values: &[[f64; 3]]) -> HighlightError {
        let grey: Vec<f64> = values.iter().map(mean).collect();
        let found = self.inside.iter().map(|k| grey[*k as usize]).fold(0.0, f64::max);
        HighlightError {
            theta: self.theta,
            share: self.share,
            light: light(&self.inside, at, &grey) / self.light,
            peak: found / self.peak,
            reference_peak: self.peak,
        }
    }
}

fn mean(value: &[f64; 3]) -> f64 {
    value.iter().map(|f| f.max(0.0)).sum::<f64>() / 3.0
}

fn light(inside: &[u32], at: &AlbedoPairs, grey: &[f64]) -> f64 {
    inside.iter().map(|k| grey[*k as usize] * at.counted[*k as usize]).sum()
}

#[cfg(test)]
mod tests {
    use crate::compare::{Comparison, compare};
    use crate::sampling::PairSet;
    use brdfc_core::address::parse_synth;

    fn compared(a: &str, b: &str) -> Comparison {
        let [a, b] = [a, b].map(|address| parse_synth(address).expect("an address"));
        compare(a.as_ref(), b.as_ref(), &PairSet::comparison()).0
    }

    #[test]
    fn materials_without_highlight_lose_none() {
        assert_eq!(compared("synth:lambert", "synth:lambert?kd=0.1").highlight, None);
    }

    #[test]
    fn the_same_material_retains_all() {
        let same = compared("synth:ggx?alpha=0.02", "synth:ggx?alpha=0.02").highlight.expect("a highlight");
        assert_eq!((same.light, same.peak), (1.0, 1.0), "{same:?}");
    }

    /// Pixels of the ball are wider than this highlight, so renderings do not show that it is missing; this measure
    /// does.
    #[test]
    fn a_missing_narrow_highlight_is_detected() {
        let gone = compared("synth:ggx?kd=0.5&alpha=0.003", "synth:lambert?kd=0.5");
        let highlight = gone.highlight.expect("a highlight");
        assert!(highlight.light < 0.05 && highlight.peak < 0.01, "{highlight:?}");
        let half = compared("synth:ggx?kd=0&alpha=0.05", "synth:ggx?kd=0&alpha=0.1").highlight.expect("a highlight");
        assert!(half.peak < 0.35 && half.light < 0.8, "{half:?}");
    }
}
