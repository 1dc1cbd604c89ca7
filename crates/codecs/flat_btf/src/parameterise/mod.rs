//! Parameterises a periodic surface: every point gets parameters `(u, v)` that repeat as the surface does.
//!
//! Mean value coordinates (Floater 2003): each vertex is the mean of its neighbours with weights
//! `w_ij = (tan(α_{i-1} / 2) + tan(α_i / 2)) / |x_j - x_i|`, rows normalised. The whole border of the square is free:
//! opposite sides are identified, and the map continues smoothly across them.
//!
//! On a torus such a system has a solution only if the weights do not drift: walking from vertex to vertex with the
//! weights as probabilities must lead nowhere on average. Mean value weights are not symmetric and may drift. They are
//! therefore tilted, `w_ij exp(θ · t_ij + h_j - h_i)` with `t_ij` the tiles that an edge advances, by the only `θ` that
//! stops the drift and the `h` that makes the sum of the weights the same at all vertices; on a plane both are 0. All
//! weights stay positive, which suffices for a map without flipped triangles (Gortler, Gotsman and Thurston 2006,
//! "Discrete one-forms on meshes and applications to 3D mesh parameterization").

mod error;
mod tilt;
mod walk;
mod weights;

pub use error::{MAX_VERTICES, ParameteriseError, RESIDUAL_LIMIT};

use super::mesh::{PeriodicMesh, corner_coordinates, twice_area};
use super::stretch::{Stretch, measure, vertex_stretch};
use brdfc_core::progress::Progress;
use tilt::solve;
use weights::mean_value_weights;

/// Parameters of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceParameterisation {
    /// `(u, v)` of each vertex. A corner in another tile has these plus the tile.
    pub coordinates: Vec<[f64; 2]>,
    /// Quality measurements.
    pub report: SurfaceParameterisationReport,
}

/// Quality of a parameterisation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ParameterisationReport")]
pub struct SurfaceParameterisationReport {
    /// Largest difference of a vertex from the weighted mean of its neighbours, in tiles.
    pub residual: f64,
    /// Length of the tilt `θ`, per tile.
    pub tilt: f64,
    /// Number of flipped triangles: 0.
    pub flipped: usize,
    /// Stretch of mean value coordinates.
    pub before: Stretch,
    /// Stretch of the final parameters.
    pub after: Stretch,
    /// Rounds of reweighting that lowered the stretch.
    pub rounds: usize,
}

/// Number of steps that [`parameterise`] plans at most: each of its solutions takes about `tilt::STEPS`.
pub fn steps(rounds: usize) -> usize {
    (1 + rounds) * tilt::STEPS
}

