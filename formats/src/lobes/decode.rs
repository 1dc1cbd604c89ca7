//! Look-ups of the lobes on the CPU.

use super::header::{Anchor, Lobe};
use super::pack::LobesPack;
use crate::environment::EnvironmentDecoder;

/// A look-up in a prefiltered environment. The weighted sum over all look-ups is the reflected radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobeLookup {
    /// Unit vector in the local frame.
    pub direction: [f32; 3],
    /// Sharpness of the look-up.
    pub sharpness: f32,
    /// Weight of each channel.
    pub weight: [f32; 3],
}

/// Position of a view angle among the nodes, 0 at the normal to 1 at the horizon: `sqrt(1 - cos θ)`, which is nearly
/// proportional to the angle.
pub fn view_position(cosine: f32) -> f32 {
    (1.0 - cosine).max(0.0).sqrt().min(1.0)
}

impl LobesPack {
    /// Look-up of a lobe for an outgoing unit vector above the horizon.
    ///
    /// # Panics
    /// Panics if the pack has no lobe of this number.
    pub fn lookup(&self, outgoing: [f32; 3], lobe: usize) -> LobeLookup {
        let lobe = self.header().lobes[lobe];
        let nodes = self.header().nodes as usize;
        let position = view_position(outgoing[2]) * (nodes - 1) as f32;
        let lower = (position as usize).min(nodes - 2);
        let share = position - lower as f32;
        let first = lobe.row as usize * nodes + lower;
        let [low, high] = [self.weights()[first], self.weights()[first + 1]];
        let [r, g, b, sharpness] = [0, 1, 2, 3].map(|k| low[k] + share * (high[k] - low[k]));
        LobeLookup { direction: lobe.direction(outgoing), sharpness, weight: [r, g, b] }
    }

    /// Radiance that a surface reflects from an environment towards an outgoing unit vector above the horizon, W/(m² sr).
    /// `axes` are tangent, bitangent and normal in the frame of the environment.
    pub fn radiance(&self, environment: &EnvironmentDecoder, axes: [[f32; 3]; 3], outgoing: [f32; 3]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for lobe in 0..self.fetches() {
            let LobeLookup { direction, sharpness, weight } = self.lookup(outgoing, lobe);
            let along = [0, 1, 2].map(|k| (0..3).map(|axis| direction[axis] * axes[axis][k]).sum());
            let light = environment.radiance(along, sharpness);
            (0..3).for_each(|k| sum[k] += weight[k] * light[k]);
        }
        sum
    }
}

impl Lobe {
    /// Direction of the lobe for an outgoing unit vector, a unit vector of the local frame. The plane of view contains
    /// the normal and the outgoing direction; above the normal it contains the tangent.
    pub fn direction(&self, outgoing: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = outgoing;
        let [along, across] = self.tilt;
        let sine = (x * x + y * y).sqrt();
        let (cos_azimuth, sin_azimuth) = if sine > 0.0 { (x / sine, y / sine) } else { (1.0, 0.0) };
        let length = (along * along + across * across + 1.0).sqrt();
        let h = [along / length, across / length, 1.0 / length];
        let projection = 2.0 * (h[0] * sine + h[2] * z);
        let mirrored = [projection * h[0] - sine, projection * h[1], projection * h[2] - z];
        let [u, v, w] = match self.anchor {
            Anchor::Normal => h,
            Anchor::Mirror => mirrored,
            Anchor::Viewer => [-mirrored[0], -mirrored[1], mirrored[2]],
        };
        [u * cos_azimuth - v * sin_azimuth, u * sin_azimuth + v * cos_azimuth, w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_follow_their_anchor() {
        let outgoing = [0.36, 0.48, 0.8];
        let at = |anchor, tilt| Lobe { anchor, tilt, row: 0 }.direction(outgoing);
        let near = |found: [f32; 3], expected: [f32; 3]| {
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-6), "{found:?} {expected:?}");
        };
        near(at(Anchor::Normal, [0.0, 0.0]), [0.0, 0.0, 1.0]);
        near(at(Anchor::Mirror, [0.0, 0.0]), [-0.36, -0.48, 0.8]);
        near(at(Anchor::Viewer, [0.0, 0.0]), outgoing);
        // A half vector towards the viewer turns the mirror direction into the direction to the viewer.
        near(at(Anchor::Mirror, [0.6 / 0.8, 0.0]), outgoing);
        // A pair is symmetric about the plane of view.
        let [left, right] = [0.3, -0.3].map(|across| at(Anchor::Mirror, [0.1, across]));
        let side = |d: [f32; 3]| d[1] * 0.6 - d[0] * 0.8;
        assert!((side(left) + side(right)).abs() < 1e-6 && side(left).abs() > 0.1);
        assert!((left[2] - right[2]).abs() < 1e-6);
        for d in [left, right] {
            assert!((d.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }
}
