//! Lays a periodic surface flat: every point gets parameters `(u, v)` that repeat as the surface does.
//!
//! Mean value coordinates (Floater 2003): each vertex is the mean of its neighbours with weights
//! `w_ij = (tan(α_{i-1} / 2) + tan(α_i / 2)) / |x_j - x_i|`, rows normalised. The whole border of the square is free:
//! opposite sides are one, and the map goes on smoothly across them.
//!
//! On a torus such a system has a solution only if the weights do not drift: walking from vertex to vertex with the
//! weights as probabilities must lead nowhere on average. Mean value weights are not symmetric and may drift. They are
//! therefore tilted, `w_ij exp(θ · e_ij)` with `e_ij` the edge's extent along x and y, by the one `θ` that stops the
//! drift; on a plane it is 0. All weights stay positive, which is all that it takes for a map without flipped triangles
//! (Gortler, Gotsman and Thurston 2006, "Discrete one-forms on meshes and applications to 3D mesh parameterization").

use super::mesh::{Corner, PeriodicMesh};
use super::stretch::{Stretch, measure, vertex_stretch};
use brdfc_formats::direction::{cross, dot, subtract};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};

/// Parameters of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameterisation {
    /// `(u, v)` of each vertex. A corner in another tile has these plus the tile.
    pub coordinates: Vec<[f64; 2]>,
    /// What was measured.
    pub report: ParameterisationReport,
}

/// How good a parameterisation is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct ParameterisationReport {
    /// Largest difference of a vertex from the weighted mean of its neighbours, in tiles.
    pub residual: f64,
    /// Length of the tilt `θ`, per tile.
    pub tilt: f64,
    /// Triangles that lie upside down: 0.
    pub flipped: usize,
    /// Stretch of mean value coordinates.
    pub before: Stretch,
    /// Stretch of what is used.
    pub after: Stretch,
    /// Rounds of reweighting that lowered the stretch.
    pub rounds: usize,
}

/// Why a surface cannot be laid flat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameteriseError {
    /// The linear system has no usable solution.
    #[error("parameterisation: found a residual of {found:e} tiles; allowed at most {RESIDUAL_LIMIT:e}")]
    Residual {
        /// Residual.
        found: f64,
    },
    /// The solver gave up.
    #[error("parameterisation: the linear system cannot be solved: {reason}")]
    Singular {
        /// What the solver says.
        reason: String,
    },
    /// Triangles lie upside down: angles so thin that arithmetic fails.
    #[error(
        "parameterisation: found {count} flipped triangles, the first at ({:.4}, {:.4}, {:.4}); allowed none (its \
         angles may be too thin)",
        .at[0], .at[1], .at[2]
    )]
    Flipped {
        /// How many.
        count: usize,
        /// A corner of the first, in tiles.
        at: [f64; 3],
    },
}

/// Largest residual of the linear system, in tiles.
pub const RESIDUAL_LIMIT: f64 = 1e-9;
/// Drift at which the tilt is found, in tiles.
const DRIFT_LIMIT: f64 = 1e-12;
/// Steps towards the tilt: each divides the drift by ten or more.
const TILT_STEPS: usize = 30;

/// A directed edge: from a vertex to a corner in a tile, seen from the vertex's own tile.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: u32,
    to: Corner,
    weight: f64,
}

