//! Times of a frame with each form of relief, on a graphics adapter.

use super::methods::{Method, Methods};
use super::{Encoder, ReliefError, VDIM};
use crate::timing::fastest;
use brdfc_flat_btf::encode::{FlatBtfEncoded, VdimRecipe};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::FlatBtfDecoder;
use brdfc_gpu::{Gpu, LoadedFlatBtf, flat_scene_source};
use brdfc_render::flat::FlatMaterial;
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use schemars::JsonSchema;
use serde::Serialize;

const PAPER: VdimRecipe = VdimRecipe { azimuth_rows: 16, ..VDIM };
/// Indirection maps that are drawn.
const MAPS: [(&str, VdimRecipe); 5] = [
    ("indirections of 16 x 16 views, no shadows", VdimRecipe { shadows: false, ..PAPER }),
    ("indirections of 16 x 16 views", PAPER),
    ("indirections of 8 x 32 views", VdimRecipe { polar_angles: 8, azimuth_rows: 32, ..PAPER }),
    ("indirections of 16 x 25 views", VDIM),
    ("compact indirections of 16 x 16 views", VdimRecipe { compact: true, ..PAPER }),
];
/// Each side of a frame over the one whose fetches are counted.
const COUNTED: usize = 4;

/// Times of a frame with the forms of relief.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReliefFrames {
    /// The structure's address.
    pub model: String,
    /// Texels of all maps per side. Heights of layers have twice as many.
    pub texels: u32,
    /// Point lights.
    pub lights: usize,
    /// One for each form.
    pub rows: Vec<ReliefFrame>,
}

/// Time of a frame with one form of relief.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReliefFrame {
    /// Form of the relief.
    pub relief: &'static str,
    /// Bytes on a GPU, mipmaps and reflectance included.
    pub bytes: u64,
    /// Most filtered fetches of a pixel under one light.
    pub fetches: u32,
    /// Mean of these fetches over pixels and lights.
    pub mean_fetches: f64,
    /// Seconds of a frame, until the image is read back.
    pub seconds: f64,
}

/// Measures frames of a plane with 4 x 4 tiles of a structure. The sampler filters. Calls `progress` with a description of
/// each finished step.
///
/// # Panics
/// If files have directions that cannot be interpolated.
///
/// # Errors
/// Returns an error for a wrong address, a surface that cannot be encoded, or an error of the driver.
pub fn relief_frames(
    gpu: &Gpu,
    address: &str,
    texels: u32,
    [width, height]: [usize; 2],
    progress: impl Fn(&str),
) -> Result<ReliefFrames, ReliefError> {
    let encoder = Encoder::new(address, texels)?;
    let FlatBtfEncoded { decoder, model, .. } = encoder.layers()?;
    let maps = MAPS.map(|(name, recipe)| Ok((name, encoder.sampled(recipe)?)));
    let maps = maps.into_iter().collect::<Result<Vec<_>, ReliefError>>()?;
    progress("files of reliefs");
    let methods = Methods::new(&model, &decoder, &maps[0].1);
    let (scene, tiles) = (Builtin::Plane.scene(), Builtin::Plane.tiles());
    let frame = Frame { width, height, samples: 1 };
    let counted = Frame { width: width / COUNTED, height: height / COUNTED, ..frame };
    let row = |(method, decoder): (Method<'_>, &FlatBtfDecoder)| {
        let material = FlatMaterial::new(decoder.clone(), tiles).expect("directions that were checked");
        let sampling = (&material, FrameBlock::default());
        let loaded = LoadedFlatBtf::new(gpu, flat_scene_source(), &scene, frame.samples, sampling)?;
        let seconds = fastest(|| loaded.draw(&scene.camera, frame))?;
        progress(method.name);
        let stored = method.stored.expect("a form of relief is stored");
        let mean_fetches = (stored.mean_fetches)(&scene, counted, tiles);
        Ok(ReliefFrame { relief: method.name, bytes: stored.bytes, fetches: stored.fetches, mean_fetches, seconds })
    };
    Ok(ReliefFrames {
        model: encoder.structure.canonical(),
        texels,
        lights: scene.lights.len(),
        rows: methods.of_shaders(&maps).into_iter().map(row).collect::<Result<_, ReliefError>>()?,
    })
}
