//! The bandwidth buffer: bandwidth, deviation, level and samples of every point.

use super::super::device::GpuError;
use super::kernels::Job;
use super::storage::{LoadedGBuffer, SETTINGS_WORDS};
use super::{AdaptiveRenderer, LoadedAdaptive};
use brdfc_formats::bandwidth::propagation::{largest_pixel_bandwidth, sample_scale};
use brdfc_render::adaptive::{ANY_LEVEL, MAX_DIRECTIONS, Prediction, Pyramid, Settings, field_of_view};

/// Points that an invocation of `deviations` adds up.
const STRETCH: usize = 256;

impl AdaptiveRenderer<'_> {
    /// Predicts, as [`brdfc_render::adaptive::predict`].
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for settings out of range; any error that the driver reports.
    pub fn predict(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        settings: &Settings,
    ) -> Result<Prediction, GpuError> {
        self.run_prediction(loaded, buffer, settings)?;
        self.read_prediction(buffer)
    }

    /// Predicts and leaves the results on the device, for measurements of this step alone.
    ///
    /// # Panics
    /// If the buffer has other antialiasing levels than the settings.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for settings out of range; any error that the driver reports.
    pub fn run_prediction(
        &self,
        loaded: &LoadedAdaptive,
        buffer: &LoadedGBuffer,
        settings: &Settings,
    ) -> Result<(), GpuError> {
        assert_eq!(buffer.antialiasing_levels, settings.antialiasing_levels, "the buffer of these settings");
        let kernels = &self.kernels;
        let count = buffer.points();
        self.set(buffer, settings, 0.0)?;
        kernels.run(&kernels.curvatures, buffer, None, Job::over(count));
        // Tiles of 4 x 4 points, which in the worst case are all of different pieces.
        let tiles = buffer.size().map(|side| side.div_ceil(4)).into_iter().product();
        let at_once = self.at_once(self.budget.lookups, 16 * settings.directions.min(MAX_DIRECTIONS) as usize);
        let job = Job { at_once, ..Job::over(tiles) };
        for material in &loaded.materials {
            kernels.run(&kernels.predict, buffer, Some(material), job);
        }
        let stretches = count.div_ceil(STRETCH);
        kernels.run(&kernels.deviations, buffer, None, Job::over(stretches));
        let sums = self.gpu().read_values::<[f32; 4]>(&buffer.storage.sums, 0, stretches)?;
        let sum: f64 = sums.iter().map(|[high, low, ..]| f64::from(*high) + f64::from(*low)).sum();
        let covered: f64 = sums.iter().map(|[_, _, covered, _]| f64::from(*covered)).sum();
        self.set(buffer, settings, sample_scale((sum / covered.max(1.0)) as f32, settings.samples))?;
        kernels.run(&kernels.rates, buffer, None, Job::over(count));
        self.gpu().wait()
    }

    /// Reads the last prediction of a buffer back.
    pub(super) fn read_prediction(&self, buffer: &LoadedGBuffer) -> Result<Prediction, GpuError> {
        let predicted = self.gpu().read_values::<[f32; 4]>(&buffer.storage.predicted, 0, buffer.points())?;
        let nodes = self.gpu().read_values::<[u32; 3]>(&buffer.storage.nodes, 0, buffer.points())?;
        Ok(Prediction {
            bandwidth: predicted.iter().map(|[bandwidth, ..]| *bandwidth).collect(),
            deviation: predicted.iter().map(|[_, deviation, ..]| *deviation).collect(),
            level: nodes.iter().map(|[level, ..]| *level as i32).collect(),
            samples: nodes.iter().map(|[_, samples, _]| *samples).collect(),
        })
    }

    /// Replaces the device's own prediction.
    pub(super) fn write_prediction(&self, buffer: &LoadedGBuffer, prediction: &Prediction) {
        let node = |point: usize| match prediction.level[point] {
            ANY_LEVEL => [ANY_LEVEL as u32, 0, u32::MAX],
            level => [level as u32, prediction.samples[point], point as u32],
        };
        let nodes: Vec<[u32; 3]> = (0..buffer.points()).map(node).collect();
        self.gpu().queue.write_buffer(&buffer.storage.nodes, 0, bytemuck::cast_slice(&nodes));
    }

    /// Reads two [`Pyramid`]s back: the smallest level and the largest number of samples of each square of points.
    ///
    /// # Panics
    /// If the prediction belongs to another buffer.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn pyramids(
        &self,
        buffer: &LoadedGBuffer,
        prediction: &Prediction,
    ) -> Result<(Pyramid<i32>, Pyramid<u32>), GpuError> {
        assert_eq!(prediction.level.len(), buffer.points(), "a prediction of this buffer");
        self.write_prediction(buffer, prediction);
        self.merge(buffer);
        let (mut targets, mut samples) = (Vec::new(), Vec::new());
        for [width, height, first] in &buffer.levels {
            let nodes = self.gpu().read_values::<[u32; 3]>(&buffer.storage.nodes, *first, width * height)?;
            targets.push((*width, *height, nodes.iter().map(|[level, ..]| *level as i32).collect()));
            samples.push((*width, *height, nodes.iter().map(|[_, samples, _]| *samples).collect()));
        }
        Ok((Pyramid { levels: targets }, Pyramid { levels: samples }))
    }

    /// Computes coarser nodes from finer ones.
    pub(super) fn merge(&self, buffer: &LoadedGBuffer) {
        for (level, [width, height, _]) in (0..).zip(&buffer.levels).skip(1) {
            let job = Job { level, ..Job::over(width * height) };
            self.kernels.run(&self.kernels.merge, buffer, None, job);
        }
    }

    /// Writes the shader's `Settings`; `scale` is the factor from deviation to samples.
    ///
    /// # Errors
    /// Returns an error for more samples than [`super::MAX_SAMPLES`].
    pub(super) fn set(&self, buffer: &LoadedGBuffer, settings: &Settings, scale: f32) -> Result<(), GpuError> {
        for (name, found) in [("fewest", settings.fewest), ("most", settings.most)] {
            if found > super::MAX_SAMPLES {
                let text = format!("{name} samples per pixel: found {found}, expected at most {}", super::MAX_SAMPLES);
                return Err(GpuError::TooLarge(text));
            }
        }
        let field_of_view = field_of_view(&buffer.camera, buffer.frame);
        let largest = largest_pixel_bandwidth(settings.antialiasing_levels);
        let words: [u32; SETTINGS_WORDS] = [
            field_of_view[0].to_bits(),
            field_of_view[1].to_bits(),
            settings.directions.clamp(1, MAX_DIRECTIONS),
            settings.white.to_bits(),
            settings.caution.to_bits(),
            largest.to_bits(),
            scale.to_bits(),
            settings.fewest,
            settings.most,
            settings.antialiasing_levels,
            0,
            0,
        ];
        self.gpu().queue.write_buffer(&buffer.settings, 0, bytemuck::cast_slice(&words));
        Ok(())
    }
}
