//! The terrain with and without levels of detail (section 6.3 and figure 10 of Claustres et al. 2007).

use crate::metrics::image::{LinearImage, auto_exposure, luminance};
use crate::render::gpu::{AdapterDescription, Decoding, Gpu, GpuError, Renderer, SliceFilter};
use crate::render::scene::{Camera, Frame, Scene};
use crate::render::scenes::Builtin;
use brdfc_formats::pack::{DEFAULT_DISTANCE_SCALE, Filter, WaveletPack};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Frames of the animation.
pub const FRAMES: usize = 6;
/// Units that the camera moves back between two frames.
const STEP: f64 = 1.5;
/// Pixels of a frame.
const FRAME: Frame = Frame { width: 512, height: 288, samples: 1 };
/// Samples per pixel and axis of the frames that flicker is measured against.
const SMOOTH_SAMPLES: usize = 8;
/// Runs of a timing, of which the fastest counts.
const RUNS: usize = 5;
/// Speed-ups against the finest level that the paper prints, from the second finest down.
const PAPER: [f64; 4] = [1.3, 1.8, 2.7, 5.7];

/// What levels of detail gain.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelOfDetail {
    /// What drew.
    pub adapter: AdapterDescription,
    /// Pixels of a frame.
    pub size: [usize; 2],
    /// Pixels of the first frame that show terrain, each shaded at least once.
    pub shaded: usize,
    /// Triangles.
    pub triangles: usize,
    /// A row for each level, the finest first.
    pub levels: Vec<LevelTime>,
    /// Seconds of a frame with bilinear filtering, level by distance.
    pub seconds_by_distance: f64,
    /// Flicker without levels of detail: over six frames moving away, the variance of the difference in luminance
    /// (of the display, 0 to 1) from smooth frames with 64 samples per pixel; the mean over pixels.
    pub flicker_finest: f64,
    /// The same, level by distance.
    pub flicker_by_distance: f64,
    /// Mean luminance of the display of all frames: finest, by distance, smooth.
    pub luminance: [f64; 3],
}

/// Time of one level.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelTime {
    /// Level of detail, for all pixels.
    pub level: u32,
    /// Texture fetches of a pixel, nearest and bilinear.
    pub fetches: [u32; 2],
    /// Seconds of a frame, nearest and bilinear.
    pub seconds: [f64; 2],
    /// How many times faster than the finest level, nearest and bilinear.
    pub speed_up: [f64; 2],
    /// What the paper prints at as many levels below its finest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// Frames of the animation, for pictures.
pub struct Animation {
    /// Finest level, one sample per pixel.
    pub finest: Vec<LinearImage>,
    /// Level by distance, one sample per pixel.
    pub by_distance: Vec<LinearImage>,
    /// Finest level, 64 samples per pixel.
    pub smooth: Vec<LinearImage>,
    /// Factor from radiance to the display's range.
    pub exposure: f64,
}

