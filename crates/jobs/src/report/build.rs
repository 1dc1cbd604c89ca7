//! The report of a build.

use super::gate::GateResult;
use super::list::{MATERIAL_VERSION, MaterialFile, json_file};
use super::material::{MaterialReport, StageTime};
use crate::encode::Predicted;
use crate::error::Error;
use crate::file_name::{folded, is_plain};
use crate::scene::assets::{AssetJob, AssetKind, AssetReport, MadeAsset};
use crate::scene::explain::Explained;
use crate::scene::lobes::{self, LOBES, LobesReport};
use crate::scene::maps::{ENVIRONMENT_PARTS, EnvironmentMaps, MapsReport, PARTS, TEXTURE, part_name};
use crate::scene::plan::{EnvironmentJob, Job, Plan, REPORT, list_name, pack_name};
use crate::scene::run::{JobError, Made, MadeEnvironment, Outcome, Outcomes, PACK};
use crate::scene::scene_section::ENVIRONMENT;
use crate::store::Digest;
use brdfc_source::json::json_problem;
use brdfc_source::read::read_regular_file;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Maximum size of a `report.json`, bytes, enough for some 80,000 materials.
pub const MAX_REPORT_BYTES: u64 = 1 << 30;
/// Layout of the report of a build.
pub const BUILD_VERSION: u32 = 6;

/// Report of a build: `--json` prints it, and `report.json` in the output folder holds it without times and paths.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
pub struct BuildReport {
    /// Layout of this report.
    pub version: u32,
    /// Name of the scene.
    pub scene: String,
    /// Materials that the scene uses, by name.
    pub materials: Vec<MaterialEntry>,
    /// RTI captures, BTFs and environments, by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assets: Vec<AssetEntry>,
    /// The environment that lights the scene; absent if none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentEntry>,
    /// Materials that no use refers to.
    pub skipped: Vec<String>,
    /// Requirements of each material with their reasons and savings. Only in printed reports with `--explain`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needs: Vec<Explained>,
    /// BLAKE3 of the file without this key, its last one: of the text before the comma that the key follows, a line feed, `}` and a
    /// line feed. Only in `report.json`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checksum: Option<Digest>,
}

/// A file of a build.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FileEntry {
    /// Name of the file in the output folder.
    pub file: String,
    /// BLAKE3 of the file.
    pub blake3: Digest,
}

/// One material of a build.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MaterialEntry {
    /// Name of the material.
    pub material: String,
    /// Source of the material, as in the manifest.
    #[serde(default)]
    pub source: String,
    /// The pack, relative to the output folder; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pack: Option<String>,
    /// The lobes, relative to the output folder; only where an environment lights the material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lobes: Option<String>,
    /// The bandwidth map, relative to the output folder; only if a use that an environment lights requests it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<String>,
    /// The importance samples, relative to the output folder; only if a use that an environment lights requests them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<String>,
    /// The bandwidth map of the texture, relative to the output folder; only if a use that an environment lights requests
    /// bandwidth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<String>,
    /// Files of the material with their hashes; none if the material failed, or was only planned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileEntry>,
    /// `<material>.json`, which lists the parts of the material; absent if the material failed, or was only planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list: Option<FileEntry>,
    /// Measurements; absent if it failed, or was only planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub report: Option<MaterialReport>,
    /// Contents of the lobes, the bandwidth map and the samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maps: Option<MapsReport>,
    /// Results of the gates in the manifest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gates: Vec<GateResult>,
    /// Predicted bytes of its pack on a GPU. Only for planned materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted: Option<Predicted>,
    /// Predicted bytes of its lobes on a GPU. Only for planned materials with lobes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_lobes: Option<Predicted>,
    /// Error message; absent if it succeeded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// True if an earlier build made it and this one retained it without requesting it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub retained: bool,
    /// True if all of it came from the store. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cached: Option<bool>,
    /// Seconds per stage. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageTime>>,
}

impl MaterialEntry {
    /// The list of the material's parts; `None` if it failed, or was only planned.
    pub fn file(&self) -> Option<MaterialFile> {
        let [bandwidth, samples] = PARTS;
        let maps = [(bandwidth, &self.bandwidth), (samples, &self.samples), (TEXTURE, &self.texture)];
        let parts = [(PACK, &self.pack), (LOBES, &self.lobes)].into_iter().chain(maps);
        let parts = parts.filter_map(|(part, file)| Some((part.to_owned(), file.clone()?))).collect();
        let (material, report) = (self.material.clone(), self.report.clone()?);
        Some(MaterialFile { version: MATERIAL_VERSION, material, parts, report, maps: self.maps.clone() })
    }

    /// Contents of its lobes, if it has them.
    pub fn lobes_report(&self) -> Option<&LobesReport> {
        self.maps.as_ref()?.lobes.as_ref()
    }

