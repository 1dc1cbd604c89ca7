//! Settings and results of the study.

use super::errors::Errors;
use serde::Serialize;

/// Settings of a study of BTFs.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfSettings {
    /// Texels per side of the images of the ordinary BTF and of the flat one: a power of two.
    pub texels: usize,
    /// Name of the set of directions, for views and lights.
    pub directions: String,
    /// Number of directions.
    pub count: usize,
    /// Lights that are held out of all methods until they are measured: indices into the set, ascending.
    pub held_out: Vec<usize>,
    /// Views that are held out where all views are stored in one asset: indices into the set, ascending.
    pub held_out_views: Vec<usize>,
}

/// Result of a method to store a BTF, made from all lights except those held out. Errors are means over all views and,
/// for flat BTFs, over the texels visible in the view.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfRow {
    /// Name of the method.
    pub method: String,
    /// Bytes of texels on a GPU, including mipmaps.
    pub bytes: u64,
    /// Share of the bytes of the polynomial texture maps of the same BTF.
    pub share: f64,
    /// Fetches of a shaded pixel whose view and light are between those of the set.
    pub fetches: f64,
    /// Mean ΔE (CIE76) at the fitted lights.
    pub delta_e: f64,
    /// Mean ΔE (CIE76) at the held-out lights.
    pub held_out_delta_e: f64,
    /// Peak signal-to-noise ratio of sRGB values at the fitted lights, dB.
    pub psnr: f64,
    /// Peak signal-to-noise ratio at the held-out lights, dB.
    pub held_out_psnr: f64,
    /// Mean ΔE at the fitted lights of texels that were left out of the fit, for methods that leave some out.
    pub held_out_texels_delta_e: Option<f64>,
    /// True if the mean ΔE at the fitted lights is at most the target: that of the polynomial texture maps, or 1.
    pub met: Option<bool>,
    /// Seconds to encode.
    pub seconds: f64,
}

/// Results of all methods for one BTF.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfAsset {
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// One row for each method.
    pub rows: Vec<BtfRow>,
}

/// Claims about polynomial wavelet trees at the error of polynomial texture maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfClaims {
    /// Bytes of the trees of the ordinary BTF, relative to its maps.
    pub classic_share: f64,
    /// True if that is at most 1/2, and the error is met.
    pub classic_met: bool,
    /// Bytes of the trees of the flat BTF, relative to the trees of the ordinary one.
    pub flat_share: f64,
    /// True if that is at most 1/2, and the error is met.
    pub flat_met: bool,
}

/// Result of a method that stores all views, made without the held-out views and lights of an ordinary BTF.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct WholeRow {
    /// Name of the method.
    pub method: String,
    /// Bytes that the method may take.
    pub budget: u64,
    /// Bytes on a GPU, including mipmaps.
    pub bytes: u64,
    /// PSNR of sRGB values at fitted views and lights, dB.
    pub psnr: f64,
    /// PSNR at fitted views and held-out lights, dB.
    pub held_out_lights_psnr: f64,
    /// PSNR at held-out views and fitted lights, dB.
    pub held_out_views_psnr: f64,
    /// PSNR at held-out views and lights, dB.
    pub held_out_both_psnr: f64,
    /// Mean ΔE (CIE76) at held-out views and lights.
    pub held_out_both_delta_e: f64,
}

/// A level of detail of trees, against means of the BTF's images over its texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MipmapRow {
    /// Level, 1 at half the size.
    pub level: u32,
    /// PSNR of sRGB values of the level, dB.
    pub psnr: f64,
    /// PSNR of the means of the whole images that the trees show, as plain mipmaps of every image would be, dB.
    pub box_psnr: f64,
}

/// Methods that store all views of an ordinary BTF in one asset, at equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct WholeBtf {
    /// Indices of the held-out views, ascending.
    pub held_out_views: Vec<usize>,
    /// One row for each method and number of bytes.
    pub rows: Vec<WholeRow>,
    /// Levels of the trees with common terms, at the first number of bytes.
    pub mipmaps: Vec<MipmapRow>,
}

/// Results for one structure.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfModel {
    /// Its address.
    pub model: String,
    /// Its ordinary BTF: images on the reference plane.
    pub classic: BtfAsset,
    /// Its flat BTF: values on the surface's own parameters.
    pub flat: BtfAsset,
    /// The ordinary BTF without some views and lights.
    pub whole: WholeBtf,
    /// Comparison with the claims.
    pub claims: BtfClaims,
}

/// A study of BTFs.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfStudy {
    /// Settings of the study.
    pub settings: BtfSettings,
    /// One for each structure.
    pub models: Vec<BtfModel>,
}

/// Running results of encoding and measuring a method, view by view.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) bytes: u64,
    pub(super) fetches: f64,
    pub(super) seconds: f64,
    pub(super) errors: Errors,
}

impl Tally {
    /// Adds a view.
    pub(super) fn add(&mut self, view: Self) {
        self.bytes += view.bytes;
        self.fetches += view.fetches;
        self.seconds += view.seconds;
        self.errors.add(view.errors);
    }

    /// Replaces the sum of fetches by the mean over this number of views, since a pixel uses only a few views.
    pub(super) fn of_views(self, views: usize) -> Self {
        Self { fetches: self.fetches / views as f64, ..self }
    }

    /// The row of a method. Its share is computed later.
    pub(super) fn row(&self, method: &str) -> BtfRow {
        let Errors { fitted, held_out } = self.errors;
        BtfRow {
            method: method.to_owned(),
            bytes: self.bytes,
            share: 1.0,
            fetches: self.fetches,
            delta_e: fitted.delta_e(),
            held_out_delta_e: held_out.delta_e(),
            psnr: fitted.psnr(),
            held_out_psnr: held_out.psnr(),
            held_out_texels_delta_e: None,
            met: None,
            seconds: self.seconds,
        }
    }
}
