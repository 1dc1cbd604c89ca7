//! What `brdfc pwt` says.

use super::make::{HeldOut, PwtMade};
use brdfc_formats::pwt::LightCoordinates;
use brdfc_pwt::choose::Candidate;
use brdfc_pwt::{PwtFacts, PwtTextureFacts, Target};
use serde::Serialize;

/// What is worth knowing of a level of detail.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelReport {
    /// 0 is the finest; the last one is what remains of the picture.
    pub level: u32,
    /// Subbands of its first channel.
    pub subbands: usize,
    /// Share of the picture's energy that they have, all channels together.
    pub energy: f64,
    /// Highest degree of any of them; none where all are pruned.
    pub degree: Option<u32>,
}

/// What `--json` prints of a pack that was made.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PwtReport {
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// Lights that were fitted.
    pub lights: usize,
    /// In what the terms are polynomials.
    pub coordinates: LightCoordinates,
    /// Highest degree.
    pub degree: u32,
    /// Ridge that keeps the fit smooth where no light is.
    pub ridge: f64,
    /// The scale of values that were fitted.
    pub domain: &'static str,
    /// Condition number of the normal equations.
    pub condition: f64,
    /// The best of each domain and coordinates that were tried, the one taken first.
    pub tried: Vec<Candidate>,
    /// Levels of detail, the finest first.
    pub levels: Vec<LevelReport>,
    /// Textures, the finest first.
    pub textures: Vec<PwtTextureFacts>,
    /// Fetches of a pixel.
    pub fetches: u32,
    /// Bytes on a GPU, mipmaps included.
    pub bytes_on_gpu: u64,
    /// Bytes of the file.
    pub bytes_on_disk: usize,
    /// Peak signal-to-noise ratio of sRGB codes at the lights that were fitted, dB; of rows spread over the photographs, about
    /// two million texels in all.
    pub psnr: f64,
    /// Mean ΔE (CIE76) there.
    pub delta_e: f64,
    /// Signal-to-noise ratio at each light left out in turn, of 512 texels, before pruning and rounding; null where so few
    /// lights do not tell.
    pub left_out_psnr: Option<f64>,
    /// Errors at lights that were held out.
    pub held_out: Option<HeldOut>,
    /// Whether it meets what was asked for, at lights that were held out, too.
    pub met: bool,
}

impl PwtReport {
    /// Of what was made for a target, and the bytes of its file.
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
            lights: made.lights,
            coordinates: header.basis.coordinates,
            degree: header.basis.degree,
            ridge: taken.ridge,
            domain: header.domain.name(),
            condition: encoded.condition,
            tried: encoded.candidates.clone(),
            levels: (0..=header.levels).map(level).collect(),
            textures: facts.textures,
            fetches: facts.fetches,
            bytes_on_gpu: facts.gpu_bytes,
            bytes_on_disk,
            psnr: encoded.errors.psnr,
            delta_e: encoded.errors.delta_e,
            left_out_psnr: taken.held_out_psnr,
            held_out: made.held_out.clone(),
            met: made.missed(target).is_none(),
        }
    }
}
