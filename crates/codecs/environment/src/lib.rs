//! Prefiltered environments: radiance from all directions, convolved with kernels of increasing width, so that a shader
//! needs one look-up where it would otherwise sum over many directions.
//!
//! [`prefilter`] makes the cube map of `brdfc_formats::environment`; [`training`] makes environments on which lobes are
//! fitted.

pub mod facts;
mod kernel;
mod levels;
pub mod training;

use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::environment::cube::FacePoint;
use brdfc_formats::environment::{EnvironmentHeader, EnvironmentPack, IRRADIANCE_SIDE, MAX_SIDE, MIN_SIDE};
use levels::Faces;
use rayon::prelude::*;

/// Largest default side of a face, texels.
const MAX_DEFAULT_SIDE: u32 = 512;
/// Smallest default side: a small image still has levels for narrow lobes.
const MIN_DEFAULT_SIDE: u32 = 64;
/// Texels along each side of the faces that the irradiance is summed over.
const IRRADIANCE_SOURCE: usize = 32;

/// Error of [`prefilter`].
#[derive(Debug, thiserror::Error)]
pub enum PrefilterError {
    /// A side or a radiance is out of range.
    #[error(transparent)]
    Invalid(#[from] FormatError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Texels along each side of a face that retain the detail of a latitude-longitude image of this width: a power of two,
/// 64 to 512. Four faces surround the equator; the side is twice as fine.
pub fn default_side(width: usize) -> u32 {
    let side = (width / 2).next_power_of_two().min(MAX_SIDE as usize) as u32;
    side.clamp(MIN_DEFAULT_SIDE, MAX_DEFAULT_SIDE)
}

/// Prefilters an environment given by its radiance from directions of any length (linear RGB, finite, not negative), on
/// faces of `side` texels. Each texel of the finest level is the mean over `samples` x `samples` directions. The result
/// does not depend on the number of threads.
///
/// # Errors
/// Returns an error if the side is not a power of two from 8 to 2048, if a radiance is negative or not finite, and if
/// the work was cancelled.
pub fn prefilter(
    radiance: &(dyn Fn(Vector) -> Vector + Sync),
    side: u32,
    samples: usize,
    progress: &dyn Progress,
) -> Result<EnvironmentPack, PrefilterError> {
    let header = EnvironmentHeader { side, scale: 1.0 };
    header.check()?;
    progress.stage(Stage::Prefilter, header.levels() as usize)?;
    let finest = sampled(radiance, side as usize, samples.max(1));
    // Means of 2 x 2 texels: a Gaussian level is summed over texels of its own size, which are smaller than its kernel.
    let mut means = vec![finest];
    while means[means.len() - 1].side() > MIN_SIDE as usize {
        means.push(means[means.len() - 1].halved());
    }
    let mut levels = vec![means[0].texels().to_vec()];
    for level in 1..header.levels() {
        progress.step()?;
        let deviation = EnvironmentHeader::deviation(f64::from(header.sharpest() - level));
        let from = &means[level as usize];
        levels.push(from.convolved(from.side(), &kernel::Gaussian::new(deviation, from.side())));
    }
    progress.step()?;
    let from = means.iter().find(|faces| faces.side() <= IRRADIANCE_SOURCE).unwrap_or(&means[0]);
    let irradiance = from.convolved(IRRADIANCE_SIDE as usize, &kernel::Cosine);
    Ok(EnvironmentPack::new(header.side, &levels, &irradiance)?)
}

/// Faces whose texels are means over `samples` x `samples` directions.
fn sampled(radiance: &(dyn Fn(Vector) -> Vector + Sync), side: usize, samples: usize) -> Faces {
    let mean = |at: usize| {
        let (face, row, column) = (at / (side * side), at / side % side, at % side);
        let mut sum = [0.0; 3];
        for (down, right) in (0..samples).flat_map(|down| (0..samples).map(move |right| (down, right))) {
            let [x, y] =
                [(column, right), (row, down)].map(|(texel, step)| texel as f64 + (step as f64 + 0.5) / samples as f64);
            let value = radiance(FacePoint::on_grid(face, side, [x, y]).direction());
            (0..3).for_each(|k| sum[k] += value[k]);
        }
        sum.map(|s| (s / (samples * samples) as f64) as f32)
    };
    Faces::new(side, (0..6 * side * side).into_par_iter().map(mean).collect())
}
