//! The maps of scenes that an environment lights: how fast lobes and light vary, and samples of the lobes.

use super::error::JobError;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_bandwidth::map::{brdf_map, environment_map};
use brdfc_bandwidth::resolution::Resolution;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::{Source, Tally};
use brdfc_importance::{ImportanceFacts, ImportanceRecipe, importance_samples};
use brdfc_source::radiance_image::open_radiance_image_heard;
use brdfc_source::read::ReadListener;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Which of [`PARTS`] are wanted of a material.
pub type WantedMaps = [bool; 2];

/// Everything that decides the bytes of maps, besides the source and which are wanted: pixels per side at which lobes are
/// transformed, `ε` of the bandwidth, sizes of the importance samples.
pub(super) fn map_recipe() -> (Resolution, f64, ImportanceRecipe) {
    (Resolution::default(), DEFAULT_EPSILON, ImportanceRecipe::default())
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
    /// How fast its lobes vary; where the scene needs it.
    pub bandwidth: Option<Packed<BandwidthFacts>>,
    /// Samples of its lobes; likewise.
    pub samples: Option<Packed<ImportanceFacts>>,
    /// What had to be repaired while they were made.
    #[serde(rename = "repaired")]
    pub repairs: Tally,
}

/// The parts of a material that are maps.
pub const PARTS: [&str; 2] = ["bandwidth", "samples"];

/// The file of a part.
pub fn part_name(material: &str, part: &str) -> String {
    format!("{material}.{part}.ktx2")
}

/// The parts that are wanted, in the order in which [`material_maps`] gives their bytes.
pub fn wanted_parts(wanted: WantedMaps) -> impl Iterator<Item = &'static str> {
    PARTS.into_iter().zip(wanted).filter_map(|(part, wanted)| wanted.then_some(part))
}

/// The bytes of the files that are wanted.
pub fn material_maps(
    source: &dyn Source,
    [wants_bandwidth, wants_samples]: WantedMaps,
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

/// The bytes of the file of an environment's map.
///
/// # Errors
/// An image that cannot be used; when the work is cancelled.
pub fn environment_file(
    path: &Path,
    listener: &mut dyn ReadListener,
    progress: &dyn Progress,
) -> Result<(Vec<u8>, Packed<BandwidthFacts>), JobError> {
    progress.stage(Stage::Read, 1)?;
    let image = open_radiance_image_heard(path, listener)?;
    progress.stage(Stage::BandwidthMap, 1)?;
    let map = environment_map(&image.pixels, image.width, DEFAULT_EPSILON).map_err(JobError::Map)?;
    let bytes = map.to_bytes(true);
    let report = Packed::new(&bytes, BandwidthFacts::new(&map));
    Ok((bytes, report))
}
