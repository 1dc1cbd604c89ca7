//! Methods that shade surfaces under an environment: where they take samples, and the light that samples look up.

use super::case::Case;
use super::gaussians::Gaussians;
use super::split_sum::SplitSum;
use brdfc_formats::lobes::LobesPack;
use brdfc_metrics::image::LinearImage;
use brdfc_render::adaptive::{
    FilteredLight, Prediction, Settings, draw_with, resolve, shade_point, shade_point_filtered, shade_with,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Look-ups of a shaded pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LookUps {
    /// Importance samples of the material, in the environment itself.
    Samples,
    /// The same samples, in the prefiltered environment.
    FilteredSamples,
    /// Lobes, in the prefiltered environment.
    Lobes,
    /// A fitted model, in the irradiance and an environment that its lobe filters.
    SplitSum,
    /// Spherical Gaussians, in the prefiltered environment.
    Gaussians,
}

/// Pixels that are shaded. Others are interpolated from shaded ones on the same surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Density {
    /// A level of the pyramid: 0 has all pixels, 1 one of four, 2 one of 16.
    Level(i32),
    /// As dense as the predicted bandwidth requires.
    Adaptive,
}

/// A method of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// All pixels, samples.
    Forward,
    /// All pixels, filtered samples.
    Filtered,
    /// One of four pixels, samples.
    Half,
    /// One of 16 pixels, samples.
    Quarter,
    /// One of four pixels, filtered samples.
    HalfFiltered,
    /// One of 16 pixels, filtered samples.
    QuarterFiltered,
    /// All pixels, the split sum of game engines.
    SplitSum,
    /// All pixels, spherical Gaussians.
    Gaussians,
    /// All pixels, lobes.
    Lobes,
    /// One of four pixels, lobes.
    HalfLobes,
    /// Adaptive shading, samples.
    Adaptive,
    /// Adaptive shading, filtered samples.
    AdaptiveFiltered,
}

impl Method {
    /// All methods, with their names.
    pub const ALL: [(Self, &'static str); 12] = [
        (Self::Forward, "forward"),
        (Self::Filtered, "filtered"),
        (Self::Half, "half"),
        (Self::Quarter, "quarter"),
        (Self::HalfFiltered, "half, filt."),
        (Self::QuarterFiltered, "quarter, filt."),
        (Self::SplitSum, "split sum"),
        (Self::Gaussians, "Gaussians"),
        (Self::Lobes, "lobes"),
        (Self::HalfLobes, "half, lobes"),
        (Self::Adaptive, "adaptive"),
        (Self::AdaptiveFiltered, "adaptive, filt."),
    ];

    /// The methods that need neither a prediction nor an encoder of lobes.
    pub const SIMPLE: [Self; 6] =
        [Self::Forward, Self::Filtered, Self::Half, Self::Quarter, Self::HalfFiltered, Self::QuarterFiltered];

    /// The pixels that the method shades, and what it looks up there.
    pub fn parts(self) -> (Density, LookUps) {
        match self {
            Self::Forward => (Density::Level(0), LookUps::Samples),
            Self::Filtered => (Density::Level(0), LookUps::FilteredSamples),
            Self::Half => (Density::Level(1), LookUps::Samples),
            Self::Quarter => (Density::Level(2), LookUps::Samples),
            Self::HalfFiltered => (Density::Level(1), LookUps::FilteredSamples),
            Self::QuarterFiltered => (Density::Level(2), LookUps::FilteredSamples),
            Self::SplitSum => (Density::Level(0), LookUps::SplitSum),
            Self::Gaussians => (Density::Level(0), LookUps::Gaussians),
            Self::Lobes => (Density::Level(0), LookUps::Lobes),
            Self::HalfLobes => (Density::Level(1), LookUps::Lobes),
            Self::Adaptive => (Density::Adaptive, LookUps::Samples),
            Self::AdaptiveFiltered => (Density::Adaptive, LookUps::FilteredSamples),
        }
    }
}

/// Prefiltered light and lobes of a case.
#[derive(Clone, Copy)]
pub struct Prefiltered<'a> {
    /// The environment, prefiltered.
    pub light: &'a FilteredLight<'a>,
    /// Lobes of the material, from few to many.
    pub lobes: &'a [LobesPack],
    /// The split sum of a fitted model.
    pub split_sum: &'a SplitSum<'a>,
    /// Spherical Gaussians of the material, from few to many.
    pub gaussians: &'a [Gaussians],
}

/// Cost of a rendering.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// Samples of each shaded pixel; of adaptive shading the mean, see [`Settings::samples`].
    Samples(u32),
    /// The lobes, or Gaussians, of this number in [`Prefiltered`].
    Pack(usize),
}

/// Settings of a method other than its budget.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Variant {
    /// True if all points share their filtered samples, see [`FilteredLight::scattered`].
    pub shared: bool,
    /// Factor on predicted bandwidths, for adaptive shading.
    pub caution: Option<f32>,
}

/// Draws a case; also returns the number of samples, or fetches, of all pixels.
///
/// # Panics
/// Panics if there are no lobes, or Gaussians, of the budget's number.
pub fn draw(
    case: &Case<'_>,
    prefiltered: Prefiltered<'_>,
    method: Method,
    variant: Variant,
    budget: Budget,
) -> (LinearImage, u64) {
    let (density, look_ups) = method.parts();
    let (scene, buffer) = (&case.adaptive, case.buffer);
    let light = FilteredLight { scattered: !variant.shared, ..*prefiltered.light };
    let shader = |point: usize, count: u32| match (look_ups, budget) {
        (LookUps::FilteredSamples, _) => shade_point_filtered(scene, &light, buffer, point, count),
        (LookUps::Lobes, Budget::Pack(pack)) => by_lobes(case, prefiltered, &prefiltered.lobes[pack], point),
        (LookUps::Gaussians, Budget::Pack(number)) => prefiltered.gaussians[number].radiance(
            light.environment,
            buffer.frame(point).normal,
            buffer.to_viewer[point],
        ),
        (LookUps::SplitSum, _) => prefiltered.split_sum.radiance(buffer.frame(point).normal, buffer.to_viewer[point]),
        _ => shade_point(scene, buffer, point, count),
    };
    let count = match (look_ups, budget) {
        (LookUps::Gaussians, Budget::Pack(number)) => prefiltered.gaussians[number].fetches() as u32,
        (_, Budget::Pack(pack)) => prefiltered.lobes[pack].fetches() as u32,
        (_, Budget::Samples(count)) => count,
    };
    match density {
        Density::Level(level) => {
            // Unlike adaptive shading, coarse pixels get no additional samples.
            let shaded = shade_with(buffer, &Prediction::uniform(buffer, level, count), count, &shader);
            let image = resolve(scene.scene, case.frame, buffer, &shaded.radiance, 1);
            (image, shaded.levels.iter().map(|level| level.samples).sum())
        }
        Density::Adaptive => {
            let settings = case.settings();
            let caution = variant.caution.unwrap_or(settings.caution);
            let settings = Settings { samples: count as f32, caution, ..settings };
            let rendering = draw_with(scene, case.frame, buffer, &settings, &shader);
            let samples = rendering.samples();
            (rendering.image, samples)
        }
    }
}

fn by_lobes(case: &Case<'_>, prefiltered: Prefiltered<'_>, lobes: &LobesPack, point: usize) -> [f32; 3] {
    let frame = case.buffer.frame(point);
    let outgoing = frame.local(case.buffer.to_viewer[point]);
    let axes = [frame.tangent, frame.bitangent, frame.normal];
    lobes.radiance(prefiltered.light.environment, axes, outgoing)
}
