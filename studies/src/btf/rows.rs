//! Settings and figures of the study.

use super::errors::Errors;
use serde::Serialize;

/// What a study of BTFs computes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfSettings {
    /// Texels per side, of the images of the ordinary BTF and of the flat one: a power of two.
    pub texels: usize,
    /// Name of the set of directions, for views and lights.
    pub directions: String,
    /// How many these are.
    pub count: usize,
    /// Lights that no way sees before it is measured: indices into the set, ascending.
    pub held_out: Vec<usize>,
}

/// A way to store a BTF, made of all lights but those held out. Errors are means over all views and, of flat BTFs, over texels
/// where they are seen in the view.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfRow {
    /// What it is.
    pub method: String,
    /// Bytes of texels on a GPU, mipmaps included.
    pub bytes: u64,
    /// Of those of the polynomial texture maps of the same BTF.
    pub share: f64,
    /// Fetches of a shaded pixel whose view and light lie between those of the set.
    pub fetches: f64,
    /// Mean ΔE (CIE76) at the fitted lights.
    pub delta_e: f64,
    /// The same at the lights held out.
    pub held_out_delta_e: f64,
    /// Peak signal-to-noise ratio of sRGB codes at the fitted lights, dB.
    pub psnr: f64,
    /// The same at the lights held out.
    pub held_out_psnr: f64,
    /// Mean ΔE at the fitted lights of texels that the fit has not seen, where some were left out of it.
    pub held_out_texels_delta_e: Option<f64>,
    /// Whether the mean ΔE at the fitted lights is at most what was asked for: that of the polynomial texture maps, or 1.
    pub met: Option<bool>,
    /// Seconds to make it.
    pub seconds: f64,
}

/// All ways to store one BTF.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfAsset {
    /// Share of texels that a view sees, mean over the views.
    pub seen: f64,
    /// One for each way.
    pub rows: Vec<BtfRow>,
}

/// What was wanted of polynomial wavelet trees at the error of polynomial texture maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfClaims {
    /// Bytes of the trees of the ordinary BTF over those of its maps.
    pub classic_share: f64,
    /// Whether that is at most 1/2, and the error met.
    pub classic_met: bool,
    /// Bytes of the trees of the flat BTF over those of the trees of the ordinary one.
    pub flat_share: f64,
    /// Whether that is at most 1/2, and the error met.
    pub flat_met: bool,
}

/// A structure.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfModel {
    /// Its address.
    pub model: String,
    /// Its ordinary BTF: images on the reference plane.
    pub classic: BtfAsset,
    /// Its flat BTF: values on the surface's own parameters.
    pub flat: BtfAsset,
    /// What was wanted.
    pub claims: BtfClaims,
}

/// A study of BTFs.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BtfStudy {
    /// What was computed.
    pub settings: BtfSettings,
    /// One for each structure.
    pub models: Vec<BtfModel>,
}

/// What making and measuring a way has found so far, view by view.
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

    /// With the mean over so many views in place of the sum of fetches: a pixel takes those of a few views alone.
    pub(super) fn of_views(self, views: usize) -> Self {
        Self { fetches: self.fetches / views as f64, ..self }
    }

    /// The row; of what it is a share is known later.
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
