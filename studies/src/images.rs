//! Visible errors of packs on the cloth, compared with the paper's velvet (section 6.3 of Claustres et al. 2007).

use brdfc_core::Source;
use brdfc_formats::BrdfPack;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::{Material, views};
use brdfc_gpu::{AdapterDescription, Decoding, Gpu, GpuError, Renderer, SliceFilter};
use brdfc_jobs::encode::EncodeError;
use brdfc_jobs::report::render::Verification;
use brdfc_metrics::image::{ImageDifference, LinearImage, compare_images};
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{SourceReflectance, shade_by_vertex};
use brdfc_render::trace::trace;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::{Recipe, Target};
use schemars::JsonSchema;
use serde::Serialize;

/// Mean ΔE of the paper's velvet.
pub const PAPER_MEAN: f64 = 1.3;
/// Standard deviation of ΔE of the paper's velvet.
pub const PAPER_SIGMA: f64 = 2.29;

/// One material on the cloth.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ImageRow {
    /// The input.
    pub material: String,
    /// Mean and standard deviation of ΔE, shader against source, with perceptually weighted ranking of slices and bias
    /// 0.0003.
    pub shader: [f64; 2],
    /// Mean and standard deviation of ΔE with the default recipe: slices ranked by energy, bias 0.01.
    pub shader_by_energy: [f64; 2],
    /// CPU from the pack against source: codec error.
    pub pack: [f64; 2],
    /// CPU from the complete table, unquantised, against source: errors of the grid alone.
    pub table: [f64; 2],
    /// Mean CIEDE2000, shader against source.
    pub delta_e_2000: f64,
    /// PSNR, shader against source, dB; absent without a difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Factor from radiance to the display's range.
    pub exposure: f64,
    /// Adapter that drew the shader's rendering.
    #[serde(skip)]
    pub adapter: Option<AdapterDescription>,
}

/// Renderings of the material on the cloth (figure 8 of the paper).
pub struct Drawn {
    /// By the shader, from the pack.
    pub pack: LinearImage,
    /// Light of each pixel, from the source.
    pub pixels: LinearImage,
    /// Light of each vertex, from the source, interpolated across triangles.
    pub vertices: LinearImage,
    /// Factor from radiance to the display's range.
    pub exposure: f64,
}

impl ImageRow {
    /// Returns true if the shader is as good as the paper's velvet.
    pub fn passes(&self) -> bool {
        self.shader[0] <= PAPER_MEAN && self.shader[1] <= PAPER_SIGMA
    }

    /// Returns true if the grid alone is worse than the paper's velvet, so that no pack with it can be as good.
    pub fn grid_is_the_limit(&self) -> bool {
        !(self.table[0] <= PAPER_MEAN && self.table[1] <= PAPER_SIGMA)
    }
}

/// Errors of the study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The driver reported an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The encoder failed.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// Encodes a material at 4:1 with 8 bits, and draws it on the cloth with 512 x 512 pixels of 4 samples.
///
/// # Errors
/// Returns an error that the driver reports.
pub fn on_the_cloth(gpu: &Gpu, material: &str, source: &dyn Source) -> Result<(ImageRow, Drawn), StudyError> {
    let by_energy = Recipe { measure_off_grid: false, ..Recipe::default() };
    let recipe = Recipe { measure_off_grid: false, ..Recipe::visible() };
    let whole = Recipe { target: Target::Ratio(1.0), bits: 16, ..recipe.clone() };
    let pack_of = |recipe: &Recipe| Ok::<_, StudyError>(BrdfPack::Wavelet(encode(source, recipe, &())?.pack));
    let (pack, table) = (pack_of(&recipe)?, pack_of(&whole)?);
    let frame = Frame { width: 512, height: 512, samples: 2 };
    let decoding = Decoding {
        filter: Filter::Bilinear,
        slices: SliceFilter::Hardware,
        level: None,
        distance_scale: DEFAULT_DISTANCE_SCALE,
    };
    let scene = Builtin::Cloth.scene();
    let materials = [Material { pack: &pack, source: Some(source), table: Some(&table) }];
    let views = views(gpu, &scene, frame, &materials, decoding)?;
    let v = Verification::new(Builtin::Cloth.name(), frame, &views, None, gpu.description(), Vec::new());
    let (Some(total), Some(codec), Some(grid)) = (&v.total, &v.codec, &v.grid) else {
        unreachable!("there is a source and a table");
    };
    let pack = pack_of(&by_energy)?;
    let renderer = Renderer::new(gpu)?;
    let image = renderer.draw(&renderer.load(&scene, &[&pack], decoding)?, &scene.camera, frame)?;
    let energy = compare_images(&image, views.reference(), v.exposure);
    let both = |d: &ImageDifference| [d.delta_e.mean, d.delta_e.standard_deviation];
    let by_vertex = shade_by_vertex(&scene, frame, &trace(&scene, frame), &[&SourceReflectance(source)]);
    let row = ImageRow {
        material: material.to_owned(),
        shader: both(total),
        shader_by_energy: both(&energy),
        pack: both(codec),
        table: both(grid),
        delta_e_2000: total.delta_e_2000.mean,
        psnr: total.psnr,
        exposure: v.exposure,
        adapter: Some(v.adapter.clone()),
    };
    let pixels = views.reference().clone();
    Ok((row, Drawn { pack: views.shader, pixels, vertices: by_vertex, exposure: v.exposure }))
}
