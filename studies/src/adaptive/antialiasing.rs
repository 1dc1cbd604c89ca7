//! Cost of antialiasing by finer levels of the pyramid (figure 10, right, of Bagher et al. 2012).

use super::case::{Lighting, StudyMaterial};
use brdfc_metrics::image::auto_exposure;
use brdfc_render::adaptive::{AdaptiveScene, Settings, draw, forward};
use brdfc_render::gbuffer::GBuffer;
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::SourceReflectance;
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Samples of the rendering that determines the exposure.
const EXPOSURE_SAMPLES: u32 = 16;

/// Result for one number of points per pixel.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AntialiasingRow {
    /// Points per pixel: 1, 4 and 16.
    pub points: u32,
    /// Shaded pixels of all levels.
    pub shaded: u64,
    /// Samples of incident light.
    pub samples: u64,
    /// Seconds of bandwidth and shading, without the G-buffer.
    pub seconds: f64,
}

/// Exponents `e` of cost ∝ points^e from 1 to 16 points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Exponents {
    /// Exponent for shaded pixels.
    pub shaded: f64,
    /// Exponent for samples of incident light.
    pub samples: f64,
    /// Exponent for seconds.
    pub seconds: f64,
}

/// Exponents from the first row to the last.
pub fn exponents(rows: &[AntialiasingRow]) -> Option<Exponents> {
    let (first, last) = (rows.first()?, rows.last()?);
    let steps = (f64::from(last.points) / f64::from(first.points)).ln();
    let of = |cost: fn(&AntialiasingRow) -> f64| (cost(last) / cost(first)).ln() / steps;
    Some(Exponents {
        shaded: of(|row| row.shaded as f64),
        samples: of(|row| row.samples as f64),
        seconds: of(|row| row.seconds),
    })
}

/// Draws the same rendering with 1, 4 and 16 points per pixel, at the default exposure.
pub fn antialiasing_study(
    material: &StudyMaterial<'_>,
    shape: Builtin,
    lighting: &Lighting,
    frame: Frame,
    budget: f32,
) -> Vec<AntialiasingRow> {
    let scene = Scene { environment: lighting.environment.clone(), ..shape.scene() };
    let reflectance = SourceReflectance(material.source);
    let materials = vec![material.lookups.material(&reflectance); scene.parts.len()];
    let adaptive = AdaptiveScene { scene: &scene, light: &lighting.light, materials: &materials };
    let buffer = |levels: u32| GBuffer::new(&scene, Frame { samples: 1 << levels, ..frame });
    let white = (1.0 / auto_exposure(&forward(&adaptive, frame, &buffer(0), EXPOSURE_SAMPLES))) as f32;
    let one = |levels: u32| {
        let buffer = buffer(levels);
        let settings = Settings { samples: budget, antialiasing_levels: levels, white, ..Settings::default() };
        let started = Instant::now();
        let rendering = draw(&adaptive, frame, &buffer, &settings);
        let seconds = started.elapsed().as_secs_f64();
        AntialiasingRow { points: 1 << (2 * levels), shaded: rendering.shaded(), samples: rendering.samples(), seconds }
    };
    (0..3).map(one).collect()
}

/// Antialiasing of one material on one shape.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct AntialiasingStudy {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// 1, 4 and 16 points per pixel.
    pub rows: Vec<AntialiasingRow>,
    /// Growth of the cost with the number of points.
    pub exponents: Option<Exponents>,
}
