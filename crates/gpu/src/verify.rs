//! One scene drawn in several ways, to separate sources of error: by the shader from packs, and on the CPU from packs,
//! from complete table packs and from sources.

use crate::{Decoding, Gpu, GpuError, Renderer, draw_lobes};
use brdfc_core::Source;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::lobes::LobesPack;
use brdfc_formats::wavelet::level_of_detail;
use brdfc_formats::{BrdfDecoder, BrdfPack};
use brdfc_metrics::image::LinearImage;
use brdfc_render::lobes::{Integral, PrefilteredLight, draw_on_cpu};
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::shade::{Reflectance, SourceReflectance, shade};
use brdfc_render::trace::trace;
use brdfc_render::within::{outside, share_left_out, without};

/// One material of a scene's part.
#[derive(Clone, Copy)]
pub struct Material<'a> {
    /// Pack that engines load.
    pub pack: &'a BrdfPack,
    /// Source of the pack, if available.
    pub source: Option<&'a dyn Source>,
    /// All slices at 16 bits, which have only the errors of the grid.
    pub table: Option<&'a BrdfPack>,
}

/// One view, drawn in several ways.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    /// By the shader, from packs.
    pub shader: LinearImage,
    /// Ray cast on the CPU from packs, with exact filters.
    pub pack: LinearImage,
    /// Ray cast on the CPU from complete tables, if every part has one.
    pub table: Option<LinearImage>,
    /// Ray cast on the CPU from sources, if every part has one.
    pub source: Option<LinearImage>,
    /// A second rendering from sources, if they are rendered with random directions; it differs from `source` as much as `source`
    /// differs from an exact rendering.
    pub source_with_noise: Option<LinearImage>,
    /// Share of the surface pixels that are left out of all views, because they need directions outside their pack's
    /// domain.
    pub left_out: f64,
}

impl Views {
    /// The best reference: the sources if available, otherwise the packs.
    pub fn reference(&self) -> &LinearImage {
        self.source.as_ref().unwrap_or(&self.pack)
    }

    /// Adds the light of other views of the same surfaces. Complete tables get the added light of the sources, so that they keep
    /// the errors of the grid alone.
    pub fn add_light(&mut self, other: &Self) {
        let has_noise = self.source_with_noise.is_some() || other.source_with_noise.is_some();
        let with_noise = |views: &Self| views.source_with_noise.as_ref().or(views.source.as_ref()).cloned();
        self.source_with_noise = match (with_noise(self), with_noise(other)) {
            (Some(mut image), Some(added)) if has_noise => {
                image.add_light(&added);
                Some(image)
            }
            _ => None,
        };
        self.shader.add_light(&other.shader);
        self.pack.add_light(&other.pack);
        let add = |image: &mut Option<LinearImage>| match (&mut *image, &other.source) {
            (Some(image), Some(added)) => image.add_light(added),
            _ => *image = None,
        };
        add(&mut self.table);
        add(&mut self.source);
    }
}

/// Draws a scene by the lobes of its parts, with the shader and on the CPU. `integral` draws the reference of the shader's rendering
/// from sources, if every part with lobes has one.
///
/// # Errors
/// Returns the errors of [`draw_lobes`].
///
/// # Panics
/// If there are fewer lobes than parts.
pub fn lobes_views(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    light: &PrefilteredLight,
    lobes: &[Option<&LobesPack>],
    integral: impl FnOnce(&LinearImage) -> Option<Integral>,
) -> Result<Views, GpuError> {
    let shader = draw_lobes(gpu, scene, frame, light, lobes)?;
    let pack = draw_on_cpu(scene, frame, light, lobes);
    let (source, source_with_noise) = integral(&shader).map(|integral| (integral.image, integral.half)).unzip();
    Ok(Views { shader, pack, table: None, source, source_with_noise, left_out: 0.0 })
}

/// A pack on the CPU, decoded like a shader with exact filters.
pub struct PackReflectance {
    decoder: Box<dyn BrdfDecoder>,
    decoding: Decoding,
}

impl PackReflectance {
    /// Unpacks a pack.
    pub fn new(pack: &BrdfPack, decoding: Decoding) -> Self {
        Self { decoder: pack.decoder(), decoding }
    }
}

impl Reflectance for PackReflectance {
    fn eval(&self, pair: DirectionPair, distance: f64) -> [f64; 3] {
        let levels = self.decoder.levels();
        let level = self
            .decoding
            .level
            .unwrap_or_else(|| level_of_detail(levels, distance, self.decoding.distance_scale) as f32);
        self.decoder.eval(pair, level, self.decoding.filter).map(f64::from)
    }
}

/// Draws a scene in every way that its materials allow, with one material per part. Leaves out pixels that need
/// directions outside their pack's domain.
///
/// All views share the positions of their samples, so that they differ in shading but not in outlines.
///
/// # Errors
/// Returns an error that the driver reports.
pub fn views(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    materials: &[Material<'_>],
    decoding: Decoding,
) -> Result<Views, GpuError> {
    let renderer = Renderer::new(gpu)?;
    let packs: Vec<&BrdfPack> = materials.iter().map(|material| material.pack).collect();
    let loaded = renderer.load(scene, &packs, decoding)?;
    let shader = renderer.draw(&loaded, &scene.camera, frame)?;

    let hits = trace(scene, frame);
    let from_packs = |packs: &[&BrdfPack], decoding: Decoding| {
        let decoders: Vec<PackReflectance> = packs.iter().map(|pack| PackReflectance::new(pack, decoding)).collect();
        let all: Vec<&dyn Reflectance> = decoders.iter().map(|decoder| decoder as &dyn Reflectance).collect();
        shade(scene, frame, &hits, &all)
    };
    let pack = from_packs(&packs, decoding);
    let tables: Option<Vec<&BrdfPack>> = materials.iter().map(|material| material.table).collect();
    let table = tables.map(|tables| {
        from_packs(
            &tables,
            Decoding { filter: brdfc_formats::wavelet::Filter::Bilinear, level: Some(f32::MAX), ..decoding },
        )
    });
    let sources: Option<Vec<SourceReflectance<'_>>> =
        materials.iter().map(|material| material.source.map(SourceReflectance)).collect();
    let source = sources.map(|sources| {
        let all: Vec<&dyn Reflectance> = sources.iter().map(|source| source as &dyn Reflectance).collect();
        shade(scene, frame, &hits, &all)
    });
    let ranges: Vec<DirectionRange> = materials.iter().map(|material| material.pack.directions()).collect();
    let outside = outside(scene, frame, &hits, &ranges);
    let left_out = share_left_out(&hits, frame, &outside);
    let masked = |image: LinearImage| without(image, &outside);
    Ok(Views {
        shader: masked(shader),
        pack: masked(pack),
        table: table.map(masked),
        source: source.map(masked),
        source_with_noise: None,
        left_out,
    })
}
