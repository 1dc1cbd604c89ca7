//! Look-ups in a prefiltered environment on the CPU.

use super::cube::{FacePoint, FilteredCube};
use super::header::{EnvironmentHeader, IRRADIANCE_SIDE};
use super::pack::EnvironmentPack;

/// A decoded environment. Look-ups filter across the edges of the cube, as GPUs do.
#[derive(Debug, Clone)]
pub struct EnvironmentDecoder {
    header: EnvironmentHeader,
    /// Mipmap levels, from the finest.
    levels: Vec<FilteredCube>,
    irradiance: FilteredCube,
}

impl EnvironmentDecoder {
    /// Decodes all texels.
    pub fn new(pack: &EnvironmentPack) -> Self {
        let header = pack.header();
        let level =
            |level: u32| FilteredCube::new((header.side >> level) as usize, &pack.level(level).collect::<Vec<_>>());
        let irradiance = FilteredCube::new(IRRADIANCE_SIDE as usize, &pack.irradiance().collect::<Vec<_>>());
        Self { header, levels: (0..header.levels()).map(level).collect(), irradiance }
    }

    /// Sizes and scale of the environment.
    pub fn header(&self) -> EnvironmentHeader {
        self.header
    }

    /// Filtered radiance from a direction of any length but 0, in the frame of the environment, W/(m² sr). A sharpness
    /// of 0 gives the irradiance over π, 1 to the sharpest level narrower and narrower Gaussian kernels, see
    /// [`EnvironmentHeader::deviation`]; fractions blend.
    pub fn radiance(&self, direction: [f32; 3], sharpness: f32) -> [f32; 3] {
        let point = FacePoint::of(direction.map(f64::from));
        let blend = |a: [f32; 3], b: [f32; 3], share: f32| [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
        if sharpness <= 0.0 {
            return self.irradiance.filtered(point);
        }
        let level = self.header.level(sharpness);
        let (finer, share) = (level as usize, level.fract());
        let fine = self.levels[finer].filtered(point);
        if sharpness < 1.0 {
            blend(self.irradiance.filtered(point), fine, sharpness)
        } else if share > 0.0 {
            blend(fine, self.levels[finer + 1].filtered(point), share)
        } else {
            fine
        }
    }
}