/// Measures a pack on the terrain. `progress` hears what is done.
///
/// # Errors
/// What the driver reports.
pub fn level_of_detail(
    gpu: &Gpu,
    pack: &WaveletPack,
    progress: impl Fn(&str),
) -> Result<(LevelOfDetail, Animation), GpuError> {
    let renderer = Renderer::new(gpu)?;
    let scene = Builtin::Terrain.scene();
    let decoding = |filter, level| Decoding {
        filter,
        slices: SliceFilter::Hardware,
        level,
        distance_scale: DEFAULT_DISTANCE_SCALE,
    };
    let finest = pack.header.levels;
    let load = |filter, level| renderer.load(&scene, &[pack], decoding(filter, level));
    let time = |filter, level| -> Result<f64, GpuError> {
        let loaded = load(filter, level)?;
        let target = renderer.target(FRAME.width, FRAME.height)?;
        let mut best = f64::INFINITY;
        for run in 0..=RUNS {
            let start = Instant::now();
            renderer.draw_sample(&loaded, &scene.camera, &target, [0, 0], 1)?;
            if run > 0 {
                best = best.min(start.elapsed().as_secs_f64());
            }
        }
        Ok(best)
    };
    let mut levels: Vec<LevelTime> = Vec::new();
    for level in (0..=finest).rev() {
        let seconds = [time(Filter::Slices, Some(level as f32))?, time(Filter::Bilinear, Some(level as f32))?];
        let slowest = levels.first().map_or(seconds, |first| first.seconds);
        levels.push(LevelTime {
            level,
            fetches: [4 * level + 1, 4 * (4 * level + 1)],
            seconds,
            speed_up: [slowest[0] / seconds[0], slowest[1] / seconds[1]],
            paper: (finest - level).checked_sub(1).and_then(|below| PAPER.get(below as usize).copied()),
        });
        progress(&format!("level {level} timed"));
    }
    let seconds_by_distance = time(Filter::Bilinear, None)?;

    let animate = |level, samples| -> Result<Vec<LinearImage>, GpuError> {
        let loaded = load(Filter::Bilinear, level)?;
        let frame = Frame { samples, ..FRAME };
        (0..FRAMES).map(|k| renderer.draw(&loaded, &moved(&scene, k), frame)).collect()
    };
    let finest_level = Some(finest as f32);
    let smooth = animate(finest_level, SMOOTH_SAMPLES)?;
    progress("smooth frames drawn");
    let exposure = auto_exposure(&smooth[0]);
    let animation = Animation { finest: animate(finest_level, 1)?, by_distance: animate(None, 1)?, smooth, exposure };
    let result = LevelOfDetail {
        adapter: gpu.description().clone(),
        size: [FRAME.width, FRAME.height],
        shaded: animation.finest[0].coverage.iter().filter(|c| **c > 0.0).count(),
        triangles: scene.parts.iter().map(|part| part.mesh.triangles.len()).sum(),
        levels,
        seconds_by_distance,
        flicker_finest: flicker(&animation.finest, &animation.smooth, exposure),
        flicker_by_distance: flicker(&animation.by_distance, &animation.smooth, exposure),
        luminance: [&animation.finest, &animation.by_distance, &animation.smooth]
            .map(|frames| mean_luminance(frames, exposure)),
    };
    Ok((result, animation))
}

/// The camera of frame `k`: moved back along the horizontal part of its direction.
fn moved(scene: &Scene, k: usize) -> Camera {
    let camera = scene.camera;
    let (_, _, forward) = camera.basis();
    let length = forward[0].hypot(forward[2]);
    let back = -STEP * k as f64 / length;
    let shift = |v: [f64; 3]| [v[0] + back * forward[0], v[1], v[2] + back * forward[2]];
    Camera { eye: shift(camera.eye), target: shift(camera.target), ..camera }
}

fn display_luminance(pixel: [f32; 3], exposure: f64) -> f64 {
    (luminance(pixel) * exposure).clamp(0.0, 1.0)
}

/// Mean over pixels that show a surface in every frame of the variance over frames of `frame - smooth`.
pub fn flicker(frames: &[LinearImage], smooth: &[LinearImage], exposure: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for pixel in 0..frames[0].pixels.len() {
        if smooth.iter().any(|image| image.coverage[pixel] < 1.0) {
            continue;
        }
        let residual = |(frame, smooth): (&LinearImage, &LinearImage)| {
            display_luminance(frame.pixels[pixel], exposure) - display_luminance(smooth.pixels[pixel], exposure)
        };
        let residuals: Vec<f64> = frames.iter().zip(smooth).map(residual).collect();
        let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
        sum += residuals.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / residuals.len() as f64;
        count += 1;
    }
    if count == 0 { 0.0 } else { sum / count as f64 }
}

fn mean_luminance(frames: &[LinearImage], exposure: f64) -> f64 {
    let all: Vec<f64> = frames
        .iter()
        .flat_map(|frame| frame.pixels.iter().zip(&frame.coverage))
        .filter(|(_, coverage)| **coverage > 0.0)
        .map(|(pixel, _)| display_luminance(*pixel, exposure))
        .collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(value: f32) -> LinearImage {
        LinearImage { width: 1, height: 1, pixels: vec![[value; 3]], coverage: vec![1.0], background: [0.0; 3] }
    }

    #[test]
    fn steady_frames_do_not_flicker_even_when_they_are_wrong() {
        let frames = [image(0.3), image(0.3), image(0.3)];
        assert!(flicker(&frames, &frames, 1.0) < 1e-12);
        assert!(flicker(&frames, &[image(0.5), image(0.5), image(0.5)], 1.0) < 1e-12);
    }

    #[test]
    fn the_variance_is_that_of_the_residual() {
        let smooth = [image(0.2), image(0.4)];
        let frames = [image(0.3), image(0.3)];
        assert!((flicker(&frames, &smooth, 1.0) - 0.01).abs() < 1e-6);
    }
}
