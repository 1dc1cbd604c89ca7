//! Candidates for lobes: directions relative to an anchor, with a sharpness.

use super::reflection::{Frame, Slopes};
use brdfc_formats::direction::Vector;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader};
use brdfc_formats::lobes::{Anchor, Lobe, MAX_SHARPNESS, plane_of_view};

/// Cosine below which the sharpness of lobes no longer changes.
const LEAST_COSINE: f64 = 0.1;

/// Places of the lobes of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// One lobe in the plane of view.
    InPlane,
    /// Two lobes on either side of the plane of view.
    Pair,
    /// One lobe at slopes along tangent and bitangent, for anisotropic materials.
    OnSurface,
}

/// A lobe, or a pair of lobes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Direction that it follows.
    pub anchor: Anchor,
    /// Place of its lobes.
    pub place: Place,
    /// Slope along the plane of view, or the tangent.
    pub along: f64,
    /// Slope across the plane of view, or along the bitangent.
    pub across: f64,
    /// Sharpness of its look-ups at the normal.
    pub sharpness: f64,
    /// Change of the sharpness per octave of the view's cosine: highlights become narrower across the plane of view
    /// towards the horizon.
    pub grazing: f64,
}

impl Candidate {
    /// The irradiance at the normal.
    pub fn irradiance(place: Place) -> Self {
        Self { anchor: Anchor::Normal, place, along: 0.0, across: 0.0, sharpness: 0.0, grazing: 0.0 }
    }

    /// Number of look-ups.
    pub fn fetches(&self) -> usize {
        if self.place == Place::Pair { 2 } else { 1 }
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
        let axis = if self.place == Place::OnSurface { [1.0, 0.0] } else { plane_of_view(outgoing) };
        let mut sum = [0.0; 3];
        for lobe in self.lobes(0) {
            let light = environment.radiance(frame.world(lobe.direction(outgoing, axis)), sharpness);
            (0..3).for_each(|k| sum[k] += light[k]);
        }
        sum
    }

    /// Candidates for an isotropic material whose highlight has this standard deviation, radians, up to the sharpest level
    /// of the environments.
    pub fn isotropic(width: f64, sharpest: u32) -> Vec<Self> {
        let mut all = vec![Self::irradiance(Place::InPlane)];
        // A lobe is a sum of Gaussians that are no more than three times as narrow.
        let last = EnvironmentHeader::sharpness(0.3 * width).ceil().min(f64::from(sharpest)) as u32;
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
                let single =
                    Self { anchor: Anchor::Mirror, along: angle.tan(), sharpness, ..Self::irradiance(Place::InPlane) };
                all.push(single);
                let spreads = [0.6, 1.2, 2.0].map(|spread| spread * deviation);
                let pair = |spread: f64| Self { place: Place::Pair, across: spread.tan(), ..single };
                all.extend(spreads.into_iter().filter(|spread| shift.abs() <= 4 && *spread < 0.6).map(pair));
            }
            if deviation > 0.12 {
                for along in [-0.9, -0.45, 0.0, 0.45, 0.9] {
                    let single = Self { along, sharpness, ..Self::irradiance(Place::InPlane) };
                    all.extend([single, Self { place: Place::Pair, across: 0.5, ..single }]);
                }
            }
            all.push(Self { anchor: Anchor::Viewer, sharpness, ..Self::irradiance(Place::InPlane) });
        }
        all
    }

    /// Candidates for an anisotropic material whose half vectors have these slopes, up to the sharpest level of the
    /// environments: a grid along the axes of the slopes, out to twice their deviations.
    pub fn anisotropic(slopes: &Slopes, sharpest: u32) -> Vec<Self> {
        let mut all = vec![Self::irradiance(Place::OnSurface)];
        // Directions turn twice as far as half vectors.
        let last = EnvironmentHeader::sharpness(1.2 * slopes.deviations[1]).ceil().min(f64::from(sharpest)) as u32;
        let (sin, cos) = slopes.angle.sin_cos();
        for step in 1..=last {
            let sharpness = f64::from(step);
            let deviation = EnvironmentHeader::deviation(sharpness);
            let anchored = |anchor: Anchor| Self { anchor, sharpness, ..Self::irradiance(Place::OnSurface) };
            let [columns, rows] = slopes.deviations.map(|most| (4.0 * most / deviation).ceil().min(16.0) as i32);
            for (column, row) in (-columns..=columns).flat_map(|column| (-rows..=rows).map(move |row| (column, row))) {
                let [u, v] = [column, row].map(|step| 0.5 * deviation * f64::from(step));
                let (along, across) = (cos * u - sin * v, sin * u + cos * v);
                all.push(Self { along, across, ..anchored(Anchor::Mirror) });
            }
            if deviation > 0.12 {
                let tilts = [-0.6, 0.0, 0.6];
                let tilts = tilts.into_iter().flat_map(|along| tilts.map(|across| (along, across)));
                all.extend(tilts.map(|(along, across)| Self { along, across, ..anchored(Anchor::Normal) }));
            }
            all.push(anchored(Anchor::Viewer));
        }
        all
    }

    /// Neighbours in the space of directions and sharpnesses, at distances that are a share of its width.
    pub fn neighbours(&self, share: f64, sharpest: u32) -> Vec<Self> {
        if *self == Self::irradiance(self.place) {
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
            if self.place != Place::InPlane {
                let across = self.across + step * tilt;
                let across = if self.place == Place::Pair { across.max(1e-4) } else { across };
                all.push(Self { across, ..*self });
                all.push(Self { across, sharpness: sharper(step), ..*self });
            }
        }
        // Slopes within the range of the format.
        all.retain(|one| one.along.abs() < 8.0 && one.across.abs() < 8.0);
        all
    }
}