    /// Returns true if it was made, met its limits and passed its gates.
    pub fn passed(&self) -> bool {
        let met = self.report.as_ref().is_some_and(|report| report.missed.is_none());
        met && self.lobes_report().is_none_or(|lobes| lobes.missed.is_none())
            && self.gates.iter().all(|gate| gate.passed)
    }
}

/// An asset of a build that is no material.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetEntry {
    /// Name of the asset.
    pub asset: String,
    /// Kind of the asset.
    pub kind: AssetKind,
    /// Path of the source, as in the manifest.
    pub source: String,
    /// The pack, relative to the output folder, with its hash; absent if the asset failed, or was only planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pack: Option<FileEntry>,
    /// Contents and errors of the pack; absent if the asset failed, or was only planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub report: Option<AssetReport>,
    /// Results of the gates in the manifest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gates: Vec<GateResult>,
    /// Error message; absent if it succeeded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// True if an earlier build made it and this one retained it without requesting it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub retained: bool,
    /// True if it came from the store. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cached: Option<bool>,
    /// Seconds per stage. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageTime>>,
}

impl AssetEntry {
    /// Returns true if it was made, met its target and passed its gates.
    pub fn passed(&self) -> bool {
        let met = self.report.as_ref().is_some_and(|report| report.missed.is_none());
        met && self.gates.iter().all(|gate| gate.passed)
    }

    fn planned(job: &AssetJob) -> Self {
        Self { asset: job.name.clone(), kind: job.kind, source: job.declared.clone(), ..Self::default() }
    }

    fn new(job: &AssetJob, result: &Result<MadeAsset, JobError>) -> Self {
        match result {
            Ok(made) => Self {
                pack: Some(FileEntry { file: job.file(), blake3: made.file }),
                report: Some(made.report.clone()),
                gates: made.gates.clone(),
                cached: Some(made.times.is_none()),
                stages: made.times.clone(),
                ..Self::planned(job)
            },
            Err(error) => Self { error: Some(error.to_string()), ..Self::planned(job) },
        }
    }
}

/// The environment of a build.
#[derive(Debug, Clone, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct EnvironmentEntry {
    /// The image, as in the manifest.
    pub source: String,
    /// The prefiltered environment, which lobes look up, relative to the output folder; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prefiltered: Option<String>,
    /// Bandwidth map of the environment, relative to the output folder; absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<String>,
    /// Files of the environment with their hashes; none if it failed, or was only planned.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileEntry>,
    /// Contents of the maps; absent if the environment failed, or was only planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maps: Option<EnvironmentMaps>,
    /// Error message; absent if it succeeded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// True if an earlier build made it and this one retained it without requesting it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub retained: bool,
    /// True if all of it came from the store. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cached: Option<bool>,
    /// Seconds per stage. Only in printed reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageTime>>,
}

