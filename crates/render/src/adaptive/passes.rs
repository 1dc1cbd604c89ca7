//! The passes over the pyramid, from coarse to fine (section 3.2, figure 9 of Bagher et al. 2012).

use super::upsample::{MIN_WEIGHT, UpsamplingGuide, parents, weight};
use super::{AdaptiveScene, PointShader, Prediction, Pyramid, coarsest, shade_point};
use crate::gbuffer::GBuffer;
use rayon::prelude::*;

/// Counts of one level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct LevelCount {
    /// Pixels of the level that show a surface and are not left to finer levels.
    pub pixels: u64,
    /// Pixels among them that were shaded. The others were interpolated from the coarser level.
    pub shaded: u64,
    /// Samples of incident light.
    pub samples: u64,
}

/// Result of the passes.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadedLevels {
    /// Radiance of each point of the buffer, row by row; 0 without a surface.
    pub radiance: Vec<[f32; 3]>,
    /// Counts of each level, finest first.
    pub levels: Vec<LevelCount>,
}

/// The level in progress: a value for each computed pixel.
struct Computed {
    width: usize,
    height: usize,
    values: Vec<Option<[f32; 3]>>,
}

/// Outcome of a pixel.
enum Made {
    /// Left to a finer level, or no surface.
    Nothing,
    Upsampled([f32; 3]),
    Shaded([f32; 3], u32),
}

/// Processes the levels with importance samples of the materials, see [`shade_with`].
pub fn shade(scene: &AdaptiveScene<'_>, buffer: &GBuffer, prediction: &Prediction, most: u32) -> ShadedLevels {
    shade_with(buffer, prediction, most, &|point, count| shade_point(scene, buffer, point, count))
}

/// Processes the levels. A pixel of a level stands for a square of the buffer. Compared with the finest level that any
/// pixel of the square needs, it is shaded if this level is the same, interpolated from the coarser level if this level
/// is finer, and left out if this level is coarser. It is also shaded if no surrounding value fits.
///
/// A pixel of a level `l` above 0 gets `2^l / 2` times the samples of the most demanding pixel in its square, up to
/// `most`. Its error shows in `4^l` pixels, of which the means over the surrounding pixels leave about a quarter, and
/// the sum of squared errors is least if samples are proportional to the root of that number.
pub fn shade_with(buffer: &GBuffer, prediction: &Prediction, most: u32, shade_point: &PointShader<'_>) -> ShadedLevels {
    let coarsest = coarsest(buffer) as usize;
    let (width, height) = (buffer.width, buffer.height);
    let targets = Pyramid::new(width, height, prediction.level.clone(), coarsest, i32::min);
    let samples = Pyramid::new(width, height, prediction.samples.clone(), coarsest, u32::max);
    let points = stands_for(buffer, coarsest);
    let mut coarser: Option<Computed> = None;
    let mut levels = Vec::new();
    for level in (0..=coarsest).rev() {
        let (width, height, targets) = &targets.levels[level];
        let pixel = |at: usize| -> Made {
            let (point, level) = (points.levels[level].2[at], level as i32);
            if point == NONE || targets[at] < level {
                return Made::Nothing;
            }
            if targets[at] > level
                && let Some(coarser) = &coarser
                && let Some(value) =
                    upsampled(buffer, &points, coarser, point, [at % width, at / width], level as usize)
            {
                return Made::Upsampled(value);
            }
            let count = raised(samples.levels[level as usize].2[at], level, most);
            Made::Shaded(shade_point(point as usize, count), count)
        };
        let made: Vec<Made> = (0..width * height).into_par_iter().map(pixel).collect();
        let mut count = LevelCount::default();
        let mut values = Vec::with_capacity(made.len());
        for made in made {
            let (value, shaded) = match made {
                Made::Nothing => (None, None),
                Made::Upsampled(value) => (Some(value), None),
                Made::Shaded(value, samples) => (Some(value), Some(samples)),
            };
            count.pixels += u64::from(value.is_some());
            count.shaded += u64::from(shaded.is_some());
            count.samples += u64::from(shaded.unwrap_or(0));
            values.push(value);
        }
        levels.push(count);
        coarser = Some(Computed { width: *width, height: *height, values });
    }
    levels.reverse();
    let finest = coarser.map_or(Vec::new(), |level| level.values);
    ShadedLevels { radiance: finest.into_iter().map(Option::unwrap_or_default).collect(), levels }
}

/// `samples` times `2^level / 2` above level 0, up to the maximum.
fn raised(samples: u32, level: i32, most: u32) -> u32 {
    samples.saturating_mul(1 << (level - 1).max(0)).min(most)
}

/// Marks pixels without a surface.
const NONE: u32 = u32::MAX;

/// The representative point of the buffer for each pixel of each level: the point in the middle of its square, or else
/// the point of the first pixel of the finer level that has one.
fn stands_for(buffer: &GBuffer, coarsest: usize) -> Pyramid<u32> {
    let own = |pixel: usize| if buffer.part_at(pixel).is_some() { pixel as u32 } else { NONE };
    let finest = (0..buffer.part.len()).map(own).collect();
    let mut pyramid = Pyramid::new(buffer.width, buffer.height, finest, coarsest, |a: u32, b: u32| a.min(b));
    for (level, (width, _, points)) in pyramid.levels.iter_mut().enumerate().skip(1) {
        let half = 1usize << (level - 1);
        for (at, point) in points.iter_mut().enumerate() {
            let (x, y) = (((at % *width) << level) + half, ((at / *width) << level) + half);
            if x < buffer.width && y < buffer.height && buffer.part_at(y * buffer.width + x).is_some() {
                *point = (y * buffer.width + x) as u32;
            }
        }
    }
    pyramid
}

/// The weighted mean of the values around a pixel at the coarser level; `None` if no value fits.
fn upsampled(
    buffer: &GBuffer,
    points: &Pyramid<u32>,
    coarser: &Computed,
    point: u32,
    at: [usize; 2],
    level: usize,
) -> Option<[f32; 3]> {
    let spacing = (1u32 << (level + 1)) as f32;
    let pixel = guide_of(buffer, point as usize);
    let (mut sum, mut total) = ([0.0f32; 3], 0.0f32);
    for parent in parents(at, [coarser.width, coarser.height]) {
        let Some(value) = coarser.values[parent] else { continue };
        let point = points.levels[level + 1].2[parent];
        let w = weight(&pixel, &guide_of(buffer, point as usize), spacing);
        (0..3).for_each(|k| sum[k] += w * value[k]);
        total += w;
    }
    (total > MIN_WEIGHT).then(|| sum.map(|s| s / total))
}

fn guide_of(buffer: &GBuffer, point: usize) -> UpsamplingGuide {
    let normal = buffer.normal[point];
    let to_viewer = buffer.to_viewer[point];
    let cosine = (0..3).map(|k| normal[k] * to_viewer[k]).sum::<f32>().clamp(0.0, 1.0);
    UpsamplingGuide {
        at: [(point % buffer.width) as f32, (point / buffer.width) as f32],
        position: buffer.position[point],
        normal,
        cosine,
        across: buffer.across[point],
        part: buffer.part[point],
    }
}
