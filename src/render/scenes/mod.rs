//! Built-in scenes: procedural, small, the same on every run.

mod cloth;
mod drape;
mod grid_mesh;
mod noise;
mod sky;
mod sphere;
mod table;
mod terrain;

use super::scene::Scene;

/// A built-in scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Builtin {
    /// A ball.
    Sphere,
    /// A draped cloth of about 11 thousand triangles; its tangents follow the weave.
    Cloth,
    /// A still life of four materials: a bumped table top, a cloth, a vase, and a ball that mirrors its environment.
    Table,
    /// A landscape of 45 thousand triangles, seen at a grazing angle.
    Terrain,
}

impl Builtin {
    /// The names that manifests and the command line use.
    pub const NAMES: [(&'static str, Self); 4] =
        [("sphere", Self::Sphere), ("cloth", Self::Cloth), ("table", Self::Table), ("terrain", Self::Terrain)];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Cloth => "cloth",
            Self::Table => "table",
            Self::Terrain => "terrain",
        }
    }

    /// Names of its parts, in the order of [`Scene::parts`].
    pub fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Sphere => &["sphere"],
            Self::Cloth => &["cloth"],
            Self::Table => &["top", "cloth", "vase", "ball"],
            Self::Terrain => &["terrain"],
        }
    }

    /// The scene, with its own camera and lights.
    pub fn scene(self) -> Scene {
        match self {
            Self::Sphere => sphere::scene(),
            Self::Cloth => cloth::scene(),
            Self::Table => table::scene(),
            Self::Terrain => terrain::scene(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::scene::Frame;
    use crate::render::surface_point::SurfacePoint;
    use crate::render::trace::trace;
    use crate::render::vector::{cross, double, subtract};
    use brdfc_formats::direction::dot;

    #[test]
    fn meshes_are_sound() {
        for (name, builtin) in Builtin::NAMES {
            assert_eq!(builtin.name(), name);
            let scene = builtin.scene();
            let parts: Vec<&str> = scene.parts.iter().map(|part| part.name).collect();
            assert_eq!(parts, builtin.parts());
            assert!(scene.camera.is_valid() && !scene.lights.is_empty());
            for part in &scene.parts {
                for vertex in &part.mesh.vertices {
                    let (n, t) = (double(vertex.normal), double(vertex.tangent));
                    assert!((dot(n, n) - 1.0).abs() < 1e-5 && (dot(t, t) - 1.0).abs() < 1e-5, "{name}: {vertex:?}");
                    assert!(dot(n, t).abs() < 1e-5, "{name}: {vertex:?}");
                    assert!(vertex.position.iter().chain(&vertex.uv).all(|c| c.is_finite()));
                }
                for triangle in &part.mesh.triangles {
                    let corners = triangle.map(|corner| part.mesh.vertices[corner as usize]);
                    let [a, b, c] = corners.map(|corner| double(corner.position));
                    let face = cross(subtract(b, a), subtract(c, a));
                    if dot(face, face).sqrt() > 1e-9 {
                        assert!(corners.iter().all(|v| dot(face, double(v.normal)) > 0.0), "{name}: {corners:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn triangles_are_as_many_as_the_paper_has() {
        let count =
            |builtin: Builtin| builtin.scene().parts.iter().map(|part| part.mesh.triangles.len()).sum::<usize>();
        assert_eq!(count(Builtin::Cloth), 10_952);
        assert_eq!(count(Builtin::Terrain), 45_000);
    }

    /// With the usual scale of distances, what is nearer than 6.66 is drawn in full detail.
    #[test]
    fn objects_are_near_enough_for_full_detail() {
        let frame = Frame { width: 64, height: 64, samples: 1 };
        for builtin in [Builtin::Sphere, Builtin::Cloth, Builtin::Table] {
            let scene = builtin.scene();
            let hits = trace(&scene, frame);
            assert!(hits.0.iter().flatten().count() > 64 * 64 / 4, "{builtin:?} fills the picture");
            for hit in hits.0.iter().flatten() {
                let point = SurfacePoint::new(&scene.parts[hit.part as usize], hit, scene.camera.eye);
                assert!(point.distance < 6.6, "{builtin:?}: {}", point.distance);
            }
        }
    }

    #[test]
    fn the_terrain_spans_all_levels_of_detail() {
        let scene = Builtin::Terrain.scene();
        let hits = trace(&scene, Frame { width: 64, height: 36, samples: 1 });
        let distance = |hit| SurfacePoint::new(&scene.parts[0], hit, scene.camera.eye).distance;
        let distances: Vec<f64> = hits.0.iter().flatten().map(distance).collect();
        assert!(distances.iter().any(|d| *d < 20.0) && distances.iter().any(|d| *d > 180.0));
    }

    #[test]
    fn every_part_is_seen() {
        for (name, builtin) in Builtin::NAMES {
            let hits = trace(&builtin.scene(), Frame { width: 96, height: 96, samples: 1 });
            for part in 0..builtin.parts().len() {
                let seen = hits.0.iter().flatten().filter(|hit| hit.part as usize == part).count();
                assert!(seen > 96, "{name}: {} covers {seen} pixels", builtin.parts()[part]);
            }
        }
    }
}
