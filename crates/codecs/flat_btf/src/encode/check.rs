//! Validates recipes and estimates their memory before any work.

use super::recipe::FlattenRecipe;
use crate::caster::MAX_POLAR_DEGREES;
use crate::displacement::coarser;
use crate::factored::FactoredRecipe;
use crate::fill::FillMethod;
use crate::interreflection::Bounces;
use brdfc_formats::FormatError;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{DisplacementHeader, FlatHeader, IndirectionHeader};
use std::f32::consts::TAU;

/// Maximum memory of a recipe, in bytes.
pub const MAX_BYTES: u64 = 8 << 30;
/// Bytes per texel: a point of the surface with its normals and material, and the data derived from it.
const TEXEL_BYTES: u64 = 256;
/// Bytes per texel and light of a view in progress: the value as floats, packed, and as scratch bytes.
const VALUE_BYTES: u64 = 12;
/// Maximum number of views in memory at once.
const MAX_VIEWS_AT_ONCE: usize = 8;

impl FlattenRecipe {
    /// Checks that packs can hold the asset, that rays are not too steep, and that one view at a time fits into memory.
    /// The result does not depend on the machine.
    ///
    /// # Errors
    /// Returns the first value that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let IndirectionHeader { size, .. } = self.indirection;
        DisplacementHeader::new(IndirectionHeader { size: size / coarser(size), ..self.indirection }).check()?;
        for (what, set) in [("views", &self.views), ("lights", &self.lights)] {
            let of_set = |error: FormatError| FormatError { field: format!("{what}, {}", error.field).into(), ..error };
            if let Some(steep) = set.angles.iter().position(|[polar, _]| *polar > MAX_POLAR_DEGREES) {
                let field = format!("{what}, direction {steep}, polar angle");
                let found = format!("{} degrees", set.angles[steep][0]);
                return Err(FormatError::whole(field, found, format!("0 to {MAX_POLAR_DEGREES}")));
            }
            // The shader blends over this mesh.
            DirectionMesh::new(set).map_err(of_set)?;
        }
        let header = self.header(0);
        header.check()?;
        if let Some(target) = self.factored {
            target.check(&header)?;
        }
        let bytes = self.bytes(1);
        if bytes > MAX_BYTES {
            let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30));
            let allowed = format!("at most {}; reduce texels, views, lights or bounces", gib(MAX_BYTES));
            return Err(FormatError::whole("memory", gib(bytes), allowed));
        }
        Ok(())
    }

    /// Header of a view.
    pub(super) fn header(&self, view: u32) -> FlatHeader {
        let (views, lights) = (angles(&self.views), angles(&self.lights));
        FlatHeader { size: self.flat_texels as u32, view, views, lights }
    }

    /// Number of views computed at once: one per thread, as far as memory allows.
    pub(super) fn views_at_once(&self) -> usize {
        let most = rayon::current_num_threads().clamp(1, MAX_VIEWS_AT_ONCE).min(self.views.len());
        (2..=most).rev().find(|views| self.bytes(*views) <= MAX_BYTES).unwrap_or(1)
    }

    /// Estimated peak memory in bytes for `views_at_once` views: the parts that grow with texels, views, lights and
    /// bounces.
    pub fn bytes(&self, views_at_once: usize) -> u64 {
        let texels = (self.flat_texels * self.flat_texels) as u64;
        let (views, lights) = (self.views.len() as u64, self.lights.len() as u64);
        let guide = u64::from(self.fill == FillMethod::Poisson && self.factored.is_some());
        let per_light = VALUE_BYTES * (views_at_once as u64 + guide) + 1;
        let map: u64 = self.indirection.extent().into_iter().map(u64::from).product();
        // Factors are computed after all views.
        let factors = self.factored.map_or(0, |target| FactoredRecipe::new(target).memory(&self.header(0)));
        texels * (TEXEL_BYTES + views)
            + (texels * lights * per_light).max(factors)
            + 20 * map
            + Bounces::bytes(texels as usize, self.bounces, self.lights.len())
    }
}

