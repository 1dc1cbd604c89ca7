//! Drawing of G-buffers, and reading them back in the CPU's layout.

use super::super::device::GpuError;
use super::kernels::Job;
use super::storage::{LoadedGBuffer, allocate};
use super::{AdaptiveRenderer, LoadedAdaptive};
use brdfc_render::gbuffer::{BACKGROUND, GBuffer};
use brdfc_render::scene::{Camera, Frame};

impl AdaptiveRenderer<'_> {
    /// Draws what a camera sees: `1 << antialiasing_levels` points per pixel and axis, at the positions where
    /// [`GBuffer::new`] puts them for a frame of as many samples. Ignores the samples of `frame` itself.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for more points than the adapter draws or binds; any error that the driver
    /// reports.
    pub fn g_buffer(
        &self,
        loaded: &LoadedAdaptive,
        camera: &Camera,
        frame: Frame,
        antialiasing_levels: u32,
    ) -> Result<LoadedGBuffer, GpuError> {
        let sub = 1usize.checked_shl(antialiasing_levels).unwrap_or(usize::MAX);
        let target = self.rasteriser.target(frame.width.saturating_mul(sub), frame.height.saturating_mul(sub))?;
        let buffer = allocate(self.kernels.gpu, &self.kernels.layouts, &target, camera, frame, antialiasing_levels)?;
        self.rasteriser.draw_sample(&loaded.scene, camera, &target, [0; 2], 1)?;
        Ok(buffer)
    }

    /// Reads a G-buffer back, with the exact values that the other steps use.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn read(&self, buffer: &LoadedGBuffer) -> Result<GBuffer, GpuError> {
        let count = buffer.points();
        let mut points: Vec<[[f32; 4]; 5]> = Vec::with_capacity(count);
        let band = buffer.points_at_once();
        for first in (0..count).step_by(band) {
            let here = band.min(count - first);
            self.kernels.run_part(&self.kernels.read_back, buffer, None, [first, here], 0);
            points.extend(self.gpu().read_values::<[[f32; 4]; 5]>(&buffer.storage.computed, 0, here)?);
        }
        let part = |point: &[[f32; 4]; 5]| (point[0][3] as u32).wrapping_sub(1);
        let shown = |point: &[[f32; 4]; 5]| part(point) != BACKGROUND;
        let vectors = |at: usize| -> Vec<[f32; 3]> {
            let of = |point: &[[f32; 4]; 5]| if shown(point) { [0, 1, 2].map(|k| point[at][k]) } else { [0.0; 3] };
            points.iter().map(of).collect()
        };
        Ok(GBuffer {
            width: buffer.size[0],
            height: buffer.size[1],
            position: vectors(0),
            normal: vectors(1),
            tangent: vectors(2),
            to_viewer: vectors(3),
            across: points.iter().map(|p| if shown(p) { [p[4][0], p[4][1]] } else { [1.0, 0.0] }).collect(),
            uv: points.iter().map(|p| [p[1][3], p[2][3]]).collect(),
            distance: points.iter().map(|p| if shown(p) { p[3][3] } else { 0.0 }).collect(),
            part: points.iter().map(part).collect(),
        })
    }

    /// Normal curvature of every point, as [`brdfc_render::curvature::curvature`].
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn curvature(&self, buffer: &LoadedGBuffer) -> Result<Vec<f32>, GpuError> {
        self.kernels.run(&self.kernels.curvatures, buffer, None, Job::over(buffer.points()));
        let found = self.gpu().read_values::<[f32; 4]>(&buffer.storage.predicted, 0, buffer.points())?;
        Ok(found.into_iter().map(|values| values[2]).collect())
    }
}
