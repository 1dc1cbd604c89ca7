//! Maps for scenes with an environment light: the bandwidth of lobes and light, importance samples of the lobes, and
//! prefiltered light.

use super::error::JobError;
use super::lobes::LobesReport;
use crate::environment::Surroundings;
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_bandwidth::map::{brdf_map, environment_map};
use brdfc_bandwidth::resolution::Resolution;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::{Source, Tally};
use brdfc_environment::PrefilterError;
use brdfc_environment::facts::EnvironmentFacts;
use brdfc_importance::{ImportanceFacts, ImportanceRecipe, importance_samples};
use brdfc_source::InputError;
use brdfc_source::environment::open_environment_observed;
use brdfc_source::read::ReadListener;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Requested maps of a material or of an environment: one flag for each of [`PARTS`] or [`ENVIRONMENT_PARTS`].
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
    pub(super) fn new(bytes: &[u8], facts: T) -> Self {
        Self { bytes_on_disk: bytes.len() as u64, facts }
    }
}

/// The maps and lobes of one material.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MapsReport {
    /// Lobes, which a renderer looks up in the prefiltered environment; absent if the scene does not need them.
    pub lobes: Option<LobesReport>,
    /// Bandwidth map, which holds how fast the lobes vary; absent if the scene does not need it.
    pub bandwidth: Option<Packed<BandwidthFacts>>,
    /// Importance samples of the lobes; absent if the scene does not need them.
    pub samples: Option<Packed<ImportanceFacts>>,
    /// Bandwidth map of the texture; absent if the scene does not need it.
    pub texture: Option<Packed<BandwidthFacts>>,
    /// Repairs made while the maps and lobes were computed.
    #[serde(rename = "repaired")]
    pub repairs: Tally,
}

impl MapsReport {
    /// Report of lobes, other maps, and the map of a texture; `None` if there are none.
    pub fn of(
        lobes: Option<(LobesReport, Tally)>,
        maps: Option<Self>,
        texture: Option<Packed<BandwidthFacts>>,
    ) -> Option<Self> {
        if lobes.is_none() && texture.is_none() {
            return maps;
        }
        let mut report = maps.unwrap_or_default();
        if let Some((lobes, repairs)) = lobes {
            report.lobes = Some(lobes);
            report.repairs += repairs;
        }
        report.texture = texture;
        Some(report)
    }
}

/// The maps of the environment.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct EnvironmentMaps {
    /// Prefiltered light, which lobes look up; absent if no material has lobes.
    pub prefiltered: Option<Packed<EnvironmentFacts>>,
    /// Bandwidth map; absent if no material has one.
    pub bandwidth: Option<Packed<BandwidthFacts>>,
}

impl EnvironmentMaps {
    /// The map of this name in [`ENVIRONMENT_PARTS`] alone.
    pub(super) fn only(&self, part: &str) -> Self {
        let [prefiltered, bandwidth] = ENVIRONMENT_PARTS.map(|name| name == part);
        Self {
            prefiltered: self.prefiltered.clone().filter(|_| prefiltered),
            bandwidth: self.bandwidth.clone().filter(|_| bandwidth),
        }
    }

    /// The maps of both.
    pub(super) fn with(self, other: Self) -> Self {
        Self { prefiltered: self.prefiltered.or(other.prefiltered), bandwidth: self.bandwidth.or(other.bandwidth) }
    }
}

/// Names of the maps for adaptive shading among the parts of a material.
pub const PARTS: [&str; 2] = ["bandwidth", "samples"];
/// Name of the bandwidth map of a texture among the parts of a material, and key of the texture of a use.
pub const TEXTURE: &str = "texture";
/// Names of the maps of the environment.
pub const ENVIRONMENT_PARTS: [&str; 2] = ["prefiltered", "bandwidth"];

/// File name of a part.
pub fn part_name(material: &str, part: &str) -> String {
    format!("{material}.{part}.ktx2")
}

/// Names of the requested maps among [`PARTS`] or [`ENVIRONMENT_PARTS`], in the order in which [`material_maps`] and
/// [`environment_maps`] return their bytes.
pub fn requested_parts(parts: [&'static str; 2], requested: RequestedMaps) -> impl Iterator<Item = &'static str> {
    parts.into_iter().zip(requested).filter_map(|(part, requested)| requested.then_some(part))
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
    let mut report = MapsReport::default();
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

/// Makes the requested maps of an environment. Returns the bytes of their files.
///
/// # Errors
/// Returns an error if the environment cannot be read, or if the caller cancels.
pub fn environment_maps(
    path: &Path,
    [wants_prefiltered, wants_bandwidth]: RequestedMaps,
    listener: &mut dyn ReadListener,
    progress: &dyn Progress,
) -> Result<(Vec<Vec<u8>>, EnvironmentMaps), JobError> {
    progress.stage(Stage::Read, 1)?;
    let surroundings = Surroundings::from(open_environment_observed(path, listener)?);
    let mut files = Vec::new();
    let mut report = EnvironmentMaps::default();
    if wants_prefiltered {
        let pack = surroundings.prefiltered(surroundings.default_side(), progress).map_err(|error| match error {
            PrefilterError::Cancelled(cancelled) => cancelled.into(),
            PrefilterError::Invalid(error) => JobError::Input(InputError::format(path, error)),
        })?;
        files.push(pack.to_bytes(true));
        report.prefiltered = files.last().map(|bytes| Packed::new(bytes, EnvironmentFacts::new(&pack)));
    }
    if wants_bandwidth {
        progress.stage(Stage::BandwidthMap, 1)?;
        let image = surroundings.into_image();
        let map = environment_map(&image.pixels, image.width, DEFAULT_EPSILON).map_err(JobError::Map)?;
        files.push(map.to_bytes(true));
        report.bandwidth = files.last().map(|bytes| Packed::new(bytes, BandwidthFacts::new(&map)));
    }
    Ok((files, report))
}
