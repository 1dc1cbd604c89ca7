//! Photographs under known lights, and normals, as JPEG files in a page.

use crate::error::Error;
use crate::pwt::{DistantPhotographs, LightInput, jpeg, make_surface};
use brdfc_core::progress::Progress;
use brdfc_core::words::bytes;
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_source::photograph::CodeValues;
use brdfc_source::{Input, InputError};
use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgb};
use rayon::prelude::*;
use std::path::Path;

/// Maximum pixels along a side: as many as a page draws.
const MAX_SIDE: usize = 1024;
/// Pixels along the longer side from which photographs are left out instead of reduced further.
const MIN_SIDE: usize = 512;
/// Quality of JPEG files of photographs and of normals.
const QUALITY: u8 = 90;
const QUALITY_OF_NORMALS: u8 = 95;
/// Number of photographs that predict the size of all.
const SAMPLED: usize = 8;
/// Share of the limit that is aimed at, because predictions have errors.
const AIM: f64 = 0.93;
/// Number of photographs that are compressed between checks of the limit.
const AT_ONCE: usize = 16;

/// Images of a page, as JPEG files.
#[derive(Debug, Clone)]
pub struct Photographs {
    /// Columns and rows of the originals.
    pub full_size: [usize; 2],
    /// Columns and rows in the page.
    pub size: [usize; 2],
    /// Number of originals.
    pub total: usize,
    /// The images in the page.
    pub all: Vec<Photograph>,
    /// Differences between the list of lights and the capture, such as lights without an image.
    pub notes: Vec<String>,
}

/// An image of a page.
#[derive(Debug, Clone)]
pub struct Photograph {
    /// Name of its file.
    pub name: String,
    /// Unit vector to its light; `None` if it does not depend on the light.
    pub light: Option<[f32; 3]>,
    /// The image as a JPEG file.
    pub jpeg: Vec<u8>,
}

impl Photographs {
    /// Reads photographs, and reduces first their size and then their number, so that the page has at most `limit` bytes of them.
    ///
    /// # Errors
    /// Returns an error if a file is missing or invalid, not even one photograph is within the limit, or if cancelled.
    pub fn of_capture(
        path: &Path,
        codes: Option<CodeValues>,
        limit: u64,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let photographs = DistantPhotographs::open(path, codes)?;
        let capture = photographs.capture();
        let full_size = capture.size();
        let order = spread(capture.lights());
        let encoded = |side: usize, lights: &[usize]| -> Result<Vec<Vec<u8>>, InputError> {
            let one = |light: &usize| photographs.image(*light).map(|image| compressed(image.pixels, full_size, side));
            let all: Vec<_> = lights.par_iter().map(one).collect();
            all.into_iter().collect()
        };
        let longer = full_size[0].max(full_size[1]).min(MAX_SIDE);
        let sampled = encoded(longer, &order[..SAMPLED.min(order.len())])?;
        let mean = sampled.iter().map(|jpeg| bytes_in_page(jpeg)).sum::<u64>() as f64 / sampled.len() as f64;
        let share = AIM * limit as f64 / (mean * order.len() as f64);
        let reduced = (longer as f64 * share.sqrt()) as usize;
        let side = reduced.clamp(MIN_SIDE.min(longer), longer);
        let (mut all, mut used) = (Vec::new(), 0);
        'filling: for lights in order.chunks(AT_ONCE) {
            progress.check()?;
            for (light, jpeg) in lights.iter().zip(encoded(side, lights)?) {
                used += bytes_in_page(&jpeg);
                if used > limit {
                    break 'filling;
                }
                let name = capture.file(*light).file_name().unwrap_or_default().to_string_lossy().into_owned();
                all.push((*light, Photograph { name, light: Some(capture.lights()[*light]), jpeg }));
            }
        }
        if all.is_empty() {
            let allowed = format!("at least {} for one photograph", bytes(used));
            return Err(Error::wrong_usage("--max-photographs", bytes(limit), allowed));
        }
        all.sort_by_key(|(light, _)| *light);
        let all = all.into_iter().map(|(_, photograph)| photograph).collect();
        let notes = photographs.notes().to_vec();
        Ok(Self { full_size, size: within(full_size, side), total: order.len(), all, notes })
    }

    /// Normals of photographs or of a pack, as colours.
    ///
    /// # Errors
    /// Returns an error if the input is invalid, or if its lights do not determine normals.
    pub fn normals(input: &Input, codes: Option<CodeValues>) -> Result<Self, Error> {
        let (maps, report) = make_surface(&LightInput::open_as(input, None, codes)?.into_samples())?;
        let [width, height] = maps.size.map(|side| side as u32);
        let size = within(maps.size, MAX_SIDE);
        let levels = ImageBuffer::<Rgb<u8>, _>::from_raw(width, height, maps.normal_levels()).expect("three per pixel");
        let levels = resize(&levels, size[0] as u32, size[1] as u32, FilterType::Triangle).into_raw();
        let jpeg = jpeg(&levels, size[0], size[1], QUALITY_OF_NORMALS);
        let all = vec![Photograph { name: "normals".to_owned(), light: None, jpeg }];
        Ok(Self { full_size: maps.size, size, total: 1, all, notes: report.doubt().into_iter().collect() })
    }

    /// Bytes in the page, as Base64.
    pub fn bytes(&self) -> u64 {
        self.all.iter().map(|photograph| bytes_in_page(&photograph.jpeg)).sum()
    }

    /// Description in one line.
    pub(super) fn facts(&self) -> String {
        let [width, height] = self.size;
        let size = bytes(self.bytes());
        match self.all.len() {
            1 if self.all[0].light.is_none() => {
                format!("x in red, y in green, z in blue; {width} x {height} pixels, {size} in this page")
            }
            count => {
                let left_out = self.left_out().map(|text| format!("; {text}")).unwrap_or_default();
                format!("{count} photographs, {width} x {height} pixels, {size} of JPEG files in this page{left_out}")
            }
        }
    }

    /// Description of reductions, if there are any.
    pub fn left_out(&self) -> Option<String> {
        let [width, height] = self.full_size;
        let reduced = (self.size != self.full_size).then(|| format!("reduced from {width} x {height} pixels"));
        let lacking = self.total - self.all.len();
        let fewer = (lacking > 0).then(|| format!("{lacking} of {} photographs left out", self.total));
        let texts: Vec<String> = reduced.into_iter().chain(fewer).collect();
        (!texts.is_empty()).then(|| texts.join(", "))
    }
}

