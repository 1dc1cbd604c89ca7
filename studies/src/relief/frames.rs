//! Times of a frame with each form of relief, on a graphics adapter.

use super::methods::{Method, Methods};
use super::renderings::{DISTANCE, plane_from};
use super::{Encoder, ReliefError, VDIM};
use crate::timing::fastest;
use brdfc_flat_btf::encode::{EncodeError, FlatBtfEncoded, VdimRecipe};
use brdfc_flat_btf::indirection::indirection;
use brdfc_flat_btf::model::MesoModel;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, Relief};
use brdfc_gpu::{Gpu, LoadedFlatBtf, flat_scene_source};
use brdfc_render::flat::FlatMaterial;
use brdfc_render::scene::{Camera, Frame};
use brdfc_render::scenes::Builtin;
use schemars::JsonSchema;
use serde::Serialize;
use std::convert::Infallible;

const PAPER: VdimRecipe = VdimRecipe { azimuth_rows: 16, ..VDIM };
/// Indirection maps that are drawn.
const MAPS: [(&str, VdimRecipe); 5] = [
    ("indirections of 16 x 16 views, no shadows", VdimRecipe { shadows: false, ..PAPER }),
    ("indirections of 16 x 16 views", PAPER),
    ("indirections of 8 x 32 views", VdimRecipe { polar_angles: 8, azimuth_rows: 32, ..PAPER }),
    ("indirections of 16 x 25 views", VDIM),
    ("compact indirections of 16 x 16 views", VdimRecipe { compact: true, ..PAPER }),
];
/// Number of runs of a timing, of which the fastest counts. Frames are short, so that some run while nothing else does.
const RUNS: usize = 25;
/// Each side of a frame over the one whose fetches are counted.
const COUNTED: usize = 2;
/// Polar angle and azimuth of the view, degrees.
const VIEW: [f64; 2] = [50.0, 34.0];

/// Times of a frame with the forms of relief.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReliefFrames {
    /// The structure's address.
    pub model: String,
    /// Texels of all maps per side. Heights of layers have twice as many.
    pub texels: u32,
    /// Pixels of a frame. All of them show the surface.
    pub size: [usize; 2],
    /// Point lights.
    pub lights: usize,
    /// Seconds of a frame that shows nothing, until it is read back.
    pub empty: f64,
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

/// Measures frames that a plane with 4 x 4 tiles of a structure fills. The sampler filters. Calls `progress` with a description of
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
    let sampled = encoder.sampled(VDIM)?;
    let maps = MAPS.map(|(name, recipe)| Ok((name, with_map(&sampled, &model, texels, &recipe)?)));
    let maps = maps.into_iter().collect::<Result<Vec<_>, ReliefError>>()?;
    progress("files of reliefs");
    let methods = Methods::new(&model, &decoder, &sampled);
    let [polar, azimuth] = VIEW;
    let (scene, tiles) = (plane_from(polar, azimuth, DISTANCE), Builtin::Plane.tiles());
    let [eye, target] = [scene.camera.eye, scene.camera.target];
    let away = Camera { target: [0, 1, 2].map(|k| 2.0 * eye[k] - target[k]), ..scene.camera };
    let frame = Frame { width, height, samples: 1 };
    let counted = Frame { width: width / COUNTED, height: height / COUNTED, ..frame };
    let mut empty = f64::INFINITY;
    let row = |(method, decoder): (Method<'_>, &FlatBtfDecoder)| {
        let material = FlatMaterial::new(decoder.clone(), tiles).expect("directions that were checked");
        let sampling = (&material, FrameBlock::default());
        let loaded = LoadedFlatBtf::new(
            gpu,
            flat_scene_source(decoder.parts().reflectance.kind()),
            &scene,
            frame.samples,
            sampling,
        )?;
        let seconds = fastest(RUNS, || loaded.draw(&scene.camera, frame))?;
        empty = empty.min(fastest(RUNS, || loaded.draw(&away, frame))?);
        progress(method.name);
        let stored = method.stored.expect("a form of relief is stored");
        let mean_fetches = (stored.mean_fetches)(&scene, counted, tiles);
        Ok(ReliefFrame { relief: method.name, bytes: stored.bytes, fetches: stored.fetches, mean_fetches, seconds })
    };
    let rows = methods.of_shaders(&maps).into_iter().map(row).collect::<Result<_, ReliefError>>()?;
    let (model, lights) = (encoder.structure.canonical(), scene.lights.len());
    Ok(ReliefFrames { model, texels, size: [width, height], lights, empty, rows })
}

/// The same reflectance and shadows with another indirection map.
fn with_map(
    sampled: &FlatBtfDecoder,
    model: &MesoModel,
    texels: u32,
    recipe: &VdimRecipe,
) -> Result<FlatBtfDecoder, ReliefError> {
    let shadows = sampled.parts().relief.shadows().filter(|_| recipe.shadows).cloned();
    let header = recipe.header(texels, shadows.as_ref().map_or(0, |shadows| shadows.lights().len()));
    let map = indirection::<EncodeError<Infallible>>(model, header, recipe.oversampling as usize, recipe.compact, &())?;
    let relief = Relief::sampled(map, shadows).map_err(EncodeError::from)?;
    Ok(FlatBtfDecoder::new(FlatBtfParts { relief, reflectance: sampled.parts().reflectance.clone() }))
}
