//! A surface with its parameterisation and ray caster.

use super::caster::PeriodicCaster;
use super::mesh::{PeriodicMesh, corner_coordinates};
use super::parameterise::{ParameteriseError, SurfaceParameterisation, parameterise};
use super::surface::{Hit, SurfacePoint};
use super::texels::{TexelMap, texel_map};
use brdfc_core::progress::Progress;
use brdfc_formats::direction::Vector;

/// A periodic surface with its parameterisation and ray caster.
pub struct MesoModel {
    /// One tile of the surface, welded and periodic.
    pub mesh: PeriodicMesh,
    /// The parameterisation of `mesh`.
    pub parameterisation: SurfaceParameterisation,
    /// Casts rays against the repeated surface.
    pub caster: PeriodicCaster,
}

/// The surface point at which a line of sight ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Parameters of the point, not wrapped: they are continuous where the line crosses into the next tile.
    pub parameters: [f64; 2],
    /// Intersection of the line with the surface.
    pub hit: Hit,
}

impl MesoModel {
    /// Parameterises the surface with up to `rounds` rounds of stretch-reducing reweighting. `progress` receives about
    /// [`steps`]`(rounds)` steps.
    ///
    /// [`steps`]: super::parameterise::steps
    ///
    /// # Errors
    /// Returns the errors of [`parameterise`].
    pub fn new(mesh: PeriodicMesh, rounds: usize, progress: &dyn Progress) -> Result<Self, ParameteriseError> {
        let parameterisation = parameterise(&mesh, rounds, progress)?;
        let caster = PeriodicCaster::new(&mesh);
        Ok(Self { mesh, parameterisation, caster })
    }

    /// Surface points of `size` x `size` texels.
    pub fn texels(&self, size: usize) -> TexelMap {
        texel_map(&self.mesh, &self.parameterisation.coordinates, size)
    }

    /// Returns the surface point that a distant eye in direction `view` sees behind the point `(x, y)` of the reference
    /// plane.
    ///
    /// # Panics
    /// Panics if the surface has a hole, or if the view is steeper than [`super::caster::MAX_POLAR_DEGREES`] and the
    /// relief taller than [`super::weld::MAX_HEIGHT`]. A checked [`PeriodicMesh`] has neither.
    pub fn seen(&self, at: [f64; 2], view: Vector) -> Seen {
        let at = [at[0], at[1], 0.0];
        // The line may pass through a seam that rounding opens between triangles: nudge it sideways. Nudges grow, since
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
