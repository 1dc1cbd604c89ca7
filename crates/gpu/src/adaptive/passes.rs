//! The passes over the levels, from coarse to fine. The device decides the outcome of each pixel of a level, the CPU
//! lists the pixels to shade part by part, and the device shades them and adds up slices of their samples.

use super::super::device::GpuError;
use super::kernels::Job;
use super::storage::{LoadedGBuffer, SLICES};
use super::{AdaptiveRenderer, LoadedAdaptive};
use brdfc_metrics::image::LinearImage;
use brdfc_render::adaptive::{AdaptiveRendering, LevelCount, Prediction, Settings, ShadedLevels};

/// Samples of a slice, which one invocation sums.
const SLICE: u32 = 32;

/// Outcome of a node, with the numbers of `passes.wgsl`.
const LEFT_OUT: u32 = 0;
const SHADED: u32 = 2;

/// Nodes to shade, and their slices.
#[derive(Default)]
struct Work {
    /// Point, first sample, samples.
    slices: Vec<[u32; 4]>,
    /// Node, first slice, slices, samples.
    gathers: Vec<[u32; 4]>,
}

impl AdaptiveRenderer<'_> {
    /// Draws, as [`brdfc_render::adaptive::draw`].
    ///
    /// # Panics
    /// If the buffer has other antialiasing levels than the settings.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for settings out of range; any error that the driver reports.
    pub fn draw(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        settings: &Settings,
    ) -> Result<AdaptiveRendering, GpuError> {
        self.run_prediction(loaded, buffer, settings)?;
        let levels = self.run_levels(loaded, buffer)?;
        let image = self.resolve(loaded, buffer)?;
        Ok(AdaptiveRendering { image, prediction: self.read_prediction(buffer)?, levels })
    }

    /// Goes through the levels with a given prediction, as [`brdfc_render::adaptive::shade`].
    ///
    /// # Panics
    /// If the prediction belongs to another buffer.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for settings out of range; any error that the driver reports.
    pub fn shade(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        prediction: &Prediction,
        most: u32,
    ) -> Result<ShadedLevels, GpuError> {
        assert_eq!(prediction.level.len(), buffer.points(), "a prediction of this buffer");
        self.set(buffer, &Settings { most, fewest: 0, ..Settings::default() }, 0.0)?;
        self.write_prediction(buffer, prediction);
        let levels = self.run_levels(loaded, buffer)?;
        let computed = self.gpu().read_values::<[f32; 4]>(&buffer.storage.computed, 0, buffer.points())?;
        Ok(ShadedLevels { radiance: computed.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(), levels })
    }

    /// Shades every point with the same number of samples, as [`brdfc_render::adaptive::forward`].
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for settings out of range; any error that the driver reports.
    pub fn forward(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        count: u32,
    ) -> Result<LinearImage, GpuError> {
        self.set(buffer, &Settings { most: count, fewest: count, ..Settings::default() }, 0.0)?;
        self.kernels.run(&self.kernels.even, buffer, None, Job::over(buffer.points()));
        self.run_level(loaded, buffer, 0)?;
        self.resolve(loaded, buffer)
    }

    fn run_levels(&self, loaded: &LoadedAdaptive, buffer: &LoadedGBuffer) -> Result<Vec<LevelCount>, GpuError> {
        self.merge(buffer);
        let mut levels = Vec::with_capacity(buffer.levels.len());
        for level in (0..buffer.levels.len()).rev() {
            levels.push(self.run_level(loaded, buffer, level)?);
        }
        levels.reverse();
        Ok(levels)
    }

    fn run_level(&self, loaded: &LoadedAdaptive, buffer: &LoadedGBuffer, level: usize) -> Result<LevelCount, GpuError> {
        let [width, height, first] = buffer.levels[level];
        let job = Job { level: level as u32, ..Job::over(width * height) };
        self.kernels.run(&self.kernels.decide, buffer, None, job);
        let outcomes = self.gpu().read_values::<[u32; 4]>(&buffer.storage.outcomes, 0, width * height)?;
        let mut count = LevelCount::default();
        let mut of_parts: Vec<Vec<[u32; 3]>> = vec![Vec::new(); loaded.materials.len()];
        for (node, [outcome, samples, point, part]) in (first as u32..).zip(&outcomes) {
            count.pixels += u64::from(*outcome != LEFT_OUT);
            if *outcome == SHADED {
                count.shaded += 1;
                count.samples += u64::from(*samples);
                of_parts[*part as usize].push([node, *point, *samples]);
            }
        }
        for (part, nodes) in of_parts.iter().enumerate() {
            self.shade_nodes(loaded, buffer, part, nodes)?;
        }
        Ok(count)
    }

    /// Shades nodes of a part, each given by its index, the point it stands for and its samples.
    fn shade_nodes(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        part: usize,
        nodes: &[[u32; 3]],
    ) -> Result<(), GpuError> {
        let mut work = Work::default();
        for [node, point, samples] in nodes {
            let slices = samples.div_ceil(SLICE);
            if work.slices.len() + slices as usize > SLICES || work.gathers.len() == SLICES {
                self.run_work(loaded, buffer, part, &work)?;
                work = Work::default();
            }
            work.gathers.push([*node, work.slices.len() as u32, slices, *samples]);
            let slice = |first: u32| [*point, first, SLICE.min(samples - first), 0];
            work.slices.extend((0..slices).map(|index| slice(SLICE * index)));
        }
        self.run_work(loaded, buffer, part, &work)
    }

    fn run_work(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        part: usize,
        work: &Work,
    ) -> Result<(), GpuError> {
        if work.gathers.is_empty() {
            return Ok(());
        }
        let (kernels, queue) = (&self.kernels, &self.gpu().queue);
        queue.write_buffer(&buffer.storage.slices, 0, bytemuck::cast_slice(&work.slices));
        queue.write_buffer(&buffer.storage.gathers, 0, bytemuck::cast_slice(&work.gathers));
        let at_once = self.at_once(self.budget.samples, SLICE as usize);
        let job = Job { at_once, ..Job::over(work.slices.len()) };
        kernels.run(&kernels.shade, buffer, Some(&loaded.materials[part]), job);
        kernels.run(&kernels.gather, buffer, None, Job::over(work.gathers.len()));
        self.gpu().check()
    }

    /// Means over the points of each pixel.
    fn resolve(&self, loaded: &LoadedAdaptive, buffer: &LoadedGBuffer) -> Result<LinearImage, GpuError> {
        let (width, height) = (buffer.frame.width, buffer.frame.height);
        self.kernels.run(&self.kernels.resolve, buffer, None, Job::over(width * height));
        let image = self.gpu().read_values::<[f32; 4]>(&buffer.storage.image, 0, width * height)?;
        Ok(LinearImage {
            width,
            height,
            pixels: image.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
            coverage: image.iter().map(|[.., coverage]| *coverage).collect(),
            background: loaded.scene.background,
        })
    }
}
