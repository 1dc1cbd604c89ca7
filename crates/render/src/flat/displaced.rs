//! The reference for a flat BTF on any surface: the surface displaced along its normals, ray cast.

use super::reflected;
use super::shell::{Shell, ShellHit};
use crate::footprint::from_behind;
use crate::sample_means::sample_means;
use crate::scene::{Frame, Scene};
use crate::shading_point::{ShadingPoint, bent};
use crate::trace::Caster;
use crate::vector::add_scaled;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::{Appearance, SurfacePoint};
use brdfc_formats::direction::{Vector, dot, normalize, rotate_to_normal};
use brdfc_metrics::image::LinearImage;

/// Distance from the surface at which rays of light start, in tiles.
const RISE: f64 = 2e-5;

/// Draws a scene displaced by the repetition of `model`, `repeat` tiles per unit of uv, under direct light with the
/// shadows of the relief. Outlines are those of the displaced surface.
///
/// Heights are in units of a tile's side at each vertex. Shadows end where a ray leaves the space between the lowest
/// and the highest point of the relief: those of an object on itself are left to the engine. Where a surface is seen
/// from behind, it is drawn as a BTF is defined: as a plane with the view and the light of the point.
pub(super) fn reference_object(
    scene: &Scene,
    frame: Frame,
    model: &MesoModel,
    appearance: &Appearance,
    repeat: u32,
) -> LinearImage {
    let shells: Vec<Shell> = scene.parts.iter().map(|part| Shell::new(&part.mesh, &model.caster, repeat)).collect();
    let surfaces = Caster::new(scene);
    let eye = scene.camera.eye;
    sample_means(scene, frame, |pixel, sample| {
        let [x, y] = frame.sample_position(pixel, sample);
        let ray = normalize(scene.camera.ray(frame, x, y));
        let hits = shells.iter().filter_map(|shell| Some((shell.nearest(eye, ray)?, shell)));
        let nearest = hits.min_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
        let view = ray.map(|c| -c);
        if let Some((hit, shell)) = nearest {
            let point = Displaced::new(shell, &hit, model, add_scaled(eye, hit.distance, ray), view);
            if dot(point.geometric_normal, view) > 0.0 {
                return Some(point.radiance(scene, shell, appearance, view));
            }
        }
        let hit = &surfaces.nearest(eye, ray)?;
        let part = &scene.parts[hit.part as usize];
        if !from_behind(&part.mesh, hit.triangle, view) {
            // Between the outlines of the relief and of the surface below it.
            return None;
        }
        let point = ShadingPoint::without_bump(part, hit, eye);
        let seen = model.point(&model.seen(point.uv.map(|c| c * f64::from(repeat)), point.outgoing).hit);
        let seen = SurfacePoint { normal: bent(seen.normal, point.outgoing), ..seen };
        Some(reflected(scene, point.position, |light| {
            let light = point.local(light);
            let reaches = light[2] > 0.0 && model.caster.sees_sky(&seen, light);
            if reaches { appearance.relative_radiance(&seen, point.outgoing, light) } else { [0.0; 3] }
        }))
    })
}

/// A point of the displaced surface.
struct Displaced {
    position: Vector,
    /// Unit normal of its triangle, world space.
    geometric_normal: Vector,
    /// Tangent, bitangent and normal of the macro surface.
    frame: [Vector; 3],
    /// The point of the tile, with its shading normal in `frame`.
    point: SurfacePoint,
    /// Side of a tile.
    side: f64,
}

impl Displaced {
    /// The point at a world `position`, for an eye in the direction `view`.
    fn new(shell: &Shell, hit: &ShellHit, model: &MesoModel, position: Vector, view: Vector) -> Self {
        let mut point = model.point(&hit.on_tile);
        let (frame, side) = shell.frame(hit);
        let local = |v: Vector| frame.map(|axis| dot(axis, v));
        let gradients = shell.gradients(hit);
        let world =
            |n: Vector| normalize([0, 1, 2].map(|k| (0..3).map(|axis| n[axis] * gradients[axis][k]).sum::<f64>()));
        let geometric_normal = world(point.geometric_normal);
        // A cell is flat. Its normal is turned to the interpolated one, as shading normals of smooth meshes are.
        let normal = normalize(rotate_to_normal(local(normalize(gradients[2])), local(world(point.normal))));
        // At outlines, interpolated normals turn away from the view, where a BRDF has no value: they are bent as those of
        // all meshes are. The decoder takes such a view for one at the horizon.
        point.normal = bent(normal, local(view));
        Self { position, geometric_normal, frame, point, side }
    }

