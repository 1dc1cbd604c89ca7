//! Errors of meshes that are no periodic surface.

use brdfc_core::words::join_truncated;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use std::fmt;

/// Maximum distance of the surface from the reference plane, in tiles.
pub const MAX_HEIGHT: f64 = 16.0;
/// Maximum extent of a triangle along x or y, in tiles.
pub const MAX_EXTENT: f64 = 64.0;

/// Errors of geometry that is no surface over the tile. Vertices and triangles are counted from 0, in the order of the
/// mesh; lengths and positions are in the file's unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MesoError {
    /// The mesh breaks the rules of its type.
    #[error(transparent)]
    Mesh(#[from] FormatError),
    /// The period is not a finite length above 0.
    #[error("tile: found {0}, expected a finite length above 0")]
    Tile(f64),
    /// A vertex too far away to count tiles.
    #[error("vertex {vertex} at {}: found {found:e} tiles from the origin, expected at most 1e6", Point(*.position))]
    Far {
        /// Index of the vertex.
        vertex: usize,
        /// Position of the vertex.
        position: Vector,
        /// Its largest coordinate, in tiles.
        found: f64,
    },
    /// No triangle is left.
    #[error(
        "triangles: none of {triangles} has three distinct corners; expected at least one triangle with an area{}",
        .hint
    )]
    Empty {
        /// Triangles in the mesh.
        triangles: usize,
        /// Size of the mesh.
        hint: Hint,
    },
    /// Edges with one triangle: a hole, or a border that the opposite one does not continue.
    #[error(
        "edges: {} one triangle, the first at triangle {triangle} from {} to {}: the mesh has a hole, or its opposite \
         borders do not match; expected two triangles at every edge{}",
        edges_have(*.count), Point(.edge[0]), Point(.edge[1]), .hint
    )]
    Open {
        /// Edges with one triangle.
        count: usize,
        /// First triangle with such an edge.
        triangle: usize,
        /// Ends of that edge.
        edge: [Vector; 2],
        /// Size of the mesh.
        hint: Hint,
    },
    /// Edges with three triangles or more.
    #[error(
        "edges: {} more than two triangles, the first at triangle {triangle} from {} to {} with {triangles} triangles; \
         expected two triangles at every edge{}",
        edges_have(*.count), Point(.edge[0]), Point(.edge[1]), .hint
    )]
    NonManifold {
        /// Edges with more than two triangles.
        count: usize,
        /// First triangle with such an edge.
        triangle: usize,
        /// Triangles at that edge.
        triangles: usize,
        /// Ends of that edge.
        edge: [Vector; 2],
        /// Size of the mesh.
        hint: Hint,
    },
    /// More than one component.
    #[error(
        "surface: found {count} disconnected components, the second with triangle {triangle} at {}, expected one \
         component that continues from tile to tile; merge loose components with the surface below them",
        Point(*.position)
    )]
    Pieces {
        /// Number of connected components.
        count: usize,
        /// First triangle of the second component.
        triangle: usize,
        /// Position of the first corner of this triangle.
        position: Vector,
    },
    /// A surface with one side, such as a Moebius strip.
    #[error(
        "surface: no consistent orientation, because neither side of triangle {triangle} at {} can face out; expected \
         a surface with two sides",
        Point(*.position)
    )]
    NotOrientable {
        /// Triangle at which the orientations conflict.
        triangle: usize,
        /// Position of the first corner of this triangle.
        position: Vector,
    },
    /// A vertex at which the surface touches itself.
    #[error(
        "vertex {vertex} at {}: the surface touches itself; expected triangles around a vertex that form one fan",
        Point(*.position)
    )]
    Touching {
        /// Index of the vertex.
        vertex: usize,
        /// Position of the vertex.
        position: Vector,
    },
    /// Handles, or a closed body.
    #[error(
        "surface: found {vertices} vertices - {edges} edges + {triangles} triangles = {characteristic} ({}), expected \
         0 (a sheet without handles or through holes)",
        describe_surface(*.characteristic)
    )]
    Topology {
        /// Number of vertices of one tile.
        vertices: usize,
        /// Number of edges of one tile.
        edges: usize,
        /// Number of triangles of one tile.
        triangles: usize,
        /// Euler characteristic: vertices - edges + triangles.
        characteristic: i64,
    },
    /// The surface does not cover the tile once.
    #[error("surface: found a coverage of {found:.3} tiles, expected 1 tile{}", .hint)]
    Cover {
        /// Area of the projection along z in tiles, with overhangs counted by their sign.
        found: f64,
        /// Size of the mesh.
        hint: Hint,
    },
    /// A triangle with collinear corners that no edge flip repairs.
    #[error(
        "triangle {triangle}: no area between {}, {} and {}; expected corners that are not collinear",
        Point(.corners[0]), Point(.corners[1]), Point(.corners[2])
    )]
    Flat {
        /// Index of the triangle.
        triangle: usize,
        /// Positions of the triangle's corners.
        corners: [Vector; 3],
    },
    /// More materials than a surface blends.
    #[error("materials: found {} ({}), expected at most 4", .0.len(), join_truncated(.0, 12))]
    Materials(Vec<String>),
    /// A surface that is too high or too low.
    #[error("heights: found {} to {} tiles, expected at most {MAX_HEIGHT} tiles above and below the reference plane", .0[0], .0[1])]
    Tall([f64; 2]),
    /// A triangle that spans too many tiles.
    #[error("triangle {triangle}: found an extent of {found:.0} tiles, expected at most {MAX_EXTENT} along each axis")]
    Wide {
        /// Index of the triangle.
        triangle: usize,
        /// Its larger extent along x and y, in tiles.
        found: f64,
    },
    /// Triangles that span too many tiles in total.
    #[error("triangles: found {found} overlapped tiles in total, expected at most {allowed}")]
    Spread {
        /// Sum over all triangles.
        found: u64,
        /// Maximum sum that is accepted.
        allowed: u64,
    },
    /// A height map with an invalid size, or with heights that are not finite.
    #[error("heights: found {found}, expected {allowed}")]
    Heights {
        /// Size or height that was read.
        found: String,
        /// Values that are valid.
        allowed: &'static str,
    },
}

fn edges_have(count: usize) -> String {
    if count == 1 { "1 edge has".to_owned() } else { format!("{count} edges have") }
}

fn describe_surface(characteristic: i64) -> String {
    match characteristic {
        2 => "a closed body".to_owned(),
        -2 => "one handle or through hole".to_owned(),
        below if below < 0 && below % 2 == 0 => format!("{} handles or through holes", -below / 2),
        _ => "no closed surface".to_owned(),
    }
}

/// A position as text.
struct Point(Vector);

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "({x}, {y}, {z})")
    }
}

/// Mesh size and period, with a suggestion for the period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hint {
    /// Sizes of the bounding box along x and y.
    pub extent: [f64; 2],
    /// Period that the caller gave: side of the tile, in the file's unit.
    pub tile: f64,
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { extent: [width, depth], tile } = *self;
        write!(f, "; the mesh spans {width} x {depth} and the tile is {tile}")?;
        // A square mesh of another size than the tile is probably one tile.
        if (width - depth).abs() <= 1e-3 * width && (width - tile).abs() > 1e-3 * tile && width > 0.0 {
            write!(f, "; try --tile {width}")?;
        }
        Ok(())
    }
}
