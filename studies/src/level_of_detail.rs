//! The terrain with and without levels of detail (section 6.3 and figure 10 of Claustres et al. 2007).

use brdfc_formats::BrdfPack;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::{AdapterDescription, Decoding, Gpu, GpuError, LoadedScene, Renderer, SliceFilter};
use brdfc_metrics::image::{LinearImage, auto_exposure, luminance};
use brdfc_render::scene::{Camera, Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shading_point::ShadingPoint;
use brdfc_render::trace::{Hit, trace};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// Frames of the animation.
pub const FRAMES: usize = 6;
/// Units that the camera moves back between two frames.
const STEP: f64 = 0.3;
/// Minimum distance at which flicker is measured: a step of the camera moves the terrain there by less than a pixel, so
/// that smooth renderings hardly change.
const FAR: f64 = 60.0;
/// Pixels of a frame, and of a small one.
const FRAME: Frame = Frame { width: 512, height: 288, samples: 1 };
const SMALL: Frame = Frame { width: 128, height: 72, samples: 1 };
/// Samples per pixel and axis of the reference frames with minimal flicker.
const SMOOTH_SAMPLES: usize = 4;
/// Number of runs of a timing, of which the fastest counts.
const RUNS: usize = 5;
/// Speed-ups against the finest level that the paper prints, from the second finest down.
const PAPER: [f64; 4] = [1.3, 1.8, 2.7, 5.7];

/// Effect of levels of detail.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LevelOfDetail {
    /// Adapter that drew the frames.
    pub adapter: AdapterDescription,
    /// Pixels of a frame.
    pub size: [usize; 2],
    /// Pixels of the first frame that show terrain, each shaded at least once.
    pub shaded: usize,
    /// Triangles.
    pub triangles: usize,
    /// Lights, each of which costs one evaluation per pixel.
    pub lights: usize,
    /// A row for each level, the finest first.
    pub levels: Vec<LevelTime>,
    /// Seconds of a frame without lights: triangles and pixels alone.
    pub seconds_without_light: f64,
    /// Seconds of a frame with bilinear filtering, level by distance.
    pub seconds_by_distance: f64,
    /// Finest level for all pixels, one sample per pixel.
    pub finest: Flicker,
    /// Level by distance, one sample per pixel.
    pub by_distance: Flicker,
    /// Finest level, 16 samples per pixel: flicker of the scene itself.
    pub smooth: Flicker,
}

/// Changes from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Flicker {
    /// Variance of the display's luminance (0 to 1) over six frames moving away, mean over pixels
    /// that show terrain from 60 units away.
    pub variance: f64,
    /// Mean luminance of the display.
    pub luminance: f64,
    /// Variance divided by the squared mean, independent of brightness.
    pub relative: f64,
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
    /// Speed-up relative to the finest level, nearest and bilinear, after subtracting the time of frames without
    /// lights.
    pub speed_up: [f64; 2],
    /// Mean luminance of the display over pixels that show terrain from 60 units away, if all pixels have this level.
    pub luminance: f64,
    /// Speed-up in the paper, at the same number of levels below its finest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// Frames of the animation, for image files.
pub struct Animation {
    /// Finest level, one sample per pixel.
    pub finest: Vec<LinearImage>,
    /// Level by distance, one sample per pixel.
    pub by_distance: Vec<LinearImage>,
    /// Finest level, 16 samples per pixel.
    pub smooth: Vec<LinearImage>,
    /// Factor from radiance to the display's range.
    pub exposure: f64,
}

