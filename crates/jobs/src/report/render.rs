//! Reports of verifications: errors of renderings of packs, by cause.

use super::gate::GateResult;
use brdfc_core::words::format_number;
use brdfc_gpu::AdapterDescription;
use brdfc_gpu::verify::Views;
use brdfc_metrics::image::{ImageDifference, LinearImage, auto_exposure, compare_images};
use brdfc_metrics::image::{PIXELS_PER_DEGREE, flip};
use brdfc_metrics::shown::{MIN_CONTRAST, Shown};
use brdfc_render::scene::Frame;
use schemars::JsonSchema;
use serde::Serialize;

/// A verification of one view.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Verification {
    /// Name of the scene.
    pub scene: String,
    /// Pixels per row.
    pub width: usize,
    /// Number of rows of pixels.
    pub height: usize,
    /// Number of samples per pixel, over both axes.
    pub samples: usize,
    /// Factor from radiance to the display's range [0, 1], for renderings and comparisons.
    pub exposure: f64,
    /// Graphics adapter that ran the shaders.
    pub adapter: AdapterDescription,
    /// Parts of the scene with their materials.
    pub parts: Vec<PartMaterial>,
    /// Bytes on a GPU of the prefiltered environment. Absent if no lobes are drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_bytes_on_gpu: Option<u64>,
    /// Share of the surfaces that is left out, as packs do not cover the directions from which it is lit or seen.
    pub left_out: f64,
    /// Total error: the shader's rendering against the CPU's from the sources. Absent without sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<ImageDifference>,
    /// Codec error: the CPU's rendering from packs against the one from sources. Absent without sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub codec: Option<ImageDifference>,
    /// Grid error: the CPU's rendering from whole, unquantised tables against the one from sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<ImageDifference>,
    /// Noise of the CPU's rendering from sources: the difference that it alone causes. It raises the errors above, but less than by
    /// this much, because the errors are independent. Absent
    /// if no random directions were used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<ImageDifference>,
    /// Shading error: the shader's rendering against the CPU's, both from packs.
    pub shading: ImageDifference,
    /// Mean FLIP over surfaces of the shader's rendering; only if a gate requires it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// Results of the requested gates.
    pub gates: Vec<GateResult>,
}

/// Limits of the error of a rendering against its reference. `None` means no limit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RenderingGates {
    /// Maximum mean ΔE (CIE76) over surfaces.
    pub delta_e: Option<f64>,
    /// Maximum 95th percentile of ΔE (CIE76) over surfaces.
    pub delta_e_p95: Option<f64>,
    /// Maximum mean FLIP over surfaces.
    pub flip: Option<f64>,
}

/// A part of the scene and its material.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PartMaterial {
    /// Name of the part in the scene.
    pub part: String,
    /// The material's name, or the input.
    pub material: String,
    /// Bytes of its pack on a GPU.
    pub bytes_on_gpu: u64,
}

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
            environment_bytes_on_gpu: None,
            left_out: views.left_out,
            total: against_source(&views.shader),
            codec: against_source(&views.pack),
            grid: views.table.as_ref().and_then(against_source),
            noise: views.source_with_noise.as_ref().and_then(against_source),
            shading: compare_images(&views.shader, &views.pack, exposure),
            flip: None,
            gates: Vec::new(),
        }
    }

    /// Checks the rendering against gates. All fail if no surface is visible or lit, or if a pixel is NaN or infinite.
    #[must_use]
    pub fn checked_by(mut self, gates: &RenderingGates, views: &Views) -> Self {
        let nothing = self.nothing_seen(views);
        if gates.flip.is_some() {
            let flip = flip(&views.shader, views.reference(), self.exposure, PIXELS_PER_DEGREE);
            self.flip = Some(flip.mean_on_surfaces);
        }
        let delta_e = self.checked().delta_e;
        let measured = [
            ("--max-delta-e", gates.delta_e, Some(delta_e.mean)),
            ("--max-delta-e-p95", gates.delta_e_p95, Some(delta_e.p95)),
            ("--max-flip", gates.flip, self.flip),
        ];
        for (name, limit, found) in measured {
            let (Some(limit), Some(found)) = (limit, found) else { continue };
            self.gates.push(match &nothing {
                Some(nothing) => GateResult::new(name, nothing, at_most(limit), false),
                None => GateResult::new(name, format!("{found:.4}"), at_most(limit), found <= limit),
            });
        }
        self
    }

    /// Reason why the rendering cannot be checked, if any.
    pub fn nothing_seen(&self, views: &Views) -> Option<String> {
        let difference = self.checked();
        if difference.pixels == 0 {
            let why = if views.left_out > 0.0 { " within the directions that packs cover" } else { "" };
            Some(format!("no visible surface{why}"))
        } else if difference.invalid_pixels > 0 {
            Some(format!("no finite values in {} pixels", difference.invalid_pixels))
        } else {
            nothing_shown(views.reference(), self.exposure)
        }
    }

    /// The difference that gates check: the total error, or the shading error without sources.
    pub fn checked(&self) -> &ImageDifference {
        self.total.as_ref().unwrap_or(&self.shading)
    }

    /// The available comparisons with their names in tables.
    pub fn rows(&self) -> Vec<(&'static str, &ImageDifference)> {
        [
            ("shader against source", self.total.as_ref()),
            ("pack against source (codec)", self.codec.as_ref()),
            ("table against source (grid)", self.grid.as_ref()),
            ("noise of the source's rendering", self.noise.as_ref()),
            ("shader against pack (shading)", Some(&self.shading)),
        ]
        .into_iter()
        .filter_map(|(name, difference)| Some((name, difference?)))
        .collect()
    }
}

fn at_most(limit: f64) -> String {
    format!("at most {limit}")
}

/// Reason why a rendering shows nothing at an exposure, if any: no light, too few pixels of surfaces that are neither black nor
/// white, or no contrast among them.
pub fn nothing_shown(image: &LinearImage, exposure: f64) -> Option<String> {
    let on_surfaces = || {
        let all = image.pixels.iter().zip(&image.coverage);
        all.filter(|(_, covered)| **covered > 0.0).map(|(pixel, _)| pixel.map(|value| exposure * f64::from(value)))
    };
    let is_lit = |pixel: [f64; 3]| pixel.iter().any(|value| *value > 0.0);
    let mut shown = Shown::default();
    for pixel in on_surfaces() {
        shown.add(pixel);
    }
    let (count, of, needed) = (shown.count, shown.of, shown.needed());
    if !on_surfaces().any(is_lit) {
        Some("no light: all surfaces are black".to_owned())
    } else if count < needed {
        let exposure = format_number(exposure);
        Some(format!(
            "no measurable surface: {count} of {of} pixels are neither black nor white at exposure {exposure}, \
             at least {needed} are needed"
        ))
    } else if shown.contrast() < MIN_CONTRAST {
        Some("no contrast: all surfaces look alike".to_owned())
    } else {
        None
    }
}