/// Parameterises `mesh`. Up to `rounds` rounds of reweighting divide the weights at each vertex by the stretch there
/// (Yoshizawa, Belyaev and Seidel 2004, "A fast and simple stretch-minimizing mesh parameterization"), as long as the
/// stretch falls, which distributes texels more evenly over the surface.
///
/// `progress` receives about [`steps`]`(rounds)` steps.
///
/// # Errors
/// Returns an error for more than [`MAX_VERTICES`] vertices, for a system that cannot be solved to [`RESIDUAL_LIMIT`],
/// for flipped triangles, and [`ParameteriseError::Cancelled`].
pub fn parameterise(
    mesh: &PeriodicMesh,
    rounds: usize,
    progress: &dyn Progress,
) -> Result<SurfaceParameterisation, ParameteriseError> {
    if mesh.positions.len() > MAX_VERTICES {
        return Err(ParameteriseError::TooLarge { found: mesh.positions.len() });
    }
    let mut edges = mean_value_weights(mesh);
    let mut symbolic = None;
    let above: Vec<[f64; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
    let mut best = solve(&edges, &above, &mut symbolic, progress)?;
    let before = measure(mesh, &best.coordinates);
    let (mut after, mut used) = (before, 0);
    for _ in 0..rounds {
        let stretch = vertex_stretch(mesh, &best.coordinates);
        edges.iter_mut().for_each(|edge| edge.weight /= stretch[edge.to.vertex as usize]);
        let next = match solve(&edges, &best.coordinates, &mut symbolic, progress) {
            Ok(next) => next,
            Err(error @ ParameteriseError::Cancelled(_)) => return Err(error),
            Err(_) => break,
        };
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
    let report = SurfaceParameterisationReport {
        residual: best.residual,
        tilt: best.tilt,
        flipped: 0,
        before,
        after,
        rounds: used,
    };
    Ok(SurfaceParameterisation { coordinates: best.coordinates, report })
}

/// Number of triangles without positive area, and a corner of the first.
fn flipped(mesh: &PeriodicMesh, coordinates: &[[f64; 2]]) -> (usize, [f64; 3]) {
    let bad = |t: &usize| twice_area(corner_coordinates(mesh, coordinates, *t)) <= 0.0;
    let mut all = (0..mesh.triangles.len()).filter(bad);
    let first = all.next().map(|t| mesh.corners(t)[0]);
    (usize::from(first.is_some()) + all.count(), first.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::VertexMaterial;
    use crate::testing::{Patience, bumps, height_field, overhang};
    use brdfc_core::progress::Cancelled;

    /// Displaces the vertices of a plane, so that its triangles are irregular.
    fn shaken(n: usize) -> PeriodicMesh {
        let mut mesh = height_field(n, |_, _| 0.0);
        for (index, p) in mesh.positions.iter_mut().enumerate() {
            let hash = |k: usize| ((index * 7919 + k * 104_729) % 997) as f64 / 997.0 - 0.5;
            *p = [p[0] + 0.5 / n as f64 * hash(1), p[1] + 0.5 / n as f64 * hash(2), 0.0];
        }
        mesh
    }

    fn largest_move(mesh: &PeriodicMesh, found: &SurfaceParameterisation) -> f64 {
        let off = |(p, c): (&[f64; 3], &[f64; 2])| (p[0] - c[0]).abs().max((p[1] - c[1]).abs());
        mesh.positions.iter().zip(&found.coordinates).map(off).fold(0.0, f64::max)
    }

    fn laid_flat(mesh: &PeriodicMesh, rounds: usize) -> Result<SurfaceParameterisation, ParameteriseError> {
        parameterise(mesh, rounds, &())
    }

    /// A plane with one raised vertex that leans over by `[x, y]` tiles.
    fn leaning(n: usize, [x, y]: [f64; 2]) -> PeriodicMesh {
        let mut points = height_field(n, |_, _| 0.0).positions;
        let tip = &mut points[n / 2 * n + n / 2];
        *tip = [tip[0] + x, tip[1] + y, 0.8];
        PeriodicMesh::from_grid(n, n, points, vec![VertexMaterial::default(); n * n])
    }

    #[test]
    fn spikes_may_lean_any_distance() {
        for n in [6, 12] {
            for lean in [0.6, 0.8, 1.0, 3.0, 30.0] {
                for turned in [[lean, 0.3 * lean], [-lean, 0.0], [0.3 * lean, -lean]] {
                    let mesh = leaning(n, turned);
                    let found = laid_flat(&mesh, 0).unwrap_or_else(|error| panic!("{n} {turned:?}: {error}"));
                    assert_eq!(flipped(&mesh, &found.coordinates).0, 0, "{turned:?}");
                    assert!(found.report.residual < 1e-11 && found.report.tilt > 1e-3, "{:?}", found.report);
                }
            }
        }
    }

    #[test]
    fn weights_may_differ_by_orders_of_magnitude() {
        // Needles eight times as high as they are wide, at random.
        let noise = |x: f64, y: f64| ((12.9898 * x + 78.233 * y).sin() * 43758.5453).rem_euclid(1.0) * 8.0 / 24.0;
        let mesh = height_field(24, noise);
        let found = laid_flat(&mesh, 0).unwrap();
        assert_eq!(flipped(&mesh, &found.coordinates).0, 0);
        assert!(found.report.residual < 1e-11 && found.report.tilt > 1e-2, "{:?}", found.report);
        // The negative control: untilted, they drift.
        let edges = mean_value_weights(&mesh);
        let off = tilt::drift_without_tilt(&edges, mesh.positions.len()).unwrap();
        assert!(off[0].hypot(off[1]) > 1e-4, "{off:?}");
    }

    #[test]
    fn it_can_be_cancelled_and_counts_its_steps() {
        let mesh = overhang(16);
        let count = |most: usize| {
            let patience = Patience::new(most);
            (parameterise(&mesh, 1, &patience), patience.steps())
        };
        let (finished, all) = count(usize::MAX);
        assert!(finished.is_ok());
        assert!((6..=2 * steps(1)).contains(&all), "{all}");
        for most in 1..=all {
            assert_eq!(count(most), (Err(ParameteriseError::Cancelled(Cancelled)), most));
        }
    }

    #[test]
    fn too_many_vertices_are_refused_before_any_work() {
        assert_eq!(MAX_VERTICES, brdfc_source::meso::HEIGHT_MAP_PIXELS);
        let mesh = PeriodicMesh { positions: vec![[0.0; 3]; MAX_VERTICES + 1], ..PeriodicMesh::default() };
        let patience = Patience::new(usize::MAX);
        let error = parameterise(&mesh, 0, &patience).unwrap_err();
        assert_eq!(patience.steps(), 0);
        assert_eq!(error.to_string(), "vertices: found 1048577, expected at most 1048576");
    }

    #[test]
    fn a_plane_is_laid_onto_itself() {
        for mesh in [height_field(9, |_, _| 0.3), shaken(12)] {
            let found = laid_flat(&mesh, 0).unwrap();
            assert!(largest_move(&mesh, &found) < 1e-11, "{}", largest_move(&mesh, &found));
            assert!(found.report.tilt < 1e-9 && (found.report.after.l2 - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn other_weights_do_not_reproduce_a_plane() {
        let mesh = shaken(12);
        let mut edges = mean_value_weights(&mesh);
        edges.iter_mut().for_each(|edge| edge.weight = 1.0);
        let above: Vec<[f64; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
        let found = solve(&edges, &above, &mut None, &()).unwrap();
        let off = mesh.positions.iter().zip(&found.coordinates).map(|(p, c)| (p[0] - c[0]).abs()).fold(0.0, f64::max);
        assert!(off > 1e-3, "{off}");
    }

    #[test]
    fn nothing_is_flipped_and_the_tile_is_covered_once() {
        for mesh in [bumps(24, 0.5), overhang(32), overhang(48)] {
            for rounds in [0, 6] {
                let found = laid_flat(&mesh, rounds).unwrap();
                assert_eq!(flipped(&mesh, &found.coordinates).0, 0);
                let area: f64 = (0..mesh.triangles.len())
                    .map(|t| 0.5 * twice_area(corner_coordinates(&mesh, &found.coordinates, t)))
                    .sum();
                assert!((area - 1.0).abs() < 1e-9, "{area}");
                assert!(found.report.residual < RESIDUAL_LIMIT);
            }
        }
        // The negative control: seen from above, the same sheet has flipped triangles.
        let mesh = overhang(32);
        let from_above: Vec<[f64; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
        assert!(flipped(&mesh, &from_above).0 > 0);
    }

    #[test]
    fn reweighting_lowers_the_stretch() {
        let mesh = overhang(32);
        let report = laid_flat(&mesh, 10).unwrap().report;
        assert!(report.rounds > 0 && report.after.l2 < report.before.l2, "{report:?}");
    }
}
