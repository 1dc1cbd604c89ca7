//! A surface made ready for everything that is asked of it.

use super::caster::PeriodicCaster;
use super::mesh::{PeriodicMesh, corner_coordinates};
use super::parameterise::{ParameteriseError, SurfaceParameterisation, parameterise};
use super::surface::{Hit, SurfacePoint};
use super::texels::{TexelMap, texel_map};
use brdfc_core::progress::Progress;
use brdfc_formats::direction::Vector;

/// A periodic surface with parameters, ready for rays.
pub struct MesoModel {
    /// The surface.
    pub mesh: PeriodicMesh,
    /// Its parameters.
    pub parameterisation: SurfaceParameterisation,
    /// Rays against its repetition.
    pub caster: PeriodicCaster,
}

/// What is seen along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Its parameters, not wrapped: they move on without a jump where the line goes on to the next tile.
    pub parameters: [f64; 2],
    /// Where the line meets the surface.
    pub hit: Hit,
}

impl MesoModel {
    /// Lays the surface flat with up to `rounds` rounds of stretch-reducing reweighting; `progress` hears of about
    /// [`steps`]`(rounds)` steps.
    ///
    /// [`steps`]: super::parameterise::steps
    ///
    /// # Errors
    /// As [`parameterise`].
    pub fn new(mesh: PeriodicMesh, rounds: usize, progress: &dyn Progress) -> Result<Self, ParameteriseError> {
        let parameterisation = parameterise(&mesh, rounds, progress)?;
        let caster = PeriodicCaster::new(&mesh);
        Ok(Self { mesh, parameterisation, caster })
    }

    /// Surface points of `size` x `size` texels.
    pub fn texels(&self, size: usize) -> TexelMap {
        texel_map(&self.mesh, &self.parameterisation.coordinates, size)
    }

    /// What an eye far away in direction `view` sees behind the point `(x, y)` of the reference plane.
    ///
    /// # Panics
    /// If the surface has a hole, or the view is steeper than [`super::caster::STEEPEST_DEGREES`] over a taller relief
    /// than [`super::weld::TALLEST`]: a [`PeriodicMesh`] that was checked has neither.
    pub fn seen(&self, at: [f64; 2], view: Vector) -> Seen {
        let at = [at[0], at[1], 0.0];
        // A line through the seam of triangles that rounding pulls apart: a hair to the side they meet. Hairs grow, since
        // seams of large triangles are wider.
        let nudged = |k: i32| {
            let hair = if k == 0 { 0.0 } else { 1e-7 * 2f64.powi(k - 1) };
            [at[0] + hair, at[1] + 0.7 * hair, 0.0]
        };
        let hit = (0..16).find_map(|k| self.caster.seen(nudged(k), view)).expect("a periodic surface has no holes");
        Seen { parameters: self.parameters(&hit), hit }
    }

    /// Parameters of a hit.
    pub fn parameters(&self, hit: &Hit) -> [f64; 2] {
        let corners = corner_coordinates(&self.mesh, &self.parameterisation.coordinates, hit.triangle as usize);
        let [u, v] = hit.barycentric.map(f64::from);
        [0, 1].map(|k| (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k] + f64::from(hit.tile[k]))
    }

    /// The surface point of a hit.
    pub fn point(&self, hit: &Hit) -> SurfacePoint {
        SurfacePoint::of_hit(&self.mesh, hit)
    }
}
