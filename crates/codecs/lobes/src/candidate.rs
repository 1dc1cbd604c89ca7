//! Candidates for lobes: directions relative to an anchor, with a sharpness.

use super::reflection::{Frame, sharpness};
use brdfc_formats::direction::Vector;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use brdfc_formats::lobes::{Anchor, Lobe, MAX_SHARPNESS};

/// Cosine below which the sharpness of lobes no longer changes.
const LEAST_COSINE: f64 = 0.1;

/// A lobe, or a pair of lobes on either side of the plane of view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Direction that it follows.
    pub anchor: Anchor,
    /// Slope along the plane of view.
    pub along: f64,
    /// Slope across it; 0 for a single lobe in the plane.
    pub across: f64,
    /// Sharpness of its look-ups at the normal.
    pub sharpness: f64,
    /// Change of the sharpness per octave of the view's cosine: highlights become narrower across the plane of view
    /// towards the horizon.
    pub grazing: f64,
}

impl Candidate {
    /// The irradiance at the normal.
    pub const IRRADIANCE: Self = Self { anchor: Anchor::Normal, along: 0.0, across: 0.0, sharpness: 0.0, grazing: 0.0 };

    /// Number of look-ups.
    pub fn fetches(&self) -> usize {
        if self.across > 0.0 { 2 } else { 1 }
    }

    /// Its lobes, with weights in a row.
    pub fn lobes(&self, row: u32) -> impl Iterator<Item = Lobe> + use<> {
        let (along, across, anchor) = (self.along as f32, self.across as f32, self.anchor);
        let sides = [across, -across].into_iter().take(self.fetches());
        sides.map(move |across| Lobe { anchor, tilt: [along, across], row })
    }

    /// Sharpness of its look-ups for a cosine of the view.
    pub fn sharpness_at(&self, cosine: f64) -> f32 {
        let octaves = -cosine.max(LEAST_COSINE).log2();
        (self.sharpness + self.grazing * octaves).clamp(0.0, f64::from(MAX_SHARPNESS)) as f32
    }

    /// Sum of its look-ups for an outgoing unit vector.
    pub fn radiance(&self, environment: &EnvironmentDecoder, frame: &Frame, outgoing: Vector) -> [f32; 3] {
        let sharpness = self.sharpness_at(outgoing[2]);
        let outgoing = outgoing.map(|c| c as f32);
        let mut sum = [0.0; 3];
        for lobe in self.lobes(0) {
            let light = environment.radiance(frame.world(lobe.direction(outgoing)), sharpness);
            (0..3).for_each(|k| sum[k] += light[k]);
        }
        sum
    }

    /// Candidates for a material whose highlight has this standard deviation, radians, up to the sharpest level of the
    /// environments.
    pub fn all(width: f64, sharpest: u32) -> Vec<Self> {
        let mut all = vec![Self::IRRADIANCE];
        // A lobe is a sum of Gaussians that are no more than three times as narrow.
        let last = f64::from(sharpness(0.3 * width)).ceil().min(f64::from(sharpest)) as u32;
        for step in 1..=last {
            let sharpness = f64::from(step);
            let deviation = EnvironmentHeader::deviation(sharpness);
            // Directions turn twice as far as half vectors.
            let tilt = 0.5 * deviation;
            for shift in -6i32..=6 {
                let angle = f64::from(shift) * tilt;
                if angle.abs() > 0.8 {
                    continue;
                }
                let single = Self { anchor: Anchor::Mirror, along: angle.tan(), across: 0.0, sharpness, grazing: 0.0 };
                all.push(single);
                let spreads = [0.6, 1.2, 2.0].map(|spread| spread * deviation);
                let pair = |spread: f64| Self { across: spread.tan(), ..single };
                all.extend(spreads.into_iter().filter(|spread| shift.abs() <= 4 && *spread < 0.6).map(pair));
            }
            if deviation > 0.12 {
                for (shift, across) in (-2i32..=2).flat_map(|shift| [0.0, 0.5].map(|across| (shift, across))) {
                    all.push(Self {
                        anchor: Anchor::Normal,
                        along: 0.45 * f64::from(shift),
                        across,
                        sharpness,
                        grazing: 0.0,
                    });
                }
            }
            all.push(Self { anchor: Anchor::Viewer, along: 0.0, across: 0.0, sharpness, grazing: 0.0 });
        }
        all
    }

    /// Neighbours in the space of directions and sharpnesses, at distances that are a share of its width.
    pub fn neighbours(&self, share: f64, sharpest: u32) -> Vec<Self> {
        if *self == Self::IRRADIANCE {
            return Vec::new();
        }
        let deviation = EnvironmentHeader::deviation(self.sharpness);
        let tilt = share * if self.anchor == Anchor::Normal { deviation } else { 0.5 * deviation };
        let sharper = |step: f64| (self.sharpness + 1.2 * share * step).clamp(0.0, f64::from(sharpest));
        let mut all = Vec::new();
        for step in [-0.6, -0.25, 0.25, 0.6] {
            all.push(Self { along: self.along + step * tilt, ..*self });
            all.push(Self { sharpness: sharper(step), ..*self });
            all.push(Self { grazing: (self.grazing + share * step).clamp(-1.0, 1.0), ..*self });
            if self.across > 0.0 {
                let across = (self.across + step * tilt).max(1e-4);
                all.push(Self { across, ..*self });
                all.push(Self { across, sharpness: sharper(step), ..*self });
            }
        }
        // Slopes within the range of the format.
        all.retain(|one| one.along.abs() < 8.0 && one.across < 8.0);
        all
    }
}
