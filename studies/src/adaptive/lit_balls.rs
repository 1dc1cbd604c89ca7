//! Balls of a material in the kinds of environments that lobes are fitted to, for fits of other models to the same light.

use super::case::{Case, Lighting, StudyMaterial, TruthSamples};
use super::least_squares::Column;
use brdfc_formats::direction::dot;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_metrics::lab::lab;
use brdfc_render::adaptive::Start;
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use rayon::prelude::*;

/// Pixels along each side of a ball's rendering: about as many points as the fit of lobes has views.
const SIDE: usize = 48;
/// Samples of each pixel of a ball's ground truth.
const SAMPLES: usize = 256;

/// An environment, as it is and prefiltered.
pub struct Light {
    /// Name in reports.
    pub name: String,
    /// The environment with its bandwidth.
    pub lighting: Lighting,
    /// The environment, prefiltered.
    pub filtered: EnvironmentDecoder,
}

/// Directions at which models of isotropic materials look light up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Normal of the surface, a unit vector in the frame of the environment.
    pub normal: [f32; 3],
    /// Direction to the viewer, mirrored at the normal.
    pub mirrored: [f32; 3],
    /// Cosine between viewer and normal, 0 to 1.
    pub cosine: f64,
}

impl View {
    /// The view for unit vectors.
    pub fn new(normal: [f32; 3], to_viewer: [f32; 3]) -> Self {
        let cosine = dot(normal.map(f64::from), to_viewer.map(f64::from));
        let mirrored = [0, 1, 2].map(|k| (2.0 * cosine * f64::from(normal[k]) - f64::from(to_viewer[k])) as f32);
        Self { normal, mirrored, cosine: cosine.clamp(0.0, 1.0) }
    }
}

/// Points of a material on balls, with the light that they reflect in units of visible error.
pub struct LitBalls<'a> {
    points: Vec<Point<'a>>,
    /// Reflected light.
    pub target: Column,
}

struct Point<'a> {
    environment: &'a EnvironmentDecoder,
    view: View,
    /// Change of L*a*b* per change of a channel.
    scale: [f32; 3],
}

impl<'a> LitBalls<'a> {
    /// Draws a ball in each environment.
    pub fn new(material: &StudyMaterial<'_>, lights: &'a [Light]) -> Self {
        let frame = Frame { width: SIDE, height: SIDE, samples: 1 };
        let truth = TruthSamples::Fixed(SAMPLES, Start::Scattered);
        let mut all = Self { points: Vec::new(), target: Vec::new() };
        for light in lights {
            Case::with(material, &Builtin::Sphere.scene(), &light.lighting, frame, truth, |case| all.add(case, light));
        }
        all
    }

    fn add(&mut self, case: &Case<'_>, light: &'a Light) {
        let buffer = case.buffer;
        for pixel in (0..buffer.part.len()).filter(|pixel| buffer.part_at(*pixel).is_some()) {
            let radiance = case.truth.pixels[pixel];
            let scale = visibility(radiance.map(|c| c * case.exposure as f32)).map(|v| v * case.exposure as f32);
            let view = View::new(buffer.frame(pixel).normal, buffer.to_viewer[pixel]);
            self.points.push(Point { environment: &light.filtered, view, scale });
            self.target.push([0, 1, 2].map(|k| radiance[k] * scale[k]));
        }
    }

    /// Light that look-ups of all points give, in units of visible error.
    pub fn columns<const N: usize>(
        &self,
        look_up: impl Fn(&EnvironmentDecoder, &View) -> [[f32; 3]; N] + Sync,
    ) -> [Column; N] {
        let of = |point: &Point<'_>| {
            look_up(point.environment, &point.view).map(|light| [0, 1, 2].map(|k| light[k] * point.scale[k]))
        };
        let rows: Vec<[[f32; 3]; N]> = self.points.par_iter().map(of).collect();
        std::array::from_fn(|column| rows.iter().map(|row| row[column]).collect())
    }
}

/// Visible change per change of a channel of an exposed colour: the length of the derivative of L*a*b*. The fit of
/// lobes has a smooth approximation of it. Above white, it falls as below: by the power of 2/3.
fn visibility(colour: [f32; 3]) -> [f32; 3] {
    const STEP: f32 = 1e-3;
    const WHITE: f32 = 1.0 - STEP;
    let brightest = colour.into_iter().fold(WHITE, f32::max) / WHITE;
    let shown = colour.map(|c| c.max(0.0) / brightest);
    let here = lab(shown);
    [0, 1, 2].map(|k| {
        let mut changed = shown;
        changed[k] += STEP;
        let there = lab(changed);
        let squares: f32 = here.iter().zip(there).map(|(a, b)| (b - a) * (b - a)).sum();
        squares.sqrt() / STEP * brightest.powf(-2.0 / 3.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_errors_are_more_visible_and_white_is_no_border() {
        let of = |value: f32| visibility([value; 3])[1];
        assert!(of(0.02) > 2.0 * of(0.2) && of(0.2) > 2.0 * of(0.9), "{} {} {}", of(0.02), of(0.2), of(0.9));
        assert!((of(1.01) / of(0.99) - 1.0).abs() < 0.02, "{} {}", of(0.99), of(1.01));
        assert!((of(8.0) / of(1.0) - 0.25).abs() < 0.01, "{} {}", of(8.0), of(1.0));
    }

    #[test]
    fn views_are_mirrored_at_the_normal() {
        let view = View::new([0.0, 1.0, 0.0], [0.6, 0.8, 0.0]);
        let expected = [-0.6, 0.8, 0.0];
        assert!((0..3).all(|k| (view.mirrored[k] - expected[k]).abs() < 1e-6), "{view:?}");
        assert!((view.cosine - 0.8).abs() < 1e-6);
        assert_eq!(View::new([0.0, 1.0, 0.0], [0.8, -0.6, 0.0]).cosine, 0.0);
    }
}
