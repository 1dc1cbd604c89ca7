//! The maps of scenes that an environment lights: how fast lobes and light vary, and samples of the lobes.

use super::run::{JobError, start};
use crate::bandwidth::DEFAULT_EPSILON;
use crate::bandwidth::map::{brdf_map, environment_map};
use crate::bandwidth::resolution::Resolution;
use crate::brdf::encode::Observer;
use crate::brdf::importance::{ImportanceRecipe, importance_samples};
use crate::source::bandwidth_map::BandwidthFacts;
use crate::source::importance_pack::ImportanceFacts;
use crate::source::radiance_image::open_radiance_image;
use crate::source::{Source, Tally};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Everything that decides the bytes of the maps, besides the source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MapRecipe {
    /// Pixels per side at which lobes are transformed.
    pub resolution: Resolution,
    /// `ε` of the bandwidth.
    pub epsilon: f64,
    /// Sizes of the importance samples.
    pub samples: ImportanceRecipe,
}

impl Default for MapRecipe {
    fn default() -> Self {
        Self { resolution: Resolution::Automatic, epsilon: DEFAULT_EPSILON, samples: ImportanceRecipe::default() }
    }
}

/// A file that was written, and what it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Packed<T> {
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// What it holds.
    pub facts: T,
}

impl<T> Packed<T> {
    fn new(bytes: &[u8], facts: T) -> Self {
        Self { bytes_on_disk: bytes.len() as u64, facts }
    }
}

/// The maps of one material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MapsReport {
    /// How fast its lobes vary.
    pub bandwidth: Packed<BandwidthFacts>,
    /// Samples of its lobes.
    pub samples: Packed<ImportanceFacts>,
    /// What had to be mended while they were made.
    pub mended: Tally,
}

/// The parts of a material that are maps, in the order in which [`material_maps`] gives their bytes.
pub const PARTS: [&str; 2] = ["bandwidth", "samples"];

/// The file of a part.
pub fn part_name(material: &str, part: &str) -> String {
    format!("{material}.{part}.ktx2")
}

/// The bytes of the files of [`PARTS`].
///
/// # Errors
/// When the observer cancels.
pub fn material_maps(
    source: &dyn Source,
    recipe: &MapRecipe,
    observer: &mut dyn Observer,
) -> Result<([Vec<u8>; 2], MapsReport), JobError> {
    start(observer, "bandwidth map")?;
    let (map, mut mended) = brdf_map(source, recipe.resolution, recipe.epsilon).map_err(JobError::Map)?;
    start(observer, "importance samples")?;
    let (pack, tally) = importance_samples(source, &recipe.samples).map_err(JobError::Map)?;
    mended += tally;
    let (bandwidth, samples) = (map.to_bytes(true), pack.to_bytes(true));
    let report = MapsReport {
        bandwidth: Packed::new(&bandwidth, BandwidthFacts::new(&map)),
        samples: Packed::new(&samples, ImportanceFacts::new(&pack)),
        mended,
    };
    Ok(([bandwidth, samples], report))
}

/// The bytes of the file of an environment's map.
///
/// # Errors
/// An image that cannot be used; when the observer cancels.
pub fn environment_file(
    path: &Path,
    epsilon: f64,
    observer: &mut dyn Observer,
) -> Result<(Vec<u8>, Packed<BandwidthFacts>), JobError> {
    start(observer, "read")?;
    let image = open_radiance_image(path)?;
    start(observer, "bandwidth map")?;
    let map = environment_map(&image.pixels, image.width, epsilon).map_err(JobError::Map)?;
    let bytes = map.to_bytes(true);
    let report = Packed::new(&bytes, BandwidthFacts::new(&map));
    Ok((bytes, report))
}
