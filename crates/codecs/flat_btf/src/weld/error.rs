//! What a mesh can have that makes it no periodic surface.

use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use std::fmt;

/// Farthest that a surface rises above or falls below the reference plane, in tiles.
pub const TALLEST: f64 = 16.0;
/// Farthest that a triangle reaches along x or y, in tiles.
pub const WIDEST: f64 = 64.0;

/// Geometry that is no surface over the tile. Vertices and triangles are counted from 0, in the order of the mesh;
/// lengths and places are in the file's unit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MesoError {
    /// The mesh breaks the rules of its type.
    #[error(transparent)]
    Mesh(#[from] FormatError),
    /// The period is no length.
    #[error("tile: found {0}, a zero-area tile, expected a finite length above 0")]
    Tile(f64),
    /// A vertex too far away for tiles to be counted.
    #[error("vertex {vertex} at {}: found {found:e} tiles from the origin, expected 1e6", Point(*.position))]
    Far {
        /// Which.
        vertex: usize,
        /// Where.
        position: Vector,
        /// Largest of its coordinates, in tiles.
        found: f64,
    },
    /// No triangle is left.
    #[error(
        "triangles: found {triangles}, none of them with three different corners{}, expected at least one with an area",
        .hint
    )]
    Empty {
        /// Triangles in the mesh.
        triangles: usize,
        /// How large the mesh is.
        hint: Hint,
    },
    /// Edges with one triangle: a hole, or a border that the opposite one does not continue.
    #[error(
        "edges: found {count} with one triangle, the first at triangle {triangle} from {} to {}, expected two triangles \
         at every edge, where need be one tile on: this is a hole, or a border that does not fit the opposite one{}",
        Point(.edge[0]), Point(.edge[1]), .hint
    )]
    Open {
        /// Edges with one triangle.
        count: usize,
        /// The first triangle at one.
        triangle: usize,
        /// Ends of that edge.
        edge: [Vector; 2],
        /// How large the mesh is.
        hint: Hint,
    },
    /// Edges with three triangles or more.
    #[error(
        "edges: found {count} with more than two triangles, the first at triangle {triangle} from {} to {} with \
         {triangles}, expected two triangles at every edge{}",
        Point(.edge[0]), Point(.edge[1]), .hint
    )]
    NonManifold {
        /// Edges with more than two triangles.
        count: usize,
        /// The first triangle at one.
        triangle: usize,
        /// Triangles at that edge.
        triangles: usize,
        /// Ends of that edge.
        edge: [Vector; 2],
        /// How large the mesh is.
        hint: Hint,
    },
    /// More than one surface.
    #[error(
        "surface: found {count} pieces that are not joined, the second with triangle {triangle} at {}, expected one \
         that goes on from tile to tile: loose parts are to be merged with what is below",
        Point(*.position)
    )]
    Pieces {
        /// Pieces.
        count: usize,
        /// First triangle of the second piece.
        triangle: usize,
        /// Its first corner.
        position: Vector,
    },
    /// A surface with one side, such as a Moebius strip.
    #[error(
        "surface: found no consistent orientation, neither side of triangle {triangle} at {} can be out, expected a \
         surface with two sides",
        Point(*.position)
    )]
    NotOrientable {
        /// Where the sides meet.
        triangle: usize,
        /// Its first corner.
        position: Vector,
    },
    /// A vertex at which parts of the surface touch.
    #[error(
        "vertex {vertex} at {}: found a point where parts of the surface touch, expected triangles that form one fan",
        Point(*.position)
    )]
    Touching {
        /// Which.
        vertex: usize,
        /// Where.
        position: Vector,
    },
    /// Handles, or a closed body.
    #[error("surface: found {vertices} vertices - {edges} edges + {triangles} triangles = {}, {}, expected 0: a surface \
             that is a sheet, without handles or holes through it", .characteristic, what_it_is(*.characteristic))]
    Topology {
        /// Vertices.
        vertices: usize,
        /// Edges.
        edges: usize,
        /// Triangles.
        triangles: usize,
        /// Euler characteristic.
        characteristic: i64,
    },
    /// The surface does not cover the tile once.
    #[error("surface: found that it covers the tile {found:.3} times, expected once{}", .hint)]
    Cover {
        /// Area of the projection along z in tiles, overhangs counted with their sign.
        found: f64,
        /// How large the mesh is.
        hint: Hint,
    },
    /// A triangle whose corners lie in a line, and that no exchange of an edge repairs.
    #[error(
        "triangle {triangle}: found no area between {}, {} and {}, expected corners that are not in one line",
        Point(.corners[0]), Point(.corners[1]), Point(.corners[2])
    )]
    Flat {
        /// Which.
        triangle: usize,
        /// Its corners.
        corners: [Vector; 3],
    },
    /// More materials than a surface blends.
    #[error("materials: found {}: {}, expected at most 4", .0.len(), some(.0))]
    Materials(Vec<String>),
    /// A surface that rises or falls too far.
    #[error("heights: found {} to {} tiles, expected {} tiles above and below the reference plane at most", .0[0], .0[1], TALLEST)]
    Tall([f64; 2]),
    /// A triangle that reaches over too many tiles.
    #[error("triangle {triangle}: found that it reaches over {found:.0} tiles, expected {} along each axis", WIDEST)]
    Wide {
        /// Which.
        triangle: usize,
        /// Its larger extent along x and y, in tiles.
        found: f64,
    },
    /// Triangles that reach over many tiles each.
    #[error("triangles: found that they reach over {found} tiles together, expected {allowed}")]
    Spread {
        /// Sum over all triangles.
        found: u64,
        /// Largest sum.
        allowed: u64,
    },
    /// A height map of a size that cannot be joined, or with heights that are no numbers.
    #[error("heights: found {found}, expected {allowed}")]
    Heights {
        /// What stands there.
        found: String,
        /// What may stand there.
        allowed: &'static str,
    },
}

fn what_it_is(characteristic: i64) -> String {
    match characteristic {
        2 => "a closed body".to_owned(),
        below if below < 0 && below % 2 == 0 => format!("{} handles or holes through it", -below / 2),
        _ => "no closed surface".to_owned(),
    }
}

/// A place as text.
struct Point(Vector);

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "({x}, {y}, {z})")
    }
}

/// Says what the period may have been meant to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hint {
    /// Sizes of the bounding box along x and y.
    pub extent: [f64; 2],
    /// The period that was given.
    pub tile: f64,
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { extent: [width, depth], tile } = *self;
        write!(f, " (the mesh spans {width} x {depth} and the tile is {tile}")?;
        // A square other than the tile is likely to be the tile.
        if (width - depth).abs() <= 1e-3 * width && (width - tile).abs() > 1e-3 * tile && width > 0.0 {
            write!(f, ": try `--tile {width}`")?;
        }
        write!(f, ")")
    }
}

/// Names, as many as a message has room for.
fn some(names: &[String]) -> String {
    const MOST: usize = 12;
    let more = names.len().saturating_sub(MOST);
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("{}{more}", names[..names.len().min(MOST)].join(", "))
}