    fn radiance(&self, scene: &Scene, shell: &Shell, appearance: &Appearance, view: Vector) -> Vector {
        let local = |v: Vector| self.frame.map(|axis| dot(axis, v));
        let origin = add_scaled(self.position, RISE * self.side, self.geometric_normal);
        reflected(scene, self.position, |light| {
            if dot(self.geometric_normal, light) <= 0.0 || shell.is_blocked(origin, light) {
                return [0.0; 3];
            }
            appearance.relative_radiance(&self.point, local(view), local(light))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flat::reference;
    use crate::scene::{Camera, PointLight};
    use crate::scenes::Builtin;
    use crate::testing::{plain_scene, ring};
    use brdfc_core::address::parse_synth;
    use brdfc_flat_btf::mesh::{PeriodicMesh, VertexMaterial};

    fn relief(height: impl Fn(f64, f64) -> f64) -> MesoModel {
        const N: usize = 24;
        let at = |k: usize| [(k % N) as f64 / N as f64, (k / N) as f64 / N as f64];
        let points = (0..N * N).map(at).map(|[x, y]| [x, y, height(x, y)]).collect();
        let mesh = PeriodicMesh::from_grid(N, N, points, vec![VertexMaterial::default(); N * N]);
        MesoModel::new(mesh, 0, &()).unwrap()
    }

    fn matte() -> Appearance {
        Appearance { sources: vec![parse_synth("synth:lambert?kd=0.6").unwrap()], ..Appearance::default() }
    }

    /// Except where rays enter at its border. The control: another height.
    #[test]
    fn on_a_plane_both_references_are_one() {
        let (scene, frame) = (Builtin::Plane.scene(), Frame { width: 64, height: 48, samples: 1 });
        let waves =
            |by: f64| relief(move |x, y| by * (std::f64::consts::TAU * x).sin() * (std::f64::consts::TAU * y).cos());
        let exact = reference(&scene, frame, &waves(0.1), &matte(), 3);
        let same = |by: f64| {
            let found = reference_object(&scene, frame, &waves(by), &matte(), 3);
            let pairs = found.pixels.iter().zip(&exact.pixels);
            pairs.filter(|(a, b)| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-3)).count()
        };
        let covered = exact.coverage.iter().filter(|share| **share > 0.0).count();
        let background = exact.coverage.len() - covered;
        let [right, wrong] = [0.1, 0.05].map(same);
        assert!(
            right > background + covered * 93 / 100 && wrong < background + covered / 2,
            "{right} {wrong} {covered}"
        );
    }

    /// A relief of the same height everywhere is a wider cylinder, as bright as one.
    #[test]
    fn a_raised_cylinder_is_a_wider_one() {
        let camera = Camera { eye: [0.0, 0.0, 9.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 20.0 };
        let frame = Frame { width: 90, height: 40, samples: 1 };
        let light = PointLight { position: [3.0, 1.0, 30.0], intensity: [3000.0; 3] };
        let drawn = |radius: f64, height: f64| {
            let scene = crate::scene::Scene { lights: vec![light], ..plain_scene(ring(radius), camera) };
            reference_object(&scene, frame, &relief(|_, _| height), &matte(), 4)
        };
        let side = std::f64::consts::TAU / 4.0;
        let (raised, wider) = (drawn(1.0, 0.1), drawn(1.0 + 0.1 * side, 0.0));
        let differ = |a: &LinearImage, b: &LinearImage| {
            let pairs = a.pixels.iter().zip(&b.pixels);
            pairs.filter(|(a, b)| (a[0] - b[0]).abs() > 0.02 * b[0].max(0.1)).count()
        };
        let seen = wider.coverage.iter().filter(|share| **share > 0.0).count();
        let (same, other) = (differ(&raised, &wider), differ(&drawn(1.0, 0.0), &wider));
        assert!(seen > 400 && same < seen / 15 && other > 3 * same, "{seen} {same} {other}");
    }
}
