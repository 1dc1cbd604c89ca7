//! Settings and results of the study.

use super::apparent::ApparentSizes;
use super::grids::GridRow;
use super::paper::PaperModel;
use brdfc_formats::flat_btf::VdimHeader;
use serde::Serialize;

/// Settings of the study.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct StudySettings {
    /// Texels of ordinary BTF images per side.
    pub texels: usize,
    /// Texels of flat BTFs per side, a power of two.
    pub flat_texels: usize,
    /// Rays per texel and axis.
    pub oversampling: usize,
    /// Polar angles and rows of azimuths of the indirection map, which has as many texels as the images.
    pub indirection: [u32; 2],
    /// Its largest polar angle, degrees.
    pub largest_angle: f64,
    /// Maximum number of rounds of stretch-reducing reweighting.
    pub rounds: usize,
    /// Name of the set of directions, for views and lights.
    pub directions: String,
    /// Number of directions.
    pub count: usize,
}

impl StudySettings {
    /// The header of the map.
    pub(super) fn map_header(&self) -> VdimHeader {
        let [polar_angles, azimuth_rows] = self.indirection;
        let largest_angle = self.largest_angle.to_radians() as f32;
        VdimHeader {
            size: self.texels as u32,
            block: 1,
            polar_angles,
            azimuth_rows,
            largest_angle,
            levels: 1,
            lights: 0,
        }
    }
}

/// Results for one model.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ModelRow {
    /// The structure's address.
    pub model: String,
    /// The corresponding model of the paper.
    pub paper_model: &'static str,
    /// Table 1.
    pub reconstruction: ReconstructionRow,
    /// Table 2.
    pub coherency: CoherencyRow,
    /// Table 3.
    pub apparent: ApparentSizes,
    /// Figure 10: both grids of views.
    pub grids: Vec<GridRow>,
    /// Stretch of the parameterisation.
    pub parameterisation: brdfc_flat_btf::parameterise::SurfaceParameterisationReport,
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// Results of the paper.
    pub paper: PaperModel,
}

/// Table 1: difference in L*a*b* between BTF images computed directly and images rebuilt by equation 1 from the
/// contents of packs, at the sampled views and lights. Holes are filled by Poisson inpainting unless stated otherwise.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ReconstructionRow {
    /// Through the indirection map, whose views are blended as by a shader.
    pub through_map: ImageErrors,
    /// With exact rays instead of the map: errors of the flat BTF alone.
    pub exact_rays: ImageErrors,
    /// Mean through the map with compact samples.
    pub mean_compact: f64,
    /// Mean through the map, holes filled by push-pull.
    pub mean_push_pull: f64,
    /// Mean with a map that contains each view, which excludes errors of blending the map's views.
    pub mean_unblended: f64,
    /// By polar angle of the view, from above to the side.
    pub angles: Vec<AngleErrors>,
}

/// Differences of rebuilt images, in L*a*b*.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ImageErrors {
    /// Mean over all texels of all images.
    pub mean: f64,
    /// Largest mean of an image.
    pub largest_image: f64,
    /// Variance of the means of images.
    pub image_variance: f64,
    /// Largest difference of a single texel.
    pub largest_texel: f64,
}

/// Mean differences in L*a*b* over all lights and over the views within 2.5 degrees of a polar angle, a multiple of
/// five.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct AngleErrors {
    /// Mean polar angle of these views, degrees.
    pub polar_angle: f64,
    /// Number of views.
    pub views: usize,
    /// Through the indirection map.
    pub through_map: f64,
    /// With a map that contains each view, so that no views are blended.
    pub unblended: f64,
    /// With exact rays instead of the map.
    pub exact_rays: f64,
}

/// Table 2: variance over the views, in L*a*b*, mean over lights.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct CoherencyRow {
    /// Ordinary BTF.
    pub btf: Spread,
    /// Flat BTF with holes filled by push-pull.
    pub push_pull: Spread,
    /// Flat BTF with holes filled by Poisson inpainting.
    pub poisson: Spread,
    /// Flat BTF, only visible texels.
    pub visible: Spread,
}

/// Mean and maximum over texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
}
