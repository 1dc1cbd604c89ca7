//! Shadows of sampled lights, blended between them.

use brdfc_flat_btf::light_field::visible;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::SurfacePoint;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;

/// The texels of the flat BTF that each of 81 lights reaches.
pub(super) struct SampledShadows {
    lights: Vec<Vector>,
    mesh: DirectionMesh,
    /// Texels per side.
    size: usize,
    /// For each light, true for the texels that it reaches.
    reached: Vec<Vec<bool>>,
}

impl SampledShadows {
    pub(super) fn new(model: &MesoModel, size: usize) -> Self {
        let set = DirectionSet::ubo2003();
        let (mesh, lights) = (DirectionMesh::new(&set).expect("a set that we ship"), set.directions());
        let texels = model.texels(size);
        let reached = lights.iter().map(|light| visible(&texels, &model.caster, *light)).collect();
        Self { lights, mesh, size, reached }
    }

    /// Bytes on a GPU: one for each texel and light, and a third for mipmaps.
    pub(super) fn bytes(&self) -> u64 {
        (self.lights.len() * self.size * self.size * 4 / 3) as u64
    }

    /// Fraction of a light that reaches filtered texels at parameters.
    pub(super) fn blended(&self, parameters: [f32; 2], light: Vector) -> f32 {
        let size = self.size as f32;
        let place = parameters.map(|c| c.rem_euclid(1.0) * size - 0.5);
        let first = place.map(f32::floor);
        let share = [place[0] - first[0], place[1] - first[1]];
        self.sum(light, |sample| {
            let texel = |x: usize, y: usize| {
                let [i, j] = [first[0] as i64 + x as i64, first[1] as i64 + y as i64];
                let [i, j] = [i, j].map(|c| c.rem_euclid(self.size as i64) as usize);
                f32::from(self.reached[sample][j * self.size + i])
            };
            let row = |y| (1.0 - share[0]) * texel(0, y) + share[0] * texel(1, y);
            (1.0 - share[1]) * row(0) + share[1] * row(1)
        })
    }

    /// Fraction of a light that reaches a point, if lights in between are blended: no texels, however fine, do better.
    pub(super) fn at(&self, model: &MesoModel, point: &SurfacePoint, light: Vector) -> f32 {
        self.sum(light, |sample| f32::from(model.caster.sees_sky(point, self.lights[sample])))
    }

    /// Weighted sum over the sampled lights around a light.
    fn sum(&self, light: Vector, of: impl Fn(usize) -> f32) -> f32 {
        let (indices, weights) = self.mesh.weights(light.map(|c| c as f32));
        let each = indices.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        each.map(|(index, weight)| weight * of(*index as usize)).sum()
    }
}
