//! The rays of the study.

use brdfc_flat_btf::caster::PeriodicCaster;
use brdfc_flat_btf::triangle_tree::Segment;
use brdfc_formats::direction::Vector;
use glam::Vec3A;

/// Ends of rays are extended by this distance, in tiles, since the lowest triangles are at the end.
const MARGIN: f32 = 1e-4;
/// Number of rays that a thread processes at once.
pub(super) const CHUNK: usize = 1 << 12;

/// A ray in the form for other programs: numbers in single precision, which our caster uses, too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyRay {
    /// Origin, in tiles.
    pub origin: [f32; 3],
    /// Unit vector.
    pub direction: [f32; 3],
    /// Distance at which it has left the heights of the surface, in tiles.
    pub end: f32,
}

impl StudyRay {
    pub(super) fn new(origin: Vector, direction: Vector, [low, high]: [f64; 2]) -> Self {
        let border = if direction[2] > 0.0 { high } else { low };
        let end = (border - origin[2]) / direction[2];
        let single = |v: Vector| v.map(|c| c as f32);
        Self { origin: single(origin), direction: single(direction), end: end as f32 }
    }

    pub(super) fn vectors(&self) -> (Vector, Vector) {
        (self.origin.map(f64::from), self.direction.map(f64::from))
    }

    /// Distance to the first hit; infinite without a hit.
    pub(super) fn segment(&self) -> Segment {
        let [origin, direction] = [self.origin, self.direction].map(Vec3A::from_array);
        Segment { origin, direction, length: self.end + MARGIN }
    }

    pub(super) fn nearest(&self, caster: &PeriodicCaster) -> f32 {
        let (origin, direction) = self.vectors();
        caster.nearest(origin, direction).map_or(f32::INFINITY, |hit| hit.distance as f32)
    }

    pub(super) fn is_blocked(&self, caster: &PeriodicCaster) -> bool {
        let (origin, direction) = self.vectors();
        caster.is_blocked(origin, direction)
    }

    pub(super) fn tiles(&self, caster: &PeriodicCaster) -> usize {
        let (origin, direction) = self.vectors();
        caster.tiles(origin, direction, f64::from(self.nearest(caster)))
    }
}
