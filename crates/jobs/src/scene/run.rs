//! Runs a build: one job per needed material, and one for the environment where it is needed.

pub use super::error::JobError;

use super::manifest::Manifest;
use super::maps::{self, MapRecipe, MapsReport, Packed, environment_file, material_maps, part_name};
use super::needs::{self, needs};
use super::scene_section::ENVIRONMENT;
use crate::cache::{self, Origin, Slot};
use crate::encode::encode;
use crate::encode::recipe::PackRecipe;
use crate::report::material::{MaterialReport, StageTime};
use crate::stage_clock::StageClock;
use crate::write::write_atomic;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_formats::wavelet::DEFAULT_DISTANCE_SCALE;
use brdfc_source::address;
use brdfc_source::open::open;
use brdfc_source::progress::{Progress, Stage};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// One material to make.
#[derive(Debug, Clone)]
pub struct Job {
    /// The material's name.
    pub name: String,
    /// Path or address as the manifest has it.
    pub declared: String,
    /// Path or address, resolved against the manifest's folder.
    pub source: String,
    /// How it is encoded, needs included.
    pub recipe: PackRecipe,
    /// How its maps are made, where it needs them.
    pub maps: Option<MapRecipe>,
    /// Uses that refer to it.
    pub uses: usize,
}

/// The environment's map.
#[derive(Debug, Clone)]
pub struct EnvironmentJob {
    /// Path as the manifest has it.
    pub declared: String,
    /// Path, resolved against the manifest's folder.
    pub source: String,
    /// `ε` of the bandwidth.
    pub epsilon: f64,
}

/// What a build will do.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Materials to make, by name.
    pub jobs: Vec<Job>,
    /// The environment, where the scene needs its map.
    pub environment: Option<EnvironmentJob>,
    /// Materials that no use refers to: not even opened.
    pub skipped: Vec<String>,
}

impl Plan {
    /// Paths and addresses that are read.
    pub fn sources(&self) -> impl Iterator<Item = &str> {
        let environment = self.environment.iter().map(|job| job.source.as_str());
        self.jobs.iter().map(|job| job.source.as_str()).chain(environment)
    }

    /// Names of the files that a build may write into its folder.
    pub fn files(&self) -> impl Iterator<Item = String> {
        let environment = self.environment.iter().map(|_| part_name(ENVIRONMENT, "bandwidth"));
        let of_job = |job: &Job| {
            let maps = maps::PARTS.iter().filter(|_| job.maps.is_some()).map(|part| part_name(&job.name, part));
            [pack_name(&job.name), list_name(&job.name)].into_iter().chain(maps).collect::<Vec<_>>()
        };
        self.jobs.iter().flat_map(of_job).chain(environment)
    }
}

/// The file that lists the parts of a material.
fn list_name(material: &str) -> String {
    format!("{material}.json")
}

/// What a build did.
#[derive(Debug)]
pub struct Outcomes {
    /// To each material, in the order of the plan.
    pub materials: Vec<Outcome>,
    /// To the environment, where it was planned.
    pub environment: Option<Result<MadeEnvironment, JobError>>,
}

/// What a build did to one material.
#[derive(Debug)]
pub struct Outcome {
    /// The material's name.
    pub name: String,
    /// Report and times, or why there is no pack.
    pub result: Result<Made, JobError>,
}

/// A material that is there now.
#[derive(Debug, Clone)]
pub struct Made {
    /// What was measured.
    pub report: MaterialReport,
    /// What its maps hold, where it needs them.
    pub maps: Option<MapsReport>,
    /// Seconds per stage; `None` when all files of an earlier build still hold.
    pub times: Option<Vec<StageTime>>,
}

/// The environment's map, which is there now.
#[derive(Debug, Clone)]
pub struct MadeEnvironment {
    /// What it holds.
    pub report: Packed<BandwidthFacts>,
    /// Seconds per stage; `None` when the map of an earlier build still holds.
    pub times: Option<Vec<StageTime>>,
}

