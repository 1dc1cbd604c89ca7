//! Built-in scenes: procedural, small, the same on every run.

mod cloth;
mod drape;
mod grid_mesh;
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
mod tests;