impl BuildReport {
    /// Reads a `report.json`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not a report, has another version, names files outside its folder or
    /// does not match its checksum.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self::open_with_digest(path)?.0)
    }

    /// [`Self::open`], with the hash of the file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not a report, has another version, names files outside its
    /// folder or does not match its checksum.
    pub fn open_with_digest(path: &Path) -> Result<(Self, Digest), Error> {
        let (report, digest, fault) = Self::open_unchecked(path)?;
        fault.map_or(Ok((report, digest)), |fault| Err(Error::input(fault).prefixed(path.display())))
    }

    /// [`Self::open_with_digest`], with the fault of the checksum, if any.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is no report.
    pub(crate) fn open_unchecked(path: &Path) -> Result<(Self, Digest, Option<String>), Error> {
        let bytes = read_regular_file(path, MAX_REPORT_BYTES)?;
        let is_of_build = path.file_name().is_some_and(|name| name == REPORT);
        let remedy = if is_of_build { "; 'brdfc build' rewrites it" } else { "" };
        let rewritten = |what: &str| format!("{what}{remedy}");
        let wrong = |what: String| Error::input(rewritten(&what)).prefixed(path.display());
        let allowed = "the report.json of a build by this version of brdfc";
        let no_report = |found: String| wrong(format!("found {found}, expected {allowed}"));
        let report: Self = serde_json::from_slice(&bytes).map_err(|error| no_report(json_problem(&error)))?;
        if let Some(name) = report.names().find(|name| !is_plain(name)) {
            return Err(wrong(format!("the file {name:?} is outside the folder of the report")));
        }
        if report.version != BUILD_VERSION {
            let version = report.version;
            return Err(wrong(format!("found layout version {version}, expected {BUILD_VERSION}")));
        }
        let fault = match report.checksum {
            None => Some("no checksum at the end"),
            Some(checksum) if is_sealed(&bytes, checksum) => None,
            Some(_) => Some("the checksum does not match, as the file changed after the build"),
        };
        Ok((report, Digest::of(&bytes), fault.map(rewritten)))
    }

    /// The bytes of `report.json`, its checksum last.
    pub fn to_file(&self) -> Vec<u8> {
        let text = json_file(&Self { checksum: None, ..self.clone() });
        let checksum = Digest::of(&text);
        json_file(&Self { checksum: Some(checksum), ..self.clone() })
    }

    /// Names of all files in the report.
    fn names(&self) -> impl Iterator<Item = &str> {
        let parts = self
            .materials
            .iter()
            .flat_map(|entry| [&entry.pack, &entry.lobes, &entry.bandwidth, &entry.samples, &entry.texture]);
        let maps = self.environment.iter().flat_map(EnvironmentEntry::names);
        self.files().map(|entry| &entry.file).chain(parts.flatten()).chain(maps).map(String::as_str)
    }

    /// Reports a finished build.
    pub fn new(plan: &Plan, outcomes: &Outcomes) -> Self {
        let environment = plan.environment.as_ref().zip(outcomes.environment.as_ref());
        let materials = outcomes.materials.iter().filter_map(|outcome| {
            let job = plan.job(&outcome.name)?;
            Some(material_entry(job, outcome))
        });
        Self {
            materials: materials.collect(),
            assets: plan
                .assets
                .iter()
                .zip(&outcomes.assets)
                .map(|(job, made)| AssetEntry::new(job, &made.result))
                .collect(),
            environment: environment.map(|(job, result)| environment_entry(job, result)),
            ..Self::empty(plan)
        }
    }

    /// Reports a planned build. `known` are the materials, and `known_assets` the other assets, that need not be made again.
    pub fn planned(plan: &Plan, known: &BTreeMap<&str, Made>, known_assets: &BTreeMap<&str, MadeAsset>) -> Self {
        let materials = plan.jobs.iter().map(|job| {
            let known = known.get(job.name.as_str());
            let known_lobes = known.and_then(|made| made.maps.as_ref()?.lobes.as_ref());
            let predicted = known.map(|made| Predicted::exactly(made.report.bytes_on_gpu));
            let of_lobes = |recipe| match known_lobes {
                Some(lobes) => Predicted::exactly(lobes.facts.gpu_bytes),
                None => lobes::predict(recipe),
            };
            MaterialEntry {
                predicted: Some(predicted.unwrap_or_else(|| job.recipe.predict())),
                predicted_lobes: job.lobes.as_ref().map(of_lobes),
                cached: known.map(|_| true),
                ..files(job)
            }
        });
        let environment = plan.environment.as_ref().map(EnvironmentEntry::planned);
        let asset = |job: &AssetJob| {
            let known = known_assets.get(job.name.as_str());
            let (report, cached) = (known.map(|made| made.report.clone()), known.map(|_| true));
            AssetEntry { report, cached, ..AssetEntry::planned(job) }
        };
        let assets = plan.assets.iter().map(asset).collect();
        Self { materials: materials.collect(), assets, environment, ..Self::empty(plan) }
    }

    /// Removes details that differ between runs: times, and the paths of the manifest and the packs.
    #[must_use]
    pub fn without_run_details(mut self, plan: &Plan, out: &Path) -> Self {
        let out = format!("{}/", out.display());
        let plain = |error: &mut Option<String>, source: &str, declared: &str| {
            *error = error.as_ref().map(|text| text.replace(source, declared).replace(&out, ""));
        };
        for entry in &mut self.materials {
            (entry.cached, entry.stages) = (None, None);
            if let Some(job) = plan.job(&entry.material) {
                plain(&mut entry.error, &job.input.to_string(), &job.declared);
            }
        }
        for entry in &mut self.assets {
            (entry.cached, entry.stages) = (None, None);
            if let Some(job) = plan.asset(&entry.asset) {
                plain(&mut entry.error, &job.path.display().to_string(), &job.declared);
            }
        }
        if let (Some(entry), Some(job)) = (&mut self.environment, &plan.environment) {
            (entry.cached, entry.stages) = (None, None);
            plain(&mut entry.error, &job.path.display().to_string(), &job.declared);
        }
        self
    }

    /// Selects the entries that a build of the materials and assets `asked` (names that are [`folded`]) retains: those of other names
    /// that were made, and the environment if the build has none.
    #[must_use]
    pub fn retained_with(mut self, asked: &BTreeSet<String>, environment: bool) -> Self {
        self.materials.retain(|entry| !asked.contains(&folded(&entry.material)) && !entry.files.is_empty());
        self.materials.iter_mut().for_each(|entry| entry.retained = true);
        self.assets.retain(|entry| !asked.contains(&folded(&entry.asset)) && entry.pack.is_some());
        self.assets.iter_mut().for_each(|entry| entry.retained = true);
        self.environment = self.environment.filter(|entry| !environment && !entry.files.is_empty());
        self.environment.iter_mut().for_each(|entry| entry.retained = true);
        self
    }

    /// Adds the retained entries of an earlier build.
    #[must_use]
    pub fn with_retained(mut self, retained: Self) -> Self {
        self.materials.extend(retained.materials);
        self.materials.sort_by(|a, b| a.material.cmp(&b.material));
        self.assets.extend(retained.assets);
        self.assets.sort_by(|a, b| a.asset.cmp(&b.asset));
        self.environment = self.environment.or(retained.environment);
        self
    }

    /// All files with their hashes.
    pub fn files(&self) -> impl Iterator<Item = &FileEntry> {
        let of_environment = self.environment.iter().flat_map(|entry| &entry.files);
        let of_materials = self.materials.iter().flat_map(|entry| entry.files.iter().chain(&entry.list));
        let of_assets = self.assets.iter().flat_map(|entry| &entry.pack);
        of_materials.chain(of_assets).chain(of_environment)
    }

    fn empty(plan: &Plan) -> Self {
        let (scene, skipped) = (plan.scene.clone(), plan.skipped.clone());
        Self {
            version: BUILD_VERSION,
            scene,
            materials: Vec::new(),
            assets: Vec::new(),
            environment: None,
            skipped,
            needs: Vec::new(),
            checksum: None,
        }
    }
}

