//! What a verification reports: how wrong packs look, and where the error comes from.

use super::gate::GateResult;
use brdfc_core::words::format_number;
use brdfc_gpu::AdapterDescription;
use brdfc_gpu::verify::Views;
use brdfc_metrics::image::{ImageDifference, LinearImage, auto_exposure, compare_images};
use brdfc_metrics::image::{PIXELS_PER_DEGREE, flip};
use brdfc_render::scene::Frame;
use schemars::JsonSchema;
use serde::Serialize;

/// A verification of one view.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Verification {
    /// Which scene.
    pub scene: String,
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples per pixel.
    pub samples: usize,
    /// Factor from radiance to the display's range [0, 1], for renderings and comparisons.
    pub exposure: f64,
    /// What drew.
    pub adapter: AdapterDescription,
    /// Parts of the scene with their materials.
    pub parts: Vec<PartMaterial>,
    /// Share of the surfaces that is left out, as packs were not made for the directions from which it is lit or seen.
    pub left_out: f64,
    /// What a user sees: the shader's image against the CPU's from the sources. Absent without sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<ImageDifference>,
    /// Codec error: the CPU's image from packs against the one from sources. Absent without sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codec: Option<ImageDifference>,
    /// What the grid alone loses: the CPU's image from whole, unquantised tables against the one from sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<ImageDifference>,
    /// Shading error: the shader's image against the CPU's, both from packs.
    pub shading: ImageDifference,
    /// Mean FLIP over surfaces of the shader's image; only where a gate asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// What the gates saw that were asked for.
    pub gates: Vec<GateResult>,
}

/// Limits of a rendering against its reference. Those that are absent are none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RenderingGates {
    /// Largest mean ΔE*ab over surfaces.
    pub delta_e: Option<f64>,
    /// Largest 95th percentile of ΔE*ab.
    pub delta_e_p95: Option<f64>,
    /// Largest mean FLIP over surfaces.
    pub flip: Option<f64>,
}

/// Which material a part shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PartMaterial {
    /// The part's name.
    pub part: String,
    /// The material's name, or the input.
    pub material: String,
    /// Bytes of its pack on a GPU.
    pub bytes_on_gpu: u64,
}

/// Radiance times exposure below which a pixel counts as black: a fiftieth of what a display shows brightest, as a code.
const BLACK: f64 = 0.005;
/// Share of the pixels on surfaces that are to be neither black nor white. Of a mirror under a point light few are.
const SHOWN: f64 = 1e-3;
/// How many times as bright as the darkest of them the brightest is to be.
const CONTRAST: f64 = 1.02;

impl Verification {
    /// Compares views. Without an `exposure` the brightest 1 % of the reference are clipped.
    pub fn new(
        scene: &str,
        frame: Frame,
        views: &Views,
        exposure: Option<f64>,
        adapter: &AdapterDescription,
        parts: Vec<PartMaterial>,
    ) -> Self {
        let exposure = exposure.unwrap_or_else(|| auto_exposure(views.reference()));
        let against_source =
            |image: &LinearImage| views.source.as_ref().map(|source| compare_images(image, source, exposure));
        Self {
            scene: scene.to_owned(),
            width: frame.width,
            height: frame.height,
            samples: frame.samples * frame.samples,
            exposure,
            adapter: adapter.clone(),
            parts,
            left_out: views.left_out,
            total: against_source(&views.shader),
            codec: against_source(&views.pack),
            grid: views.table.as_ref().and_then(against_source),
            shading: compare_images(&views.shader, &views.pack, exposure),
            flip: None,
            gates: Vec::new(),
        }
    }

    /// Holds the rendering against gates. None passes where no surface is seen, no light falls on any, or a pixel holds no
    /// number.
    #[must_use]
    pub fn checked_by(mut self, gates: &RenderingGates, views: &Views) -> Self {
        let nothing = self.nothing_seen(views);
        if gates.flip.is_some() {
            let flip = flip(&views.shader, views.reference(), self.exposure, PIXELS_PER_DEGREE);
            self.flip = Some(flip.mean_on_surfaces);
        }
        let delta_e = self.checked().delta_e;
        let measured = [
            ("mean ΔE", gates.delta_e, Some(delta_e.mean)),
            ("95th percentile of ΔE", gates.delta_e_p95, Some(delta_e.p95)),
            ("mean FLIP", gates.flip, self.flip),
        ];
        for (name, limit, found) in measured {
            let (Some(limit), Some(found)) = (limit, found) else { continue };
            self.gates.push(match &nothing {
                Some(nothing) => GateResult::new(name, nothing, limit.to_string(), false),
                None => GateResult::new(name, format!("{found:.4}"), limit.to_string(), found <= limit),
            });
        }
        self
    }

    /// Why the rendering says nothing, if that is so.
    pub fn nothing_seen(&self, views: &Views) -> Option<String> {
        let difference = self.checked();
        if difference.pixels == 0 {
            let why = if views.left_out > 0.0 { ", of those that packs were made for" } else { "" };
            Some(format!("no pixel that shows a surface{why}"))
        } else if difference.invalid_pixels > 0 {
            Some(format!("{} pixels that hold no number", difference.invalid_pixels))
        } else {
            nothing_shown(views.reference(), self.exposure)
        }
    }

    /// What a check is made on: the total, or the shading where there are no sources.
    pub fn checked(&self) -> &ImageDifference {
        self.total.as_ref().unwrap_or(&self.shading)
    }

    /// The comparisons that there are, with what they are called in tables.
    pub fn rows(&self) -> Vec<(&'static str, &ImageDifference)> {
        [
            ("shader against source", self.total.as_ref()),
            ("pack against source (codec)", self.codec.as_ref()),
            ("table against source (grid)", self.grid.as_ref()),
            ("shader against pack (shading)", Some(&self.shading)),
        ]
        .into_iter()
        .filter_map(|(name, difference)| Some((name, difference?)))
        .collect()
    }
}

/// Why an image shows nothing at an exposure, if that is so: no light, too few pixels of surfaces that are neither black nor white, or no
/// contrast among them.
pub fn nothing_shown(image: &LinearImage, exposure: f64) -> Option<String> {
    let on_surfaces = || {
        let all = image.pixels.iter().zip(&image.coverage);
        all.filter(|(_, covered)| **covered > 0.0).map(|(pixel, _)| pixel.map(|value| exposure * f64::from(value)))
    };
    let is_lit = |pixel: [f64; 3]| pixel.iter().any(|value| *value > 0.0);
    let is_shown =
        |pixel: &[f64; 3]| pixel.iter().any(|value| *value > BLACK) && pixel.iter().any(|value| *value < 1.0);
    let shown = || on_surfaces().filter(is_shown).map(|pixel| pixel.iter().sum::<f64>());
    let of = on_surfaces().count();
    let (count, needed) = (shown().count(), (SHOWN * of as f64).ceil() as usize);
    if !on_surfaces().any(is_lit) {
        Some("no light: all surfaces are black".to_owned())
    } else if count < needed {
        let exposure = format_number(exposure);
        Some(format!(
            "{count} of {of} pixels that are neither black nor white, at exposure {exposure}; {needed} are needed"
        ))
    } else if shown().fold(0.0, f64::max) < CONTRAST * shown().fold(f64::INFINITY, f64::min) {
        Some("no contrast: all surfaces look alike".to_owned())
    } else {
        None
    }
}
