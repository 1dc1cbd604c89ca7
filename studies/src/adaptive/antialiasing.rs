//! Time of adaptive shading by the number of samples, and cost of antialiasing by finer levels of the pyramid (figure 10 of
//! Bagher et al. 2012).

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
/// Mean samples per pixel of the renderings whose time is compared with the number of samples.
const BUDGETS: [f32; 5] = [8.0, 16.0, 32.0, 64.0, 128.0];

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
fn exponents(rows: &[AntialiasingRow]) -> Option<Exponents> {
    let (first, last) = (rows.first()?, rows.last()?);
    let steps = (f64::from(last.points) / f64::from(first.points)).ln();
    let of = |cost: fn(&AntialiasingRow) -> f64| (cost(last) / cost(first)).ln() / steps;
    Some(Exponents {
        shaded: of(|row| row.shaded as f64),
        samples: of(|row| row.samples as f64),
        seconds: of(|row| row.seconds),
    })
}

/// Seconds as a linear function of samples, by least squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Line {
    /// Seconds without samples: the bandwidth buffer, and the passes.
    pub seconds: f64,
    /// Seconds for each sample.
    pub seconds_per_sample: f64,
    /// Largest difference of a rendering's seconds from the line, relative to them.
    pub error: f64,
}

/// The line through the rows with the least squares of relative differences.
fn line(rows: &[AntialiasingRow]) -> Option<Line> {
    // Weights of 1/s² make differences relative.
    let sum = |of: &dyn Fn(f64, f64) -> f64| {
        rows.iter().map(|row| of(row.samples as f64, row.seconds) / row.seconds.powi(2)).sum::<f64>()
    };
    let (one, n, nn) = (sum(&|_, _| 1.0), sum(&|n, _| n), sum(&|n, _| n * n));
    let (s, ns) = (sum(&|_, s| s), sum(&|n, s| n * s));
    let determinant = one * nn - n * n;
    if rows.len() < 2 || determinant <= 0.0 {
        return None;
    }
    let seconds = (s * nn - n * ns) / determinant;
    let seconds_per_sample = (one * ns - n * s) / determinant;
    let of = |row: &AntialiasingRow| (seconds + seconds_per_sample * row.samples as f64) / row.seconds - 1.0;
    Some(Line { seconds, seconds_per_sample, error: rows.iter().map(|row| of(row).abs()).fold(0.0, f64::max) })
}

/// Draws the same rendering with 1, 4 and 16 points per pixel, at the default exposure, and with 1 point for increasing
/// budgets of samples.
pub fn antialiasing_study(
    material: &StudyMaterial<'_>,
    shape: Builtin,
    lighting: &Lighting,
    frame: Frame,
    budget: f32,
) -> AntialiasingStudy {
    let scene = Scene { environment: lighting.environment.clone(), ..shape.scene() };
    let reflectance = SourceReflectance(material.source);
    let materials = vec![material.lookups.material(&reflectance); scene.parts.len()];
    let adaptive = AdaptiveScene { scene: &scene, light: &lighting.light, materials: &materials };
    let buffer = |levels: u32| GBuffer::new(&scene, Frame { samples: 1 << levels, ..frame });
    let white = (1.0 / auto_exposure(&forward(&adaptive, frame, &buffer(0), EXPOSURE_SAMPLES))) as f32;
    let one = |levels: u32, samples: f32| {
        let buffer = buffer(levels);
        let settings = Settings { samples, antialiasing_levels: levels, white, ..Settings::default() };
        let started = Instant::now();
        let rendering = draw(&adaptive, frame, &buffer, &settings);
        let seconds = started.elapsed().as_secs_f64();
        AntialiasingRow { points: 1 << (2 * levels), shaded: rendering.shaded(), samples: rendering.samples(), seconds }
    };
    let rows: Vec<AntialiasingRow> = (0..3).map(|levels| one(levels, budget)).collect();
    let budgets: Vec<AntialiasingRow> = BUDGETS.iter().map(|samples| one(0, *samples)).collect();
    AntialiasingStudy {
        material: material.name.clone(),
        shape: shape.name().to_owned(),
        exponents: exponents(&rows),
        line: line(&budgets),
        rows,
        budgets,
    }
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
    /// 1 point per pixel, with increasing numbers of samples.
    pub budgets: Vec<AntialiasingRow>,
    /// Time of these renderings by their samples.
    pub line: Option<Line>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_linear_times_and_no_others() {
        let row = |samples: u64, seconds: f64| AntialiasingRow { points: 1, shaded: 1, samples, seconds };
        let of = |time: fn(f64) -> f64| line(&[100, 200, 400, 800].map(|n| row(n, time(n as f64)))).unwrap();
        let found = of(|n| 0.5 + 0.01 * n);
        assert!((found.seconds - 0.5).abs() < 1e-9 && (found.seconds_per_sample - 0.01).abs() < 1e-9, "{found:?}");
        assert!(found.error < 1e-9);
        assert!(of(|n| 1e-4 * n * n).error > 0.3, "the control: a square");
        assert_eq!(line(&[row(100, 1.0)]), None);
    }
}
