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

/// Azimuth of an outgoing direction, 0 to 1 for a turn from the tangent over the bitangent. It is nearly proportional to the
/// angle, without trigonometry: the position on a square around the normal.
pub fn view_azimuth(outgoing: [f32; 3]) -> f32 {
    let [x, y, _] = outgoing;
    let sum = x.abs() + y.abs();
    let along = if sum > 0.0 { x / sum } else { 1.0 };
    0.25 * if y >= 0.0 { 1.0 - along } else { 3.0 + along }
}

/// Unit vector from the normal along the plane of view; above the normal, the tangent.
pub fn plane_of_view(outgoing: [f32; 3]) -> [f32; 2] {
    let [x, y, _] = outgoing;
    let sine = (x * x + y * y).sqrt();
    if sine > 0.0 { [x / sine, y / sine] } else { [1.0, 0.0] }
}

impl LobesPack {
    /// Look-up of a lobe for an outgoing unit vector above the horizon.
    ///
    /// # Panics
    /// Panics if the pack has no lobe of this number.
    pub fn lookup(&self, outgoing: [f32; 3], lobe: usize) -> LobeLookup {
        let header = self.header();
        let lobe = header.lobes[lobe];
        let [nodes, azimuths] = [header.nodes, header.azimuths].map(|count| count as usize);
        let position = view_position(outgoing[2]) * (nodes - 1) as f32;
        let lower = (position as usize).min(nodes - 2);
        let blend = |a: [f32; 4], b: [f32; 4], share: f32| [0, 1, 2, 3].map(|k| a[k] + share * (b[k] - a[k]));
        let at_azimuth = |azimuth: usize| {
            let first = (lobe.row as usize * azimuths + azimuth) * nodes + lower;
            blend(self.weights()[first], self.weights()[first + 1], position - lower as f32)
        };
        let texel = if header.is_isotropic() {
            at_azimuth(0)
        } else {
            let turn = view_azimuth(outgoing) * azimuths as f32;
            let before = (turn as usize).min(azimuths - 1);
            blend(at_azimuth(before), at_azimuth((before + 1) % azimuths), turn - before as f32)
        };
        let [r, g, b, sharpness] = texel;
        let axis = if header.is_isotropic() { plane_of_view(outgoing) } else { [1.0, 0.0] };
        LobeLookup { direction: lobe.direction(outgoing, axis), sharpness, weight: [r, g, b].map(|c| header.scale * c) }
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
    /// Direction of the lobe for an outgoing unit vector, a unit vector of the local frame. The first slope of its tilt is
    /// along `axis`, a unit vector of the surface: [`plane_of_view`] for isotropic materials, the tangent for others.
    pub fn direction(&self, outgoing: [f32; 3], axis: [f32; 2]) -> [f32; 3] {
        let ([x, y, z], [c, s], [along, across]) = (outgoing, axis, self.tilt);
        let length = (along * along + across * across + 1.0).sqrt();
        let h = [(c * along - s * across) / length, (s * along + c * across) / length, 1.0 / length];
        let projection = 2.0 * (h[0] * x + h[1] * y + h[2] * z);
        let mirrored = [projection * h[0] - x, projection * h[1] - y, projection * h[2] - z];
        match self.anchor {
            Anchor::Normal => h,
            Anchor::Mirror => mirrored,
            Anchor::Viewer => [-mirrored[0], -mirrored[1], mirrored[2]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_follow_their_anchor() {
        let outgoing = [0.36, 0.48, 0.8];
        let axis = plane_of_view(outgoing);
        let at = |anchor, tilt| Lobe { anchor, tilt, row: 0 }.direction(outgoing, axis);
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
        // Along the tangent, the same tilt turns the mirror direction elsewhere.
        let lobe = Lobe { anchor: Anchor::Mirror, tilt: [0.1, 0.0], row: 0 };
        near(lobe.direction([0.0, 0.0, 1.0], [1.0, 0.0]), [0.2 / 1.01, 0.0, 0.99 / 1.01]);
        near(lobe.direction([0.0, 0.0, 1.0], [0.0, 1.0]), [0.0, 0.2 / 1.01, 0.99 / 1.01]);
    }

    #[test]
    fn azimuths_cover_a_turn() {
        let steps =
            [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [-0.5, 0.5], [-1.0, 0.0], [-0.5, -0.5], [0.0, -1.0], [0.5, -0.5]];
        for (at, [x, y]) in steps.into_iter().enumerate() {
            assert_eq!(view_azimuth([x, y, 0.3]), at as f32 / 8.0);
        }
        assert_eq!(view_azimuth([0.0, 0.0, 1.0]), 0.0);
        assert!(view_azimuth([1.0, -1e-6, 0.0]) > 0.999);
    }
}
