//! Adaptive shading on the device: the counterpart of [`brdfc_render::adaptive`], from packs.
//!
//! Functions have the names of their CPU twins. Points and predictions stay on the device from step to step. The host
//! reads back sums of deviations (one number per stretch of points) and, for each level, the outcome of each pixel.

mod g_buffer;
mod kernels;
mod layouts;
mod material;
mod passes;
mod predict;
mod shader;
mod storage;

pub use shader::AdaptiveShaders;
pub use storage::LoadedGBuffer;

use super::device::{Gpu, GpuError};
use super::draw::Decoding;
use super::load::{LoadedScene, load};
use super::raster::Rasteriser;
use super::surface;
use brdfc_formats::BrdfPack;
use brdfc_render::adaptive::AdaptiveScene;
use kernels::Kernels;
use material::{LoadedMaterial, Surroundings};

/// Maximum number of samples per pixel.
const MAX_SAMPLES: u32 = 1 << 24;

/// Limits of one submission, so that drivers do not take it for a hang.
#[derive(Clone, Copy)]
struct Budget {
    /// Directions of predictions.
    lookups: usize,
    /// Samples of shading.
    samples: usize,
}

/// Budget of a software adapter: well below a second.
const SOFTWARE: Budget = Budget { lookups: 1 << 21, samples: 1 << 17 };
const HARDWARE: Budget = Budget { lookups: 1 << 26, samples: 1 << 24 };

/// Compiled pipelines.
pub struct AdaptiveRenderer<'g> {
    rasteriser: Rasteriser<'g>,
    surface_layout: wgpu::BindGroupLayout,
    kernels: Kernels<'g>,
    budget: Budget,
}

/// A scene on the device, with everything that adaptive shading looks up.
pub struct LoadedAdaptive {
    scene: LoadedScene,
    materials: Vec<LoadedMaterial>,
}

impl<'g> AdaptiveRenderer<'g> {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, &AdaptiveShaders::default())
    }

    /// Compiles other shaders, such as deliberately broken ones.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if a source does not validate.
    pub fn with_shaders(gpu: &'g Gpu, shaders: &AdaptiveShaders) -> Result<Self, GpuError> {
        let surface_layout = surface::layout(gpu);
        let passes = [("place", 2), ("turn", 1)];
        let rasteriser = Rasteriser::with_passes(gpu, shaders.g_buffer.clone(), &[&surface_layout], &passes)?;
        let kernels = Kernels::new(gpu, &shaders.steps)?;
        let budget = if gpu.description().software { SOFTWARE } else { HARDWARE };
        Ok(Self { rasteriser, surface_layout, kernels, budget })
    }

    /// Uploads a scene with one pack for each of its parts. The packs replace the reflectances of `materials`, which
    /// are ignored.
    ///
    /// # Panics
    /// If the number of packs differs from the number of parts, or there are fewer materials.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] for textures beyond the adapter's limits; any error that the driver reports.
    pub fn load(
        &self,
        scene: &AdaptiveScene<'_>,
        packs: &[&BrdfPack],
        decoding: Decoding,
    ) -> Result<LoadedAdaptive, GpuError> {
        let (parts, materials) = (&scene.scene.parts, scene.materials);
        assert!(packs.len() == parts.len() && materials.len() >= parts.len(), "one pack and material for each part");
        let radiance = surface::environment(self.gpu(), &scene.scene.environment)?;
        let surface = |(index, part)| vec![surface::upload(self.gpu(), &self.surface_layout, index, part, &radiance)];
        let groups = (0..).zip(parts).map(surface).collect();
        let (light, bandwidth) = (&material::light(self.gpu(), scene.light)?, scene.light.bandwidth());
        let surroundings = Surroundings { radiance: &radiance, light, bandwidth, decoding };
        let material = |(index, (material, pack))| {
            material::upload(self.gpu(), &self.kernels.layouts, &surroundings, index, material, pack)
        };
        let materials =
            materials.iter().zip(packs.iter().copied()).enumerate().map(material).collect::<Result<_, _>>()?;
        let scene = load(self.gpu(), &self.rasteriser.view_layout, scene.scene, groups, decoding.words())?;
        Ok(LoadedAdaptive { scene, materials })
    }

    fn gpu(&self) -> &'g Gpu {
        self.kernels.gpu
    }

    /// Maximum number of items of this cost per submission.
    fn at_once(&self, budget: usize, cost: usize) -> usize {
        (budget / cost.max(1)).max(1)
    }
}
