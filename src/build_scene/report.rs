//! What a build says about itself.

use crate::table;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_jobs::report::material::{MaterialReport, StageTime};
use brdfc_jobs::scene::maps::{MapsReport, PARTS, Packed, part_name};
use brdfc_jobs::scene::run::{JobError, Made, MadeEnvironment, Outcome, Outcomes, Plan, pack_name};
use brdfc_jobs::scene::scene_section::ENVIRONMENT;
use serde::Serialize;
use std::path::Path;

/// What `--json` prints, and without times what `report.json` in the output folder holds.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// The scene's name.
    scene: String,
    /// Materials that the scene uses, by name.
    materials: Vec<Entry>,
    /// The environment that lights the scene; absent if none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    environment: Option<EnvironmentEntry>,
    /// Materials that no use refers to.
    skipped: Vec<String>,
}

/// One material of a build.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub struct Entry {
    /// Its name.
    material: String,
    /// The pack, relative to the output folder; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pack: Option<String>,
    /// The bandwidth map, likewise; only of scenes that an environment lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    bandwidth: Option<String>,
    /// The importance samples, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<String>,
    /// What was measured; absent if it failed, or was only planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<MaterialReport>,
    /// What the bandwidth map and the samples hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    maps: Option<MapsReport>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// Whether all files of an earlier build were kept. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    cached: Option<bool>,
    /// Seconds per stage. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    stages: Option<Vec<StageTime>>,
}

/// The environment of a build.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub struct EnvironmentEntry {
    /// The image, as the manifest has it.
    source: String,
    /// Its bandwidth map, relative to the output folder; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    bandwidth: Option<String>,
    /// What the map holds; absent if it failed, or was only planned.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<Packed<BandwidthFacts>>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// Whether the map of an earlier build was kept. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    cached: Option<bool>,
    /// Seconds per stage. Only in what is printed.
    #[serde(skip_serializing_if = "Option::is_none")]
    stages: Option<Vec<StageTime>>,
}

impl Report {
    /// Of a finished build.
    pub(super) fn new(scene: &str, plan: &Plan, outcomes: &Outcomes) -> Self {
        let environment = plan.environment.as_ref().zip(outcomes.environment.as_ref());
        Self {
            materials: outcomes.materials.iter().map(entry).collect(),
            environment: environment.map(|(job, result)| environment_entry(&job.declared, result)),
            ..Self::empty(scene, plan)
        }
    }

    /// Of a build that is only planned.
    pub(super) fn planned(scene: &str, plan: &Plan) -> Self {
        let materials = plan.jobs.iter().map(|job| files(&job.name, job.maps.is_some()));
        let environment = plan.environment.as_ref().map(|job| EnvironmentEntry {
            source: job.declared.clone(),
            bandwidth: Some(environment_file()),
            ..EnvironmentEntry::default()
        });
        Self { materials: materials.collect(), environment, ..Self::empty(scene, plan) }
    }

    /// Without what differs between runs: times, and where manifest and packs are.
    pub(super) fn lasting(mut self, plan: &Plan, out: &Path) -> Self {
        let out = format!("{}/", out.display());
        let plain = |error: &mut Option<String>, source: &str, declared: &str| {
            *error = error.as_ref().map(|text| text.replace(source, declared).replace(&out, ""));
        };
        for (entry, job) in self.materials.iter_mut().zip(&plan.jobs) {
            (entry.cached, entry.stages) = (None, None);
            plain(&mut entry.error, &job.source, &job.declared);
        }
        if let (Some(entry), Some(job)) = (&mut self.environment, &plan.environment) {
            (entry.cached, entry.stages) = (None, None);
            plain(&mut entry.error, &job.source, &job.declared);
        }
        self
    }

    fn empty(scene: &str, plan: &Plan) -> Self {
        let (scene, skipped) = (scene.to_owned(), plan.skipped.clone());
        Self { version: 2, scene, materials: Vec::new(), environment: None, skipped }
    }
}

/// The file of the environment's map.
pub(super) fn environment_file() -> String {
    part_name(ENVIRONMENT, PARTS[0])
}

/// A material and its files.
fn files(name: &str, maps: bool) -> Entry {
    let [bandwidth, samples] = PARTS.map(|part| maps.then(|| part_name(name, part)));
    Entry { material: name.to_owned(), pack: Some(pack_name(name)), bandwidth, samples, ..Entry::default() }
}

fn entry(outcome: &Outcome) -> Entry {
    match &outcome.result {
        Ok(Made { report, maps, times }) => Entry {
            report: Some(report.clone()),
            maps: maps.clone(),
            cached: Some(times.is_none()),
            stages: times.clone(),
            ..files(&outcome.name, maps.is_some())
        },
        Err(error) => Entry { material: outcome.name.clone(), error: Some(error.to_string()), ..Entry::default() },
    }
}

fn environment_entry(source: &str, result: &Result<MadeEnvironment, JobError>) -> EnvironmentEntry {
    let source = source.to_owned();
    match result {
        Ok(MadeEnvironment { report, times }) => EnvironmentEntry {
            source,
            bandwidth: Some(environment_file()),
            report: Some(report.clone()),
            error: None,
            cached: Some(times.is_none()),
            stages: times.clone(),
        },
        Err(error) => EnvironmentEntry { source, error: Some(error.to_string()), ..EnvironmentEntry::default() },
    }
}

/// The packs, a line each; where there are maps, those too.
pub(super) fn text(outcomes: &Outcomes) -> String {
    let made = || outcomes.materials.iter().filter_map(|outcome| Some((&outcome.name, outcome.result.as_ref().ok()?)));
    let packs = made().map(|(name, made)| {
        let seconds = made.times.as_ref().map(|times| times.iter().map(|t| t.seconds).sum());
        let mut row = vec![name.clone()];
        row.extend(table::material_row(&made.report, seconds));
        row
    });
    let packs = table::plain(&table::MATERIAL_HEADER, &packs.collect::<Vec<_>>());

    let mut rows = Vec::new();
    if let Some(Ok(made)) = &outcomes.environment {
        rows.push(bandwidth_row(environment_file(), &made.report));
    }
    for (name, maps) in made().filter_map(|(name, made)| Some((name, made.maps.as_ref()?))) {
        let [bandwidth, samples] = PARTS.map(|part| part_name(name, part));
        rows.push(bandwidth_row(bandwidth, &maps.bandwidth));
        let facts = &maps.samples.facts;
        let size = format!("{} x {}", facts.samples, facts.polar * facts.azimuths);
        rows.push(row(samples, size, "-".to_owned(), maps.samples.bytes_on_disk, facts.gpu_bytes));
    }
    if rows.is_empty() {
        return packs;
    }
    let header = ["map", "texels", "largest bandwidth", "on disk", "on GPU"];
    format!("{packs}\n{}", table::plain(&header, &rows))
}

fn bandwidth_row(file: String, map: &Packed<BandwidthFacts>) -> Vec<String> {
    let facts = &map.facts;
    let size = format!("{} x {}", facts.size[0], facts.size[1]);
    row(file, size, format!("{:.2} {}", facts.largest, facts.unit), map.bytes_on_disk, facts.gpu_bytes)
}

fn row(file: String, size: String, largest: String, disk: u64, gpu: u64) -> Vec<String> {
    vec![file, size, largest, table::bytes(disk), table::bytes(gpu)]
}
