//! Validates recipes and estimates their memory before any work.

use super::recipe::{FlattenRecipe, Reflectance, ReliefForm};
use crate::caster::MAX_POLAR_DEGREES;
use crate::factored::{FactoredRecipe, FactoredTarget, least_bytes};
use crate::fill::FillMethod;
use crate::interreflection::Bounces;
use brdfc_formats::FormatError;
use brdfc_formats::container::MAX_EXTENT_2D;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatHeader, VdimHeader};
use brdfc_formats::pwt::MAX_VIEWS;
use std::f32::consts::TAU;

/// Maximum memory of a recipe, in bytes.
pub const MAX_BYTES: u64 = 8 << 30;
/// Bytes per texel: points of the surface with their normals and materials, and the data derived from them.
const TEXEL_BYTES: u64 = 512;
/// Bytes per texel of the layers: the lines that cross it, with three sheets each.
const LAYER_BYTES: u64 = 1536;
/// Maximum texels of the layers per side.
const MAX_TEXELS: u32 = 2048;
/// Bytes per texel and view of an indirection map: what was measured, and its four halves in the map and in the file.
const VIEW_BYTES: u64 = 28;
/// Maximum rays per texel and axis of an indirection map.
const MAX_OVERSAMPLING: u32 = 16;
const _: () = assert!(MAX_TEXELS <= MAX_EXTENT_2D);
/// Bytes per texel and light of a view in progress: the value as floats, packed, and as scratch bytes.
const VALUE_BYTES: u64 = 12;
/// Bytes per texel, view and light of trees: the value, and its channels while they are fitted.
const TREE_BYTES: u64 = 32;
/// Maximum number of views in memory at once.
const MAX_VIEWS_AT_ONCE: usize = 8;

impl FlattenRecipe {
    /// Checks that packs can hold the asset, that rays are not too steep, and that one view at a time fits into memory.
    /// The result does not depend on the machine.
    ///
    /// # Errors
    /// Returns the first value that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        if !self.texels.is_power_of_two() || !(4..=MAX_TEXELS).contains(&self.texels) {
            let allowed = format!("a power of two from 4 to {MAX_TEXELS}");
            return Err(FormatError::whole("texels", self.texels.to_string(), allowed));
        }
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
        self.check_relief()?;
        if self.reflectance == Reflectance::Pwt {
            FormatError::check_range("views of trees", self.views.len(), 1..=MAX_VIEWS as usize)?;
        }
        let least = least_bytes(self.flat_texels as u32);
        let may_be_brdf = self.reflectance == Reflectance::Auto && self.bounces == 0;
        let fits = |target| !matches!(target, FactoredTarget::Bytes(most) if most < least);
        let may_be_factors = matches!(self.reflectance, Reflectance::Auto | Reflectance::Factors);
        if may_be_factors && !(may_be_brdf && fits(self.target)) {
            let with_brdf = |error: FormatError| match self.target {
                // Either form would do: the smaller one is the least.
                FactoredTarget::Bytes(most) if may_be_brdf && FactoredTarget::Bytes(least).check(&header).is_err() => {
                    let allowed = format!("{least} or more, the bytes of the smallest asset");
                    FormatError::whole("bytes of factors", most.to_string(), allowed)
                }
                _ => error,
            };
            self.target.check(&header).map_err(with_brdf)?;
        }
        within_memory(self.bytes(1))
    }

    /// Checks that the images of one view at a time, and the masks of all, fit into memory.
    ///
    /// # Errors
    /// Returns an error if they do not.
    pub fn check_images(&self) -> Result<(), FormatError> {
        let texels = (self.flat_texels * self.flat_texels) as u64;
        let (views, lights) = (self.views.len() as u64, self.lights.len() as u64);
        within_memory(texels * (TEXEL_BYTES + views + lights * self.bytes_per_light(1)))
    }

    /// Bytes per texel and light of the images of views, and of the guide that fills their holes.
    fn bytes_per_light(&self, views_at_once: usize) -> u64 {
        let guide = u64::from(self.fill == FillMethod::Poisson);
        VALUE_BYTES * (views_at_once as u64 + guide) + 1
    }

    /// Checks the settings of an indirection map.
    fn check_relief(&self) -> Result<(), FormatError> {
        let (ReliefForm::Vdim(vdim), Some(header)) = (&self.relief, self.vdim_header()) else { return Ok(()) };
        header.check()?;
        let rays = vdim.oversampling;
        if !(1..=MAX_OVERSAMPLING).contains(&rays) {
            let allowed = format!("1 to {MAX_OVERSAMPLING} rays per texel and axis");
            return Err(FormatError::whole("oversampling", rays.to_string(), allowed));
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
        let per_light = self.bytes_per_light(views_at_once);
        let layers = match self.vdim_header() {
            None => LAYER_BYTES * u64::from(self.texels).pow(2),
            Some(header) => {
                let shadows = texels * u64::from(header.lights) * 3;
                let views = VdimHeader { block: 1, ..header }.packed_extent();
                VIEW_BYTES * views.texels_of_levels(header.levels) + shadows
            }
        };
        if self.reflectance == Reflectance::Brdf {
            return texels * TEXEL_BYTES + layers;
        }
        // Factors and trees are computed after all views.
        let after = match self.reflectance {
            Reflectance::Pwt => texels * lights * views * TREE_BYTES,
            _ => FactoredRecipe::new(self.target).memory(&self.header(0)),
        };
        texels * (TEXEL_BYTES + views)
            + (texels * lights * per_light).max(after)
            + layers
            + Bounces::bytes(texels as usize, self.bounces, self.lights.len())
    }
}

/// Checks a number of bytes against the limit.
fn within_memory(bytes: u64) -> Result<(), FormatError> {
    if bytes > MAX_BYTES {
        let gib = |bytes: u64| format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30));
        let allowed = format!("at most {}; reduce texels, views, lights or bounces", gib(MAX_BYTES));
        return Err(FormatError::whole("memory", gib(bytes), allowed));
    }
    Ok(())
}

/// Polar angles and azimuths in radians, azimuths from 0 to below 2π.
pub(super) fn angles(set: &DirectionSet) -> Vec<[f32; 2]> {
    let radians = |[polar, azimuth]: &[f64; 2]| {
        let azimuth = azimuth.rem_euclid(360.0).to_radians() as f32;
        [polar.to_radians() as f32, if azimuth >= TAU { 0.0 } else { azimuth }]
    };
    set.angles.iter().map(radians).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe() -> FlattenRecipe {
        FlattenRecipe {
            texels: 256,
            relief: ReliefForm::Layers,
            flat_texels: 256,
            views: DirectionSet::ubo2003(),
            lights: DirectionSet::ubo2003(),
            fill: FillMethod::Poisson,
            bounces: 0,
            reflectance: Reflectance::Auto,
            target: FactoredTarget::Error(0.7),
        }
    }

    fn list(angles: &[[f64; 2]]) -> DirectionSet {
        DirectionSet::new("list", angles.to_vec()).unwrap()
    }

    #[test]
    fn the_setting_of_the_paper_fits_into_memory() {
        assert!(recipe().check().is_ok());
        let light = FlattenRecipe { reflectance: Reflectance::Brdf, ..recipe() };
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