/// Lays `mesh` flat. Up to `rounds` rounds of reweighting divide the weights at each vertex by the stretch there
/// (Yoshizawa, Belyaev and Seidel 2004, "A fast and simple stretch-minimizing mesh parameterization"), as long as the
/// stretch falls: texels go where the surface is.
///
/// # Errors
/// When the system cannot be solved to [`RESIDUAL_LIMIT`], or triangles come out flipped.
pub fn parameterise(mesh: &PeriodicMesh, rounds: usize) -> Result<Parameterisation, ParameteriseError> {
    let mut edges = mean_value_weights(mesh);
    let mut best = solve(mesh, &edges)?;
    let before = measure(mesh, &best.coordinates);
    let (mut after, mut used) = (before, 0);
    for _ in 0..rounds {
        let stretch = vertex_stretch(mesh, &best.coordinates);
        edges.iter_mut().for_each(|edge| edge.weight /= stretch[edge.to.vertex as usize]);
        let Ok(next) = solve(mesh, &edges) else { break };
        let measured = measure(mesh, &next.coordinates);
        if measured.l2 >= after.l2 || !measured.l2.is_finite() || flipped(mesh, &next.coordinates).0 > 0 {
            break;
        }
        (best, after, used) = (next, measured, used + 1);
    }
    let (count, at) = flipped(mesh, &best.coordinates);
    if count > 0 {
        return Err(ParameteriseError::Flipped { count, at });
    }
    let report =
        ParameterisationReport { residual: best.residual, tilt: best.tilt, flipped: 0, before, after, rounds: used };
    Ok(Parameterisation { coordinates: best.coordinates, report })
}

/// Weights of all directed edges, by vertex, in a fixed order.
fn mean_value_weights(mesh: &PeriodicMesh) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(6 * mesh.triangles.len());
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(index);
        for k in 0..3 {
            let here = triangle[k];
            let [next, last] = [(k + 1) % 3, (k + 2) % 3];
            let (along, other) = (subtract(corners[next], corners[k]), subtract(corners[last], corners[k]));
            let normal = cross(along, other);
            let sine = dot(normal, normal).sqrt();
            // tan(α / 2) = sin α / (1 + cos α), with both times the lengths of the edges.
            let lengths = dot(along, along).sqrt() * dot(other, other).sqrt();
            let half_tangent = sine / (lengths + dot(along, other)).max(f64::MIN_POSITIVE);
            for (to, edge) in [(triangle[next], along), (triangle[last], other)] {
                let tile = [0, 1].map(|axis| to.tile[axis] - here.tile[axis]);
                let weight = half_tangent / dot(edge, edge).sqrt();
                edges.push(Edge { from: here.vertex, to: Corner { vertex: to.vertex, tile }, weight });
            }
        }
    }
    edges.sort_by_key(|edge| (edge.from, edge.to.vertex, edge.to.tile));
    // Each edge comes from the triangles on both its sides.
    edges
        .chunk_by(|a, b| (a.from, a.to) == (b.from, b.to))
        .map(|pair| Edge { weight: pair.iter().map(|edge| edge.weight).sum(), ..pair[0] })
        .collect()
}

struct Solution {
    coordinates: Vec<[f64; 2]>,
    residual: f64,
    tilt: f64,
}

/// Solves `u_i = Σ_j λ_ij (u_j + tile_ij)` with the tilt that allows it.
fn solve(mesh: &PeriodicMesh, edges: &[Edge]) -> Result<Solution, ParameteriseError> {
    let extent = |edge: &Edge| {
        let (from, to) = (mesh.positions[edge.from as usize], mesh.position(edge.to));
        [to[0] - from[0], to[1] - from[1]]
    };
    let mut tilt = [0.0f64; 2];
    let mut symbolic = None;
    for _ in 0..TILT_STEPS {
        let tilted: Vec<Edge> = edges
            .iter()
            .map(|edge| {
                let e = extent(edge);
                Edge { weight: edge.weight * (tilt[0] * e[0] + tilt[1] * e[1]).exp(), ..*edge }
            })
            .collect();
        let rows = normalised(&tilted);
        let (solved, drift) = with_drift(mesh, &rows, &mut symbolic)?;
        if drift.iter().all(|d| d.abs() < DRIFT_LIMIT) {
            let residual = residual(&rows, &solved);
            if residual > RESIDUAL_LIMIT || residual.is_nan() {
                return Err(ParameteriseError::Residual { found: residual });
            }
            return Ok(Solution { coordinates: solved, residual, tilt: tilt[0].hypot(tilt[1]) });
        }
        // How the drift answers to the tilt: the mean over vertices of the variance of a step.
        let mut variance = [[0.0f64; 2]; 2];
        for edge in &rows {
            let e = extent(edge);
            (0..2).for_each(|a| (0..2).for_each(|b| variance[a][b] += edge.weight * e[a] * e[b]));
        }
        let n = mesh.positions.len() as f64;
        let [[a, b], [c, d]] = variance.map(|row| row.map(|v| v / n));
        let determinant = a * d - b * c;
        tilt[0] -= (d * drift[0] - b * drift[1]) / determinant;
        tilt[1] -= (a * drift[1] - c * drift[0]) / determinant;
        if !tilt.iter().all(|t| t.is_finite()) {
            break;
        }
    }
    Err(ParameteriseError::Singular { reason: "no tilt of the weights stops their drift".into() })
}

