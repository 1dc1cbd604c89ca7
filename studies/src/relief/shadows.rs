//! Shadows of sampled lights by exact rays, blended between them.

use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::SurfacePoint;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;

/// 81 lights, between which shadows are blended.
pub(super) struct SampledShadows {
    lights: Vec<Vector>,
    mesh: DirectionMesh,
}

impl SampledShadows {
    pub(super) fn new() -> Self {
        let set = DirectionSet::ubo2003();
        Self { mesh: DirectionMesh::new(&set).expect("a set that we ship"), lights: set.directions() }
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