/// The parts of a material, as `<material>.json` lists them.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct MaterialFile {
    /// Layout of this file.
    pub version: u32,
    /// The material's name.
    pub material: String,
    /// Files of the material, by part: `brdf` is the pack; where an environment lights the scene, `bandwidth` is
    /// the bandwidth map and `samples` are the importance samples.
    pub parts: BTreeMap<String, String>,
    /// What was measured.
    pub report: MaterialReport,
    /// What the maps hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maps: Option<MapsReport>,
}

/// Plans a build: which materials, with which recipes.
pub fn plan(manifest: &Manifest, folder: &Path) -> Plan {
    let needed = needs(manifest);
    let scale = manifest.scene.distance_scale.unwrap_or(DEFAULT_DISTANCE_SCALE);
    let environment = needs::environment(manifest).map(|declared| EnvironmentJob {
        declared: declared.to_owned(),
        source: folder.join(declared).display().to_string(),
        epsilon: MapRecipe::default().epsilon,
    });
    let mut plan = Plan { jobs: Vec::new(), environment, skipped: Vec::new() };
    for (name, material) in &manifest.materials {
        let Some(need) = needed.get(name.as_str()) else {
            plan.skipped.push(name.clone());
            continue;
        };
        let mut recipe = material.options.resolve(&manifest.defaults).expect("checked when the manifest was parsed");
        recipe.limit_levels(|levels| need.stored_levels(levels, scale));
        let source = if address::is_synth(&material.source) {
            material.source.clone()
        } else {
            folder.join(&material.source).display().to_string()
        };
        let declared = material.source.clone();
        let maps = need.maps.then(MapRecipe::default);
        plan.jobs.push(Job { name: name.clone(), declared, source, recipe, maps, uses: need.uses });
    }
    plan
}

/// The pack's file of a material.
pub fn pack_name(material: &str) -> String {
    part_name(material, "brdf")
}

/// What all jobs of a build share.
struct Build<'a> {
    out: &'a Path,
    /// Hash of the program, if the cache is used.
    program: Option<[u8; 32]>,
}

/// Runs all jobs; one that fails does not stop the others.
pub fn run(plan: &Plan, out: &Path, use_cache: bool, progress: &dyn Progress) -> Outcomes {
    let program = if use_cache { cache::hash_program().ok() } else { None };
    let build = Build { out, program };
    let materials = || {
        plan.jobs
            .par_iter()
            .map(|job| {
                let part = progress.part(&job.name);
                let result = build.material(job, part.as_ref());
                part.finished(result.is_ok());
                Outcome { name: job.name.clone(), result }
            })
            .collect()
    };
    let environment = || {
        let part = progress.part(ENVIRONMENT);
        let result = build.environment(plan.environment.as_ref()?, part.as_ref());
        part.finished(result.is_ok());
        Some(result)
    };
    let (environment, materials) = rayon::join(environment, materials);
    Outcomes { materials, environment }
}

impl<'a> Build<'a> {
    /// What a source is now, if that is to be compared with what it was.
    fn origin(&self, source: &str) -> Option<Origin> {
        let program = self.program?;
        let source = if address::is_synth(source) {
            cache::hash(source.as_bytes())
        } else {
            cache::hash_file(Path::new(source)).ok()?
        };
        Some(Origin { program, source })
    }