/// Length as Base64.
fn bytes_in_page(jpeg: &[u8]) -> u64 {
    4 * jpeg.len().div_ceil(3) as u64
}

/// Size of an image whose longer side is at most `side`.
fn within(size: [usize; 2], side: usize) -> [usize; 2] {
    let longer = size[0].max(size[1]);
    if longer <= side { size } else { size.map(|full| (full * side).div_ceil(longer)) }
}

/// Reduces linear RGB to a longer side of at most `side`, and compresses it.
fn compressed(pixels: Vec<[f32; 3]>, full: [usize; 2], side: usize) -> Vec<u8> {
    let size = within(full, side);
    let mut values = pixels.into_flattened();
    if size != full {
        let image =
            ImageBuffer::<Rgb<f32>, _>::from_raw(full[0] as u32, full[1] as u32, values).expect("three per pixel");
        values = resize(&image, size[0] as u32, size[1] as u32, FilterType::Triangle).into_raw();
    }
    let levels: Vec<u8> = values.iter().map(|value| encode_srgb_byte(f64::from(*value))).collect();
    jpeg(&levels, size[0], size[1], QUALITY)
}

/// Numbers of lights: the highest, then always the one that is farthest from those before it.
fn spread(lights: &[[f32; 3]]) -> Vec<usize> {
    let mut nearest = vec![f32::NEG_INFINITY; lights.len()];
    let mut order = Vec::with_capacity(lights.len());
    let highest = (0..lights.len()).max_by(|a, b| lights[*a][2].total_cmp(&lights[*b][2]));
    let mut next = highest;
    while let Some(light) = next {
        order.push(light);
        nearest[light] = f32::INFINITY;
        for (cosine, other) in nearest.iter_mut().zip(lights) {
            *cosine = cosine.max(other.iter().zip(lights[light]).map(|(a, b)| a * b).sum());
        }
        let rest = (0..lights.len()).filter(|light| nearest[*light] < f32::INFINITY);
        next = rest.min_by(|a, b| nearest[*a].total_cmp(&nearest[*b]));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_taken_far_apart() {
        let lights = [[0.6, 0.0, 0.8], [0.61, 0.0, 0.79], [0.0, 0.0, 1.0], [-0.8, 0.0, 0.6], [0.0, 0.0, 1.0]];
        assert_eq!(spread(&lights), [4, 3, 1, 0, 2]);
        assert_eq!((within([4000, 3000], 1024), within([300, 200], 1024)), ([1024, 768], [300, 200]));
    }
}