/// Weights of each vertex divided by their sum.
fn normalised(edges: &[Edge]) -> Vec<Edge> {
    let rows = edges.chunk_by(|a, b| a.from == b.from);
    rows.flat_map(|row| {
        let sum: f64 = row.iter().map(|edge| edge.weight).sum();
        row.iter().map(move |edge| Edge { weight: edge.weight / sum, ..*edge })
    })
    .collect()
}

/// Solves `u_i = Σ_j λ_ij (u_j + tile_ij) - c` for `u` and the drift `c`, with the first vertex where it stands.
fn with_drift(
    mesh: &PeriodicMesh,
    rows: &[Edge],
    symbolic: &mut Option<SymbolicLu<usize>>,
) -> Result<(Vec<[f64; 2]>, [f64; 2]), ParameteriseError> {
    let n = mesh.positions.len();
    let singular = |reason: String| ParameteriseError::Singular { reason };
    let mut entries = Vec::with_capacity(rows.len() + 2 * n + 1);
    let mut right = faer::Mat::<f64>::zeros(n + 1, 2);
    for i in 0..n {
        entries.push(Triplet::new(i, i, 1.0));
        entries.push(Triplet::new(i, n, 1.0));
    }
    for edge in rows {
        entries.push(Triplet::new(edge.from as usize, edge.to.vertex as usize, -edge.weight));
        (0..2).for_each(|k| right[(edge.from as usize, k)] += edge.weight * f64::from(edge.to.tile[k]));
    }
    entries.push(Triplet::new(n, 0, 1.0));
    (0..2).for_each(|k| right[(n, k)] = mesh.positions[0][k]);
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n + 1, n + 1, &entries)
        .map_err(|error| singular(format!("{error:?}")))?;
    let symbolic = match symbolic {
        Some(known) => known.clone(),
        None => symbolic
            .insert(SymbolicLu::try_new(matrix.symbolic()).map_err(|error| singular(format!("{error:?}")))?)
            .clone(),
    };
    let lu = Lu::try_new_with_symbolic(symbolic, matrix.as_ref()).map_err(|error| singular(format!("{error:?}")))?;
    let solved = lu.solve(&right);
    let coordinates = (0..n).map(|i| [solved[(i, 0)], solved[(i, 1)]]).collect();
    Ok((coordinates, [solved[(n, 0)], solved[(n, 1)]]))
}

/// Largest difference of a vertex from the weighted mean of its neighbours.
fn residual(rows: &[Edge], coordinates: &[[f64; 2]]) -> f64 {
    let mut largest = 0.0f64;
    for row in rows.chunk_by(|a, b| a.from == b.from) {
        for k in 0..2 {
            let mean: f64 = row
                .iter()
                .map(|edge| edge.weight * (coordinates[edge.to.vertex as usize][k] + f64::from(edge.to.tile[k])))
                .sum();
            largest = largest.max((coordinates[row[0].from as usize][k] - mean).abs());
        }
    }
    largest
}