    fn slot<R>(&self, name: String, files: Vec<String>, origin: Option<Origin>, recipe: R) -> Slot<'a, R> {
        Slot { out: self.out, name, files, origin, recipe }
    }

    fn material(&self, job: &Job, progress: &dyn Progress) -> Result<Made, JobError> {
        progress.check()?;
        let origin = self.origin(&job.source);
        let pack_slot = self.slot(job.name.clone(), vec![pack_name(&job.name)], origin, job.recipe.clone());
        let map_slot = job.maps.map(|recipe| {
            let files = maps::PARTS.map(|part| part_name(&job.name, part)).to_vec();
            self.slot(format!("{}.maps", job.name), files, origin, recipe)
        });
        let kept_pack: Option<MaterialReport> = pack_slot.look_up();
        let kept_maps: Option<MapsReport> = map_slot.as_ref().and_then(Slot::look_up);
        if let Some(report) = &kept_pack
            && kept_maps.is_some() == map_slot.is_some()
        {
            self.list(job, report, kept_maps.as_ref())?;
            return Ok(Made { report: report.clone(), maps: kept_maps, times: None });
        }

        let clock = StageClock::new(progress);
        clock.stage(Stage::Read, 1)?;
        let opened = open(&job.source, None)?;
        let (report, packs) = match kept_pack {
            Some(report) => (report, Vec::new()),
            None => {
                let encoded = encode(opened.source.as_ref(), &job.recipe, &clock)?;
                let report = MaterialReport::new(&encoded, &opened.facts);
                (report, vec![encoded.bytes])
            }
        };
        let (maps, map_files) = match (&job.maps, kept_maps) {
            (Some(recipe), None) => {
                let (files, report) = material_maps(opened.source.as_ref(), recipe, &clock)?;
                (Some(report), files.to_vec())
            }
            (_, kept) => (kept, Vec::new()),
        };
        // What is finished is written, cancelled or not.
        let _ = clock.stage(Stage::Write, 1);
        self.write_all(&pack_slot, &packs)?;
        if let Some(slot) = &map_slot {
            self.write_all(slot, &map_files)?;
        }
        self.list(job, &report, maps.as_ref())?;
        if !packs.is_empty() {
            pack_slot.store(&packs, &report);
        }
        if let (Some(slot), Some(maps), false) = (&map_slot, &maps, map_files.is_empty()) {
            slot.store(&map_files, maps);
        }
        Ok(Made { report, maps, times: Some(clock.finish()) })
    }

    fn environment(&self, job: &EnvironmentJob, progress: &dyn Progress) -> Result<MadeEnvironment, JobError> {
        let file = part_name(ENVIRONMENT, "bandwidth");
        let slot = self.slot(format!("{ENVIRONMENT}.bandwidth"), vec![file], self.origin(&job.source), job.epsilon);
        if let Some(report) = slot.look_up() {
            return Ok(MadeEnvironment { report, times: None });
        }
        let clock = StageClock::new(progress);
        let (bytes, report) = environment_file(Path::new(&job.source), job.epsilon, &clock)?;
        // What is finished is written, cancelled or not.
        let _ = clock.stage(Stage::Write, 1);
        let files = [bytes];
        self.write_all(&slot, &files)?;
        slot.store(&files, &report);
        Ok(MadeEnvironment { report, times: Some(clock.finish()) })
    }

    /// Writes the files of a slot, or nothing where there are no bytes.
    fn write_all<R>(&self, slot: &Slot<'_, R>, files: &[Vec<u8>]) -> Result<(), JobError> {
        slot.files.iter().zip(files).try_for_each(|(file, bytes)| write(&self.out.join(file), bytes))
    }

    /// Writes the list of a material's files.
    fn list(&self, job: &Job, report: &MaterialReport, maps: Option<&MapsReport>) -> Result<(), JobError> {
        let parts = maps.is_some().then_some(maps::PARTS).into_iter().flatten().chain(["brdf"]);
        let file = MaterialFile {
            version: 1,
            material: job.name.clone(),
            parts: parts.map(|part| (part.to_owned(), part_name(&job.name, part))).collect(),
            report: report.clone(),
            maps: maps.cloned(),
        };
        let mut bytes = serde_json::to_vec_pretty(&file).expect("reports are plain data");
        bytes.push(b'\n');
        write(&self.out.join(list_name(&job.name)), &bytes)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), JobError> {
    write_atomic(path, bytes).map_err(|error| JobError::Write { path: path.display().to_string(), error })
}
