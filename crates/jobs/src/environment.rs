//! Environments and their prefiltered light: `brdfc environment`.

use crate::Error;
use brdfc_core::progress::Progress;
use brdfc_environment::{PrefilterError, default_side, prefilter};
use brdfc_formats::environment::cube::{FacePoint, FilteredCube};
use brdfc_formats::environment::{EnvironmentHeader, EnvironmentPack, MAX_SIDE, MIN_SIDE};
use brdfc_render::scene::Environment;
use brdfc_source::environment::EnvironmentFile;
use brdfc_source::radiance_image::RadianceImage;

/// Radiance from all directions, in the layout of its file.
#[derive(Debug, Clone)]
pub enum Surroundings {
    /// A latitude-longitude image.
    Image(Environment),
    /// A cube map.
    Cube(FilteredCube),
}

impl From<EnvironmentFile> for Surroundings {
    /// A prefiltered environment counts as its finest level, which is not filtered.
    fn from(file: EnvironmentFile) -> Self {
        match file {
            EnvironmentFile::Image(RadianceImage { width, height, pixels, .. }) => {
                Self::Image(Environment { width, height, pixels })
            }
            EnvironmentFile::Cube(cube) => Self::Cube(FilteredCube::new(cube.side() as usize, cube.texels())),
            EnvironmentFile::Pack(pack) => Self::from(&pack),
        }
    }
}

impl From<&EnvironmentPack> for Surroundings {
    /// The finest level, which is not filtered.
    fn from(pack: &EnvironmentPack) -> Self {
        let texels: Vec<[f32; 3]> = pack.level(0).collect();
        Self::Cube(FilteredCube::new(pack.header().side as usize, &texels))
    }
}

impl Surroundings {
    /// Width and height of the image or of each face, and the number of faces, 1 or 6.
    pub fn size(&self) -> [usize; 3] {
        match self {
            Self::Image(image) => [image.width, image.height, 1],
            Self::Cube(cube) => [cube.side(), cube.side(), 6],
        }
    }

    /// Converts to a latitude-longitude image; of a cube map, four faces wide.
    pub fn into_image(self) -> Environment {
        match self {
            Self::Image(image) => image,
            Self::Cube(cube) => Environment::of_cube(cube.side(), |direction| cube.filtered(FacePoint::of(direction))),
        }
    }

    /// Prefilters on faces of `side` texels, by default as many as retain the detail, 64 to 512.
    ///
    /// # Errors
    /// Returns an error if the side is not a power of two from 8 to 2048, and if the work was cancelled.
    pub fn prefilter(&self, side: Option<u32>, progress: &dyn Progress) -> Result<EnvironmentPack, Error> {
        let side = side.map(checked).transpose()?.unwrap_or_else(|| self.default_side());
        Ok(self.prefiltered(side, progress)?)
    }

    pub(crate) fn default_side(&self) -> u32 {
        match self {
            Self::Image(image) => default_side(image.width),
            // `default_side` expects the width of an image, half of which is the side.
            Self::Cube(cube) => default_side(2 * cube.side()),
        }
    }

    /// Same as [`Self::prefilter`], with the errors of the encoder.
    ///
    /// # Errors
    /// Returns an error for a side or a radiance out of range, and if the work was cancelled.
    pub(crate) fn prefiltered(&self, side: u32, progress: &dyn Progress) -> Result<EnvironmentPack, PrefilterError> {
        match self {
            Self::Image(image) => prefiltered(image, side, progress),
            Self::Cube(cube) => {
                let radiance = |direction| cube.filtered(FacePoint::of(direction)).map(f64::from);
                prefilter(&radiance, side, samples_of_cube(cube.side(), side as usize), progress)
            }
        }
    }
}

/// Prefilters a latitude-longitude image, on faces of `side` texels, by default as many as retain its detail.
///
/// # Errors
/// Returns an error if the side is not a power of two from 8 to 2048, and if the work was cancelled.
pub fn prefilter_image(
    image: &Environment,
    side: Option<u32>,
    progress: &dyn Progress,
) -> Result<EnvironmentPack, Error> {
    let side = side.map(checked).transpose()?.unwrap_or_else(|| default_side(image.width));
    Ok(prefiltered(image, side, progress)?)
}

fn checked(side: u32) -> Result<u32, Error> {
    if EnvironmentHeader::is_side(side) {
        return Ok(side);
    }
    Err(Error::usage(format!("side: found {side}, expected a power of two, {MIN_SIDE} to {MAX_SIDE}")))
}

fn prefiltered(image: &Environment, side: u32, progress: &dyn Progress) -> Result<EnvironmentPack, PrefilterError> {
    // At least two samples across a pixel of the image, whose look-ups are bilinear.
    let samples = (2 * image.width).div_ceil(4 * side as usize).max(2);
    prefilter(&|direction| image.at(direction), side, samples, progress)
}

/// Samples along each side of a texel on faces of `side` texels: the centres of the cube's texels where these fit, so that an equal
/// side copies them; otherwise at least two across each, because look-ups are bilinear.
fn samples_of_cube(from: usize, side: usize) -> usize {
    if from.is_multiple_of(side) { from / side } else { (2 * from).div_ceil(side).max(2) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// One bright texel in the middle, at an edge and at a corner of a face keeps its light in a latitude-longitude image.
    #[test]
    fn images_of_cube_maps_keep_the_light_of_a_texel() {
        const SIDE: usize = 16;
        for (column, row) in [(7, 8), (0, 7), (15, 8), (0, 0), (15, 15)] {
            for face in [0, 2, 4] {
                let mut texels = vec![[0.0; 3]; 6 * SIDE * SIDE];
                texels[(face * SIDE + row) * SIDE + column] = [1000.0; 3];
                let cube = FilteredCube::new(SIDE, &texels);
                let radiance = |direction| cube.filtered(FacePoint::of(direction));
                let light = |image: &Environment| {
                    let Environment { width, height, pixels } = image;
                    let of_row = |row: usize| (PI * (row as f64 + 0.5) / *height as f64).sin();
                    let pixel = |(at, pixel): (usize, &[f32; 3])| f64::from(pixel[1]) * of_row(at / width);
                    pixels.iter().enumerate().map(pixel).sum::<f64>() * TAU / *width as f64 * PI / *height as f64
                };
                let exact = light(&Environment::of(64 * SIDE, 32 * SIDE, radiance));
                let found = light(&Surroundings::Cube(cube.clone()).into_image());
                assert!((found / exact - 1.0).abs() < 0.03, "{face}, {column}, {row}: {found} {exact}");
                // The control: one sample in each pixel misses the light of texels at edges.
                if column == 0 && row == 7 {
                    let sampled = light(&Environment::of(4 * SIDE, 2 * SIDE, radiance));
                    assert!((sampled / exact - 1.0).abs() > 0.03, "{face}: {sampled} {exact}");
                }
            }
        }
    }
}
