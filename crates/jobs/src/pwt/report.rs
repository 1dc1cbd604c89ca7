//! Report of `brdfc pwt`.

use super::make::{HeldOut, HeldOutViews, PwtMade};
use brdfc_formats::pwt::LightCoordinates;
use brdfc_pwt::candidates::Candidate;
use brdfc_pwt::{PwtFacts, PwtTextureFacts, Target};
use serde::Serialize;

/// Properties of a level of detail.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelReport {
    /// Number of the level, from 0 (the finest) to the last, which is the coarsest approximation of the image.
    pub level: u32,
    /// Number of subbands of its first channel.
    pub subbands: usize,
    /// Share of the image's energy in them, all channels together.
    pub energy: f64,
    /// Highest degree of the subbands; absent if all are pruned.
    pub degree: Option<u32>,
}

/// JSON report of a pack.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PwtReport {
    /// Columns and rows of the image of each view.
    pub size: [u32; 2],
    /// Number of views.
    pub views: u32,
    /// Number of lights that were fitted.
    pub lights: usize,
    /// Terms of the light: polynomials of these coordinates, or learned terms.
    pub coordinates: LightCoordinates,
    /// Highest degree of the polynomials, or the number of learned terms without their mean.
    pub degree: u32,
    /// Ridge parameter, which keeps the fit of polynomials smooth between lights; 0 for learned terms.
    pub ridge: f64,
    /// Scale of the fitted values.
    pub domain: &'static str,
    /// Condition number of the normal equations; null for learned terms.
    pub condition: Option<f64>,
    /// The best candidate of each domain and coordinates, the selected one first.
    pub tried: Vec<Candidate>,
    /// Levels of detail of polynomials, the finest first; none for learned terms, which keep all details.
    pub levels: Vec<LevelReport>,
    /// Textures, the finest first.
    pub textures: Vec<PwtTextureFacts>,
    /// Texture fetches per pixel of a view, up to three times as many between views; learned terms take `degree + 1` more for each light, for the mean and each term.
    pub fetches: u32,
    /// Bytes on a GPU, mipmaps included.
    pub bytes_on_gpu: u64,
    /// Bytes of the file.
    pub bytes_on_disk: usize,
    /// PSNR of sRGB levels at the fitted lights, dB, from rows spread over the photographs, about two
    /// million texels in all.
    pub psnr: f64,
    /// Mean ΔE (CIE76) of the same texels.
    pub delta_e: f64,
    /// Signal-to-noise ratio of leave-one-out cross-validation over the lights, from 512 texels, before pruning and rounding; null
    /// if there are too few lights.
    pub left_out_psnr: Option<f64>,
    /// Errors at held-out lights.
    pub held_out: Option<HeldOut>,
    /// Errors at held-out views.
    pub held_out_views: Option<HeldOutViews>,
    /// True if it meets its target, at held-out lights and views as well.
    pub met: bool,
}

impl PwtReport {
    /// Reports a pack for `target` in a file of `bytes_on_disk` bytes.
    pub fn new(made: &PwtMade, target: Target, bytes_on_disk: usize) -> Self {
        let encoded = &made.encoded;
        let header = encoded.pack.header();
        let taken = encoded.candidates[0];
        let all = || encoded.subbands.iter().flatten();
        let energy = |level: Option<u32>| -> f64 {
            let of = all().filter(|s| level.is_none_or(|level| s.subband.level == level));
            of.map(|s| s.energy * s.subband.rectangle.size.iter().product::<usize>() as f64).sum()
        };
        let whole = energy(None);
        let level = |level: u32| LevelReport {
            level,
            subbands: encoded.subbands[0].iter().filter(|s| s.subband.level == level).count(),
            energy: if whole > 0.0 { energy(Some(level)) / whole } else { 0.0 },
            degree: all().filter(|s| s.subband.level == level).filter_map(|s| s.degree).max(),
        };
        let facts = PwtFacts::new(&encoded.pack);
        Self {
            size: header.size,
            views: header.view_count(),
            lights: made.lights,
            coordinates: header.basis.coordinates,
            degree: header.basis.degree,
            ridge: taken.ridge,
            domain: header.domain.name(),
            condition: encoded.condition,
            tried: encoded.candidates.clone(),
            levels: if encoded.condition.is_some() { (0..=header.levels).map(level).collect() } else { Vec::new() },
            textures: facts.textures,
            fetches: facts.fetches,
            bytes_on_gpu: facts.gpu_bytes,
            bytes_on_disk,
            psnr: encoded.errors.psnr,
            delta_e: encoded.errors.delta_e,
            left_out_psnr: taken.held_out_psnr,
            held_out: made.held_out.clone(),
            held_out_views: made.held_out_views.clone(),
            met: made.missed(target).is_none(),
        }
    }
}
