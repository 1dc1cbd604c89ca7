//! Built-in scenes: procedural, small, the same on every run.

mod bumpy_ball;
mod cloth;
mod drape;
mod grid_mesh;
mod plane;
mod revolve;
mod ribbed_torus;
mod sky;
mod sphere;
mod table;
mod teapot;
mod terrain;
mod vessels;

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
    /// A square on the ground, seen obliquely.
    Plane,
    /// A bottle, a surface of revolution. In this and the following scenes uv counts tiles, which are square and close
    /// all around.
    Bottle,
    /// A vase, a surface of revolution.
    Vase,
    /// A teapot: a body with lid, spout and handle.
    Teapot,
    /// A ball with a smooth half and a half of round bumps. This and the next scene have no point lights: the
    /// environment lights them.
    BumpyBall,
    /// A torus with a smooth and a ribbed half.
    RibbedTorus,
}

impl Builtin {
    /// Names in manifests and on the command line, in the order of the scenes.
    pub const NAMES: [(&'static str, Self); 10] = [
        ("sphere", Self::Sphere),
        ("cloth", Self::Cloth),
        ("table", Self::Table),
        ("terrain", Self::Terrain),
        ("plane", Self::Plane),
        ("bottle", Self::Bottle),
        ("vase", Self::Vase),
        ("teapot", Self::Teapot),
        ("bumpy-ball", Self::BumpyBall),
        ("ribbed-torus", Self::RibbedTorus),
    ];

    /// Name of the scene.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// Number of tiles per unit of uv that shows a relief well.
    pub fn tiles(self) -> u32 {
        match self {
            Self::Plane | Self::Bottle | Self::Vase | Self::Teapot => 4,
            _ => 8,
        }
    }

    /// Names of its parts, in the order of [`Scene::parts`].
    pub fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Sphere => &["sphere"],
            Self::Cloth => &["cloth"],
            Self::Table => &["top", "cloth", "vase", "ball"],
            Self::Terrain => &["terrain"],
            Self::Plane => &["plane"],
            Self::Bottle => &["bottle"],
            Self::Vase => &["vase"],
            Self::Teapot => &["teapot"],
            Self::BumpyBall => &["ball"],
            Self::RibbedTorus => &["torus"],
        }
    }

    /// The scene, with its own camera and lights, or with an environment instead of lights.
    pub fn scene(self) -> Scene {
        match self {
            Self::Sphere => sphere::scene(),
            Self::Cloth => cloth::scene(),
            Self::Table => table::scene(),
            Self::Terrain => terrain::scene(),
            Self::Plane => plane::scene(),
            Self::Bottle => vessels::bottle(),
            Self::Vase => vessels::vase(),
            Self::Teapot => teapot::scene(),
            Self::BumpyBall => bumpy_ball::scene(),
            Self::RibbedTorus => ribbed_torus::scene(),
        }
    }
}

#[cfg(test)]
mod tests;
