//! Relightable images for web viewers. Layout: `crates/codecs/pwt/src/web.rs`.

use super::make::{HeldOut, held_out_lights, wrong};
use crate::error::Error;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::Domain;
use brdfc_pwt::LightSamples;
use brdfc_pwt::measure::{StackErrors, image_errors};
use brdfc_pwt::normals::SurfaceMaps;
use brdfc_pwt::terms::{LearnedTerms, learned_terms};
use brdfc_pwt::web::{Components, WebBasis, WebImage};
use brdfc_readers::ptm::Ptm;
use image::codecs::jpeg::JpegEncoder;
use rayon::prelude::*;
use serde::Serialize;

/// Components: three images.
const COUNT: u32 = 9;
/// Quality of the JPEG files.
const QUALITY: u8 = 95;
/// Maximum pixels along a side of a JPEG file.
const MAX_JPEG_SIDE: u32 = 65_535;
/// Description of the image.
const INFO: &str = "info.json";

/// A relightable image for web viewers, and its errors after compression.
pub struct WebExport {
    /// Name and bytes of each file, `info.json` last.
    pub files: Vec<(String, Vec<u8>)>,
    /// Description of the files.
    pub report: WebReport,
    /// The image as viewers decode it.
    pub web: WebImage,
}

/// Report of a relightable image for web viewers.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct WebReport {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Functions of the light.
    pub basis: WebBasis,
    /// Coefficients per texel, a multiple of 3.
    pub coefficients: usize,
    /// Nodes along a side of the grid of the basis; 0 for polynomials.
    pub resolution: usize,
    /// Names of the files.
    pub files: Vec<String>,
    /// Bytes of the files.
    pub bytes_on_disk: usize,
    /// Errors at the fitted lights, including quantisation and JPEG.
    #[serde(flatten)]
    pub errors: StackErrors,
    /// Errors at held-out lights.
    pub held_out: Option<HeldOut>,
}

/// Makes a relightable image for web viewers. Holds out `hold_out` photographs as [`make`](super::make()) does. `surface` are
/// the normals of all photographs, if their lights determine them.
///
/// # Errors
/// Returns an error if photographs are out of range, or if no light is left to fit.
pub fn make_web(
    samples: &LightSamples,
    surface: Option<&SurfaceMaps>,
    hold_out: usize,
    seed: u64,
) -> Result<WebExport, Error> {
    let left_out = held_out_lights(samples, hold_out, seed)?;
    let [fitted, unseen] = samples.split(&left_out).map_err(wrong)?;
    let LearnedTerms { map, planes } = learned_terms(&fitted, COUNT).map_err(wrong)?;
    let basis = |light: [f32; 3]| (0..map.terms()).map(|term| map.value(term, light)).collect();
    let web = WebImage::new(&Components { size: fitted.size, planes, basis: &basis, lights: &fitted.lights }, QUALITY);
    let mut made = compressed(web, &fitted, surface);
    made.report.held_out = (!left_out.is_empty()).then(|| {
        let errors = errors_at(&made.web, &unseen);
        HeldOut { lights: left_out, psnr: errors.psnr, delta_e: errors.delta_e }
    });
    Ok(made)
}

/// Makes a relightable image for web viewers with the polynomials of a map. `samples` are the photographs or renderings
/// with which it is compared, and `surface` are their normals, if their lights determine them.
///
/// # Errors
/// Returns an error for a map that is too large for JPEG files.
pub fn make_web_of_map(map: &Ptm, samples: &LightSamples, surface: Option<&SurfaceMaps>) -> Result<WebExport, Error> {
    let [width, height] = map.size();
    if width.max(height) > MAX_JPEG_SIDE {
        let allowed = format!("at most {MAX_JPEG_SIDE} along each side, the limit of JPEG files");
        return Err(wrong(FormatError::whole("size", format!("{width} x {height}"), allowed)));
    }
    Ok(compressed(WebImage::of_map(map, QUALITY), &*samples.distant().map_err(wrong)?, surface))
}

/// Compresses the planes, and measures errors against the photographs.
fn compressed(mut web: WebImage, samples: &LightSamples, surface: Option<&SurfaceMaps>) -> WebExport {
    let named = |(k, plane): (usize, &Vec<u8>)| {
        (format!("plane_{k}.jpg"), jpeg(plane, web.info.width, web.info.height, QUALITY))
    };
    let mut files: Vec<(String, Vec<u8>)> = web.planes.par_iter().enumerate().map(named).collect();
    let decoded = |(_, bytes): &(String, Vec<u8>)| {
        image::load_from_memory(bytes).expect("an image that was just encoded").into_rgb8().into_raw()
    };
    web.planes = files.par_iter().map(decoded).collect();
    // Viewers use normals, if there are any, for diffuse and specular shading.
    if let Some(maps) = surface {
        files.push(("normals.jpg".to_owned(), jpeg(&maps.normal_levels(), web.info.width, web.info.height, QUALITY)));
    }
    files.push((INFO.to_owned(), serde_json::to_vec(&web.info).expect("numbers and names")));
    let errors = errors_at(&web, samples);
    let report = WebReport {
        size: samples.size,
        basis: web.info.r#type,
        coefficients: web.info.nplanes,
        resolution: web.info.resolution,
        files: files.iter().map(|(name, _)| name.clone()).collect(),
        bytes_on_disk: files.iter().map(|(_, bytes)| bytes.len()).sum(),
        errors,
        held_out: None,
    };
    WebExport { files, report, web }
}

fn errors_at(web: &WebImage, samples: &LightSamples) -> StackErrors {
    let image = |light: &[f32; 3]| {
        let mut image = web.image(*light);
        let values = image.as_flattened_mut();
        values.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        Domain::Display.decode_each(values);
        image
    };
    let images: Vec<_> = samples.lights.par_iter().map(image).collect();
    image_errors(&LightSamples::new(samples.size, samples.lights.clone(), images), samples)
}

/// RGB levels as a JPEG file, without subsampling.
pub(crate) fn jpeg(rgb: &[u8], width: usize, height: usize, quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let [width, height] = [width, height].map(|side| side as u32);
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    let encoded = image::ImageEncoder::write_image(encoder, rgb, width, height, image::ExtendedColorType::Rgb8);
    encoded.expect("sides below 65536, and writing to memory");
    bytes
}