/// Parameters of the corners of a triangle.
pub fn corner_coordinates(mesh: &PeriodicMesh, coordinates: &[[f64; 2]], triangle: usize) -> [[f64; 2]; 3] {
    mesh.triangles[triangle].map(|corner| {
        let c = coordinates[corner.vertex as usize];
        [c[0] + f64::from(corner.tile[0]), c[1] + f64::from(corner.tile[1])]
    })
}

/// Twice the signed area of a triangle of parameters; positive when its corners go counter-clockwise.
pub fn twice_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

/// Number of triangles without positive area, and where the first is.
fn flipped(mesh: &PeriodicMesh, coordinates: &[[f64; 2]]) -> (usize, [f64; 3]) {
    let bad = |t: &usize| twice_area(corner_coordinates(mesh, coordinates, *t)) <= 0.0;
    let mut all = (0..mesh.triangles.len()).filter(bad);
    let first = all.next().map(|t| mesh.corners(t)[0]);
    (usize::from(first.is_some()) + all.count(), first.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::testing::{bumps, height_field, overhang};

    /// Moves the vertices of a plane about, so that its triangles are irregular.
    fn shaken(n: usize) -> PeriodicMesh {
        let mut mesh = height_field(n, |_, _| 0.0);
        for (index, p) in mesh.positions.iter_mut().enumerate() {
            let hash = |k: usize| ((index * 7919 + k * 104_729) % 997) as f64 / 997.0 - 0.5;
            *p = [p[0] + 0.5 / n as f64 * hash(1), p[1] + 0.5 / n as f64 * hash(2), 0.0];
        }
        mesh
    }

    fn largest_move(mesh: &PeriodicMesh, found: &Parameterisation) -> f64 {
        let off = |(p, c): (&[f64; 3], &[f64; 2])| (p[0] - c[0]).abs().max((p[1] - c[1]).abs());
        mesh.positions.iter().zip(&found.coordinates).map(off).fold(0.0, f64::max)
    }

    #[test]
    fn a_plane_is_laid_onto_itself() {
        for mesh in [height_field(9, |_, _| 0.3), shaken(12)] {
            let found = parameterise(&mesh, 0).unwrap();
            assert!(largest_move(&mesh, &found) < 1e-11, "{}", largest_move(&mesh, &found));
            assert!(found.report.tilt < 1e-9 && (found.report.after.l2 - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn other_weights_do_not_reproduce_a_plane() {
        let mesh = shaken(12);
        let mut edges = mean_value_weights(&mesh);
        edges.iter_mut().for_each(|edge| edge.weight = 1.0);
        let found = solve(&mesh, &edges).unwrap();
        let off = mesh.positions.iter().zip(&found.coordinates).map(|(p, c)| (p[0] - c[0]).abs()).fold(0.0, f64::max);
        assert!(off > 1e-3, "{off}");
    }

    #[test]
    fn nothing_is_flipped_and_the_tile_is_covered_once() {
        for mesh in [bumps(24, 0.5), overhang(32), overhang(48)] {
            for rounds in [0, 6] {
                let found = parameterise(&mesh, rounds).unwrap();
                assert_eq!(flipped(&mesh, &found.coordinates).0, 0);
                let area: f64 = (0..mesh.triangles.len())
                    .map(|t| 0.5 * twice_area(corner_coordinates(&mesh, &found.coordinates, t)))
                    .sum();
                assert!((area - 1.0).abs() < 1e-9, "{area}");
                assert!(found.report.residual < RESIDUAL_LIMIT);
            }
        }
        // The control: seen from above, the same sheet has flipped triangles.
        let mesh = overhang(32);
        let from_above: Vec<[f64; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
        assert!(flipped(&mesh, &from_above).0 > 0);
    }

    #[test]
    fn reweighting_spends_texels_where_the_surface_is() {
        let mesh = overhang(32);
        let report = parameterise(&mesh, 10).unwrap().report;
        assert!(report.rounds > 0 && report.after.l2 < report.before.l2, "{report:?}");
    }
}