/// Polar angles and azimuths in radians, azimuths from 0 to below 2π.
fn angles(set: &DirectionSet) -> Vec<[f32; 2]> {
    let radians = |[polar, azimuth]: &[f64; 2]| {
        let azimuth = azimuth.rem_euclid(360.0).to_radians() as f32;
        [polar.to_radians() as f32, if azimuth >= TAU { 0.0 } else { azimuth }]
    };
    set.angles.iter().map(radians).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factored::FactoredTarget;

    fn recipe() -> FlattenRecipe {
        FlattenRecipe {
            flat_texels: 256,
            indirection: IndirectionHeader { size: 256, zenith_samples: 16, azimuth_samples: 16, largest_angle: 1.4 },
            oversampling: 2,
            views: DirectionSet::ubo2003(),
            lights: DirectionSet::ubo2003(),
            fill: FillMethod::Poisson,
            bounces: 0,
            rounds: 0,
            factored: Some(FactoredTarget::Error(0.7)),
        }
    }

    fn list(angles: &[[f64; 2]]) -> DirectionSet {
        DirectionSet::new("list", angles.to_vec()).unwrap()
    }

    #[test]
    fn the_setting_of_the_paper_fits_into_memory() {
        assert!(recipe().check().is_ok());
        let light = FlattenRecipe { factored: None, ..recipe() };
        for (recipe, most) in [(light, 1u64 << 30), (recipe(), 2 << 30)] {
            let bytes = recipe.bytes(MAX_VIEWS_AT_ONCE);
            assert!(bytes < most, "{bytes}");
        }
    }

    #[test]
    fn threads_only_determine_the_views_computed_at_once() {
        let threads = [1, 2, 8, 64];
        let on_each = |recipe: &FlattenRecipe| {
            threads.map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| (recipe.check().map_err(|error| error.to_string()), recipe.views_at_once()))
            })
        };
        for (flat_texels, lights, at_once) in [
            (256, DirectionSet::ubo2003(), [1, 2, 8, 8]),
            (1024, DirectionSet::ubo2003(), [1, 2, 6, 6]),
            (1024, DirectionSet::ubo2014(), [1, 2, 3, 3]),
        ] {
            let recipe = FlattenRecipe { flat_texels, lights, ..recipe() };
            assert_eq!(on_each(&recipe), at_once.map(|views| (Ok(()), views)));
            assert!(at_once.iter().all(|views| recipe.bytes(*views) <= MAX_BYTES));
        }
        let found = on_each(&FlattenRecipe { flat_texels: 2048, ..recipe() });
        assert!(found[0].0.is_err() && found.iter().all(|answer| *answer == found[0]), "{found:?}");
    }

    #[test]
    fn invalid_recipes_fail_before_any_work() {
        let steep = FlattenRecipe { views: list(&[[0.0, 0.0], [89.99, 0.0]]), ..recipe() };
        assert_eq!(
            steep.check().unwrap_err().to_string(),
            "views, direction 1, polar angle: found 89.99 degrees, expected 0 to 89"
        );
        let large = FlattenRecipe { flat_texels: 2048, ..recipe() };
        assert!(large.check().unwrap_err().to_string().contains("memory: found "));
        let bounced = FlattenRecipe { bounces: 1024, ..recipe() };
        assert!(bounced.check().unwrap_err().to_string().contains("GiB, expected at most 8.0 GiB"));
        assert!(FlattenRecipe { bounces: 64, ..recipe() }.check().is_ok());
    }

    #[test]
    fn azimuths_below_zero_and_a_full_turn_are_wrapped() {
        let set = list(&[[10.0, -90.0], [20.0, 360.0], [30.0, -1e-9]]);
        let found = angles(&set);
        assert!((found[0][1] - 1.5 * std::f32::consts::PI).abs() < 1e-6);
        assert_eq!((found[1][1], found[2][1]), (0.0, 0.0));
        assert!(FlattenRecipe { lights: set, ..recipe() }.check().is_ok());
    }
}
