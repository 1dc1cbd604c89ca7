//! Scenes: meshes, camera, lights. Both renderers, shader and CPU, read the same values.
//!
//! World space is right-handed, y up, lengths in the scene's own unit.

use brdfc_formats::direction::Vector;

/// A corner of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position in world space.
    pub position: [f32; 3],
    /// Unit shading normal.
    pub normal: [f32; 3],
    /// Unit tangent, at right angles to the normal: the x axis of the BRDF's frame. Bitangent = normal x tangent.
    pub tangent: [f32; 3],
    /// Coordinates for bump maps and tiles.
    pub uv: [f32; 2],
    /// Distance along the normal by which it was raised above its surface, in the scene's unit: 0 except where a relief
    /// covers it.
    pub raised_by: f32,
    /// Straight distance from the open border of its surface, where a relief covers it, otherwise 0; in the scene's unit. At
    /// most as far as rays through the relief reach.
    pub border: f32,
}

/// Triangles with shared corners. Counter-clockwise from the front.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners, which triangles share.
    pub vertices: Vec<Vertex>,
    /// Indices of three corners each.
    pub triangles: Vec<[u32; 3]>,
}

/// Properties of a surface besides its BRDF.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Heights that bend the normal.
    pub bump: Option<HeightMap>,
    /// Weight of the mirrored environment at normal incidence, 0 to 1; rises towards grazing angles (Schlick 1994).
    /// The BRDF's share falls accordingly. 0: no environment.
    pub mirror: f32,
}

/// A periodic map of heights over `uv`; one repetition per unit of `uv`.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// Texels per side.
    pub size: usize,
    /// Heights, in the unit of positions per unit of `uv`: slope = d height / d uv. Row by row, `v` rows.
    pub heights: Vec<f32>,
}

/// A part of a scene: one mesh of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The name by which manifests assign materials.
    pub name: &'static str,
    /// Triangles of the part.
    pub mesh: Mesh,
    /// Properties besides the BRDF: bumps and mirroring.
    pub surface: Surface,
}

/// A pinhole camera in world space.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Camera {
    /// Position of the pinhole.
    pub eye: Vector,
    /// Point that the camera looks at.
    pub target: Vector,
    /// Up direction in the image.
    pub up: Vector,
    /// Vertical angle of view in degrees, between 0 and 180.
    pub field_of_view: f64,
}

/// A point light, which shines equally in all directions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PointLight {
    /// Position in world space.
    pub position: Vector,
    /// Radiant intensity, linear RGB, W/sr.
    pub intensity: [f64; 3],
}

/// Radiance from far away, by direction: a latitude-longitude image. Row 0 looks up (+y); column `c` of `w` looks along
/// azimuth `2π (c + ½) / w`, with `x = sin θ cos φ, y = cos θ, z = sin θ sin φ`.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB, W/(m² sr).
    pub pixels: Vec<[f32; 3]>,
}

/// Everything that a rendering shows, except the materials.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Parts, in the order in which materials are given.
    pub parts: Vec<Part>,
    /// Camera of the rendering.
    pub camera: Camera,
    /// Point lights.
    pub lights: Vec<PointLight>,
    /// Environment, which mirrors reflect.
    pub environment: Environment,
    /// Background of renderings: linear RGB of the display, 0 to 1, independent of the exposure.
    pub background: [f32; 3],
}

/// Size of an image and its number of samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples per pixel and axis: `samples²` points on a regular grid at `(i + ½) / samples`.
    pub samples: usize,
}
