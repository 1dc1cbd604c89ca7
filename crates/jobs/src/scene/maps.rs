//! Maps for scenes with an environment light: the bandwidth of lobes and light, and importance samples of the lobes.

use super::error::JobError;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_bandwidth::map::{brdf_map, environment_map};
use brdfc_bandwidth::resolution::Resolution;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::{Source, Tally};
use brdfc_importance::{ImportanceFacts, ImportanceRecipe, importance_samples};
use brdfc_source::radiance_image::open_radiance_image_observed;
use brdfc_source::read::ReadListener;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Requested maps of a material: one flag for each of [`PARTS`].
pub type RequestedMaps = [bool; 2];

/// All parameters that affect the bytes of maps: pixels per side at which lobes are transformed, `ε` of the
/// bandwidth, and sizes of the importance samples.
pub(super) fn map_recipe() -> (Resolution, f64, ImportanceRecipe) {
    (Resolution::default(), DEFAULT_EPSILON, ImportanceRecipe::default())
}

/// A file of a map, and facts about its contents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Packed<T> {
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Facts about its contents.
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
    /// Bandwidth map, which holds how fast the lobes vary; absent if the scene does not need it.
    pub bandwidth: Option<Packed<BandwidthFacts>>,
    /// Importance samples of the lobes; absent if the scene does not need them.
    pub samples: Option<Packed<ImportanceFacts>>,
    /// Repairs made while the maps were computed.
    #[serde(rename = "repaired")]
    pub repairs: Tally,
}

/// Names of the maps among the parts of a material.
pub const PARTS: [&str; 2] = ["bandwidth", "samples"];

/// File name of a part.
pub fn part_name(material: &str, part: &str) -> String {
    format!("{material}.{part}.ktx2")
}

/// Names of the requested maps, in the order in which [`material_maps`] returns their bytes.
pub fn requested_parts(requested: RequestedMaps) -> impl Iterator<Item = &'static str> {
    PARTS.into_iter().zip(requested).filter_map(|(part, requested)| requested.then_some(part))
}

/// Makes the requested maps of a material. Returns the bytes of their files.
///
/// # Errors
/// Returns an error if a map breaks the rules of its layout, or if the caller cancels.
pub fn material_maps(
    source: &dyn Source,
    [wants_bandwidth, wants_samples]: RequestedMaps,
    progress: &dyn Progress,
) -> Result<(Vec<Vec<u8>>, MapsReport), JobError> {
    let (resolution, epsilon, samples) = map_recipe();
    let mut files = Vec::new();
    let mut report = MapsReport { bandwidth: None, samples: None, repairs: Tally::default() };
    if wants_bandwidth {
        progress.stage(Stage::BandwidthMap, 1)?;
        let (map, tally) = brdf_map(source, resolution, epsilon).map_err(JobError::Map)?;
        report.repairs += tally;
        files.push(map.to_bytes(true));
        report.bandwidth = files.last().map(|bytes| Packed::new(bytes, BandwidthFacts::new(&map)));
    }
    if wants_samples {
        progress.stage(Stage::ImportanceSamples, 1)?;
        let (pack, tally) = importance_samples(source, &samples).map_err(JobError::Map)?;
        report.repairs += tally;
        files.push(pack.to_bytes(true));
        report.samples = files.last().map(|bytes| Packed::new(bytes, ImportanceFacts::new(&pack)));
    }
    Ok((files, report))
}

/// Makes the bandwidth map of an environment. Returns the bytes of its file.
///
/// # Errors
/// Returns an error if the image cannot be read, or if the caller cancels.
pub fn environment_file(
    path: &Path,
    listener: &mut dyn ReadListener,
    progress: &dyn Progress,
) -> Result<(Vec<u8>, Packed<BandwidthFacts>), JobError> {
    progress.stage(Stage::Read, 1)?;
    let image = open_radiance_image_observed(path, listener)?;
    progress.stage(Stage::BandwidthMap, 1)?;
    let map = environment_map(&image.pixels, image.width, DEFAULT_EPSILON).map_err(JobError::Map)?;
    let bytes = map.to_bytes(true);
    let report = Packed::new(&bytes, BandwidthFacts::new(&map));
    Ok((bytes, report))
}