/// True if a file ends with this checksum and it matches the text before it.
fn is_sealed(bytes: &[u8], checksum: Digest) -> bool {
    let end = format!(",\n  \"checksum\": \"{checksum}\"\n}}\n");
    bytes.strip_suffix(end.as_bytes()).is_some_and(|text| Digest::of(&[text, b"\n}\n"].concat()) == checksum)
}

impl EnvironmentEntry {
    /// Entry with the names of its files.
    fn planned(job: &EnvironmentJob) -> Self {
        let [prefiltered, bandwidth] =
            [0, 1].map(|k| job.maps[k].then(|| part_name(ENVIRONMENT, ENVIRONMENT_PARTS[k])));
        Self { source: job.declared.clone(), prefiltered, bandwidth, ..Self::default() }
    }

    /// Names of its files.
    pub(crate) fn names(&self) -> impl Iterator<Item = &String> {
        self.prefiltered.iter().chain(&self.bandwidth)
    }
}

/// Entry of a material with the names of its files.
fn files(job: &Job) -> MaterialEntry {
    let name = |part: &str| Some(part_name(&job.name, part));
    let [bandwidth, samples] = [0, 1].map(|k| name(PARTS[k]).filter(|_| job.maps[k]));
    let (material, source, pack) = (job.name.clone(), job.declared.clone(), Some(pack_name(&job.name)));
    let lobes = job.lobes.and_then(|_| name(LOBES));
    let texture = job.texture.as_ref().and_then(|_| name(TEXTURE));
    MaterialEntry { material, source, pack, lobes, bandwidth, samples, texture, ..MaterialEntry::default() }
}

fn material_entry(job: &Job, outcome: &Outcome) -> MaterialEntry {
    match &outcome.result {
        Ok(made) => {
            let Made { report, maps, gates, files: made_files, times, .. } = made;
            let listed = made_files
                .iter()
                .map(|(part, blake3)| FileEntry { file: part_name(&outcome.name, part), blake3: *blake3 });
            let entry = MaterialEntry {
                files: listed.collect(),
                report: Some(report.clone()),
                maps: maps.clone(),
                gates: gates.clone(),
                cached: Some(times.is_none()),
                stages: times.clone(),
                ..files(job)
            };
            let list = entry.file();
            let list =
                list.map(|list| FileEntry { file: list_name(&outcome.name), blake3: Digest::of(&list.to_bytes()) });
            MaterialEntry { list, ..entry }
        }
        Err(error) => MaterialEntry {
            material: outcome.name.clone(),
            source: job.declared.clone(),
            error: Some(error.to_string()),
            ..MaterialEntry::default()
        },
    }
}

fn environment_entry(job: &EnvironmentJob, result: &Result<MadeEnvironment, JobError>) -> EnvironmentEntry {
    match result {
        Ok(MadeEnvironment { report, files, times }) => EnvironmentEntry {
            files: job.files().zip(files).map(|(file, blake3)| FileEntry { file, blake3: *blake3 }).collect(),
            maps: Some(report.clone()),
            cached: Some(times.is_none()),
            stages: times.clone(),
            ..EnvironmentEntry::planned(job)
        },
        Err(error) => {
            let source = job.declared.clone();
            EnvironmentEntry { source, error: Some(error.to_string()), ..EnvironmentEntry::default() }
        }
    }
}