/// Measures a pack on the terrain, with few pixels if `small`. Calls `progress` with a description of each finished
/// step.
///
/// # Errors
/// Returns an error that the driver reports.
pub fn level_of_detail(
    gpu: &Gpu,
    pack: &BrdfPack,
    small: bool,
    progress: impl Fn(&str),
) -> Result<(LevelOfDetail, Animation), GpuError> {
    let frame = if small { SMALL } else { FRAME };
    let finest = pack.levels();
    let renderer = Renderer::new(gpu)?;
    let scene = Builtin::Terrain.scene();
    let decoding = |filter, level| Decoding {
        filter,
        slices: SliceFilter::Hardware,
        level,
        distance_scale: DEFAULT_DISTANCE_SCALE,
    };
    let load = |filter, level| renderer.load(&scene, &[pack], decoding(filter, level));
    let time_of = |loaded: &LoadedScene| -> Result<f64, GpuError> {
        let target = renderer.target(frame.width, frame.height)?;
        let mut best = f64::INFINITY;
        for run in 0..=RUNS {
            let start = Instant::now();
            renderer.draw_sample(loaded, &scene.camera, &target, [0, 0], 1)?;
            if run > 0 {
                best = best.min(start.elapsed().as_secs_f64());
            }
        }
        Ok(best)
    };
    let time = |filter, level| time_of(&load(filter, level)?);
    let animate = |level, samples| -> Result<Vec<LinearImage>, GpuError> {
        let loaded = load(Filter::Bilinear, level)?;
        let frame = Frame { samples, ..frame };
        (0..FRAMES).map(|k| renderer.draw(&loaded, &moved(&scene, k), frame)).collect()
    };
    let finest_level = Some(finest as f32);
    let smooth = animate(finest_level, SMOOTH_SAMPLES)?;
    progress("smooth frames drawn");
    let exposure = auto_exposure(&smooth[0]);
    let far = far_pixels(&scene, frame);
    let dark = Scene { lights: Vec::new(), ..scene.clone() };
    let seconds_without_light = time_of(&renderer.load(&dark, &[pack], decoding(Filter::Slices, None))?)?;
    let mut levels: Vec<LevelTime> = Vec::new();
    for level in (0..=finest).rev() {
        let seconds = [time(Filter::Slices, Some(level as f32))?, time(Filter::Bilinear, Some(level as f32))?];
        let slowest = levels.first().map_or(seconds, |first| first.seconds);
        levels.push(LevelTime {
            level,
            fetches: [Filter::Slices, Filter::Bilinear].map(|filter| pack.fetches_at(level, filter)),
            seconds,
            speed_up: [0, 1].map(|k| (slowest[k] - seconds_without_light) / (seconds[k] - seconds_without_light)),
            luminance: flicker(&animate(Some(level as f32), 1)?, &far, exposure).luminance,
            paper: (finest - level).checked_sub(1).and_then(|below| PAPER.get(below as usize).copied()),
        });
        progress(&format!("level {level} timed and drawn"));
    }
    let seconds_by_distance = time(Filter::Bilinear, None)?;

    let animation = Animation { finest: animate(finest_level, 1)?, by_distance: animate(None, 1)?, smooth, exposure };
    let result = LevelOfDetail {
        adapter: gpu.description().clone(),
        size: [frame.width, frame.height],
        shaded: animation.finest[0].coverage.iter().filter(|c| **c > 0.0).count(),
        triangles: scene.parts.iter().map(|part| part.mesh.triangles.len()).sum(),
        lights: scene.lights.len(),
        levels,
        seconds_without_light,
        seconds_by_distance,
        finest: flicker(&animation.finest, &far, exposure),
        by_distance: flicker(&animation.by_distance, &far, exposure),
        smooth: flicker(&animation.smooth, &far, exposure),
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

/// Mask of the pixels of the first frame that show terrain at a distance of at least [`FAR`].
fn far_pixels(scene: &Scene, frame: Frame) -> Vec<bool> {
    let is_far = |hit: &Option<Hit>| {
        hit.as_ref().is_some_and(|hit| ShadingPoint::new(&scene.parts[0], hit, scene.camera.eye).distance >= FAR)
    };
    trace(scene, frame).0.iter().map(is_far).collect()
}

/// Temporal variance of luminance over frames, for selected pixels that show a surface in all of them.
pub fn flicker(frames: &[LinearImage], chosen: &[bool], exposure: f64) -> Flicker {
    let (mut variances, mut means, mut count) = (0.0, 0.0, 0usize);
    for pixel in 0..frames[0].pixels.len() {
        if !chosen[pixel] || frames.iter().any(|image| image.coverage[pixel] < 1.0) {
            continue;
        }
        let values: Vec<f64> = frames.iter().map(|f| display_luminance(f.pixels[pixel], exposure)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        variances += values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64;
        means += mean;
        count += 1;
    }
    let (variance, luminance) = (variances / count.max(1) as f64, means / count.max(1) as f64);
    let relative = if luminance > 0.0 { variance / (luminance * luminance) } else { 0.0 };
    Flicker { variance, luminance, relative }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(values: [f32; 2]) -> LinearImage {
        let pixels = values.map(|value| [value; 3]).to_vec();
        LinearImage { width: 2, height: 1, pixels, coverage: vec![1.0, 1.0], background: [0.0; 3] }
    }

    #[test]
    fn steady_frames_do_not_flicker() {
        let frames = [frame([0.3, 0.9]), frame([0.3, 0.9])];
        let found = flicker(&frames, &[true; 2], 1.0);
        assert!(found.variance < 1e-12 && (found.luminance - 0.6).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn the_variance_is_over_frames_and_the_mean_over_pixels() {
        // 0.2 and 0.4 have variance 0.01; the other pixel is steady.
        let mut frames = [frame([0.2, 0.5]), frame([0.4, 0.5])];
        let found = flicker(&frames, &[true; 2], 1.0);
        assert!((found.variance - 0.005).abs() < 1e-6 && (found.relative - 0.005 / 0.16).abs() < 1e-5, "{found:?}");
        // Pixels that are not covered in every frame do not count.
        frames[1].coverage[0] = 0.5;
        assert!(flicker(&frames, &[true; 2], 1.0).variance < 1e-12);
        frames[1].coverage[0] = 1.0;
        assert!(flicker(&frames, &[false, true], 1.0).variance < 1e-12);
    }
}
