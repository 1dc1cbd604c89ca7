//! Runs a build: one job per needed material.

use super::cache::{self, Entry, Key};
use super::manifest::Manifest;
use super::needs::needs;
use super::write::write_atomic;
use crate::brdf::encode::{EncodeError, Observer, Recipe, encode};
use crate::brdf::table::Grid;
use crate::report::material::{MaterialReport, StageTime};
use crate::source::address;
use crate::source::open::{InputError, open};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::pack::DEFAULT_DISTANCE_SCALE;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

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
    pub recipe: Recipe,
    /// Uses that refer to it.
    pub uses: usize,
}

/// What a build will do.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Materials to make, by name.
    pub jobs: Vec<Job>,
    /// Materials that no use refers to: not even opened.
    pub skipped: Vec<String>,
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
    /// Seconds per stage; `None` when the pack of an earlier build still holds.
    pub times: Option<Vec<StageTime>>,
}

/// Why a material failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The source.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The encoder.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// A file that cannot be written.
    #[error("{path}: cannot write: {error}")]
    Write {
        /// Which.
        path: String,
        /// What the system says.
        error: std::io::Error,
    },
}

/// The parts of a material, as `<material>.json` lists them.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct MaterialFile {
    /// Layout of this file.
    pub version: u32,
    /// The material's name.
    pub material: String,
    /// Files of the material, by part; `brdf` is the wavelet pack.
    pub parts: std::collections::BTreeMap<String, String>,
    /// What was measured.
    pub report: MaterialReport,
}

/// Plans a build: which materials, with which recipes.
pub fn plan(manifest: &Manifest, folder: &Path) -> Plan {
    let needed = needs(manifest);
    let scale = manifest.scene.distance_scale.unwrap_or(DEFAULT_DISTANCE_SCALE);
    let mut plan = Plan { jobs: Vec::new(), skipped: Vec::new() };
    for (name, material) in &manifest.materials {
        let Some(need) = needed.get(name.as_str()) else {
            plan.skipped.push(name.clone());
            continue;
        };
        let mut recipe = material.options.resolve(&manifest.defaults).expect("checked when the manifest was parsed");
        recipe.stored_levels = need.stored_levels(recipe.levels, scale);
        let source = if address::is_synth(&material.source) {
            material.source.clone()
        } else {
            folder.join(&material.source).display().to_string()
        };
        let declared = material.source.clone();
        plan.jobs.push(Job { name: name.clone(), declared, source, recipe, uses: need.uses });
    }
    plan
}

/// The pack's file of a material.
pub fn pack_name(material: &str) -> String {
    format!("{material}.brdf.ktx2")
}

/// What a build tells while it runs. Calls come from several threads.
pub trait Watcher: Sync {
    /// A stage of a material starts.
    fn stage(&self, material: &str, stage: &'static str);
    /// A material is finished.
    fn finished(&self, outcome: &Outcome);
}

/// Runs all jobs; one that fails does not stop the others. Outcomes are in the order of the plan.
pub fn run(plan: &Plan, out: &Path, use_cache: bool, cancelled: &AtomicBool, watcher: &dyn Watcher) -> Vec<Outcome> {
    let program = if use_cache { cache::hash_program().ok() } else { None };
    plan.jobs
        .par_iter()
        .map(|job| {
            let result = run_job(job, out, program, cancelled, watcher);
            let outcome = Outcome { name: job.name.clone(), result };
            watcher.finished(&outcome);
            outcome
        })
        .collect()
}

fn run_job(
    job: &Job,
    out: &Path,
    program: Option<[u8; 32]>,
    cancelled: &AtomicBool,
    watcher: &dyn Watcher,
) -> Result<Made, JobError> {
    if cancelled.load(Ordering::Relaxed) {
        return Err(EncodeError::Cancelled.into());
    }
    let pack_path = out.join(pack_name(&job.name));
    let key = program.and_then(|program| {
        let source = if address::is_synth(&job.source) {
            cache::hash(job.source.as_bytes())
        } else {
            cache::hash_file(Path::new(&job.source)).ok()?
        };
        Some(Key { program, source, recipe: job.recipe.clone() })
    });
    let listing = out.join(format!("{}.json", job.name));
    if let Some(key) = &key
        && let Some(report) = cache::look_up(out, &job.name, &pack_path, key)
    {
        write(&listing, &listing_bytes(&job.name, &report))?;
        return Ok(Made { report, times: None });
    }

    let mut clock = StageClock::new(|stage| {
        watcher.stage(&job.name, stage);
        !cancelled.load(Ordering::Relaxed)
    });
    clock.stage("read");
    let opened = open(&job.source, None)?;
    let encoded = encode(opened.source.as_ref(), grid(&job.recipe), &job.recipe, &mut clock)?;
    clock.stage("write");
    write(&pack_path, &encoded.bytes)?;
    let report = MaterialReport::new(&encoded, &job.recipe, opened.facts.samples());
    write(&listing, &listing_bytes(&job.name, &report))?;
    if let Some(key) = key {
        let entry = Entry { key, pack: cache::hash(&encoded.bytes), report: report.clone() };
        // A cache that cannot be kept costs time in the next build, nothing else.
        let _ = cache::store(out, &job.name, &entry);
    }
    Ok(Made { report, times: Some(clock.finish()) })
}

/// The grid of a recipe.
pub fn grid(recipe: &Recipe) -> Grid {
    let parameterisation = Parameterisation::NAMES
        .into_iter()
        .find(|(name, _)| *name == recipe.parameterisation)
        .map_or(Parameterisation::TangentPole, |(_, p)| p);
    Grid { parameterisation, levels: recipe.levels }
}

fn listing_bytes(material: &str, report: &MaterialReport) -> Vec<u8> {
    let file = MaterialFile {
        version: 1,
        material: material.to_owned(),
        parts: [("brdf".to_owned(), pack_name(material))].into(),
        report: report.clone(),
    };
    let mut bytes = serde_json::to_vec_pretty(&file).expect("reports are plain data");
    bytes.push(b'\n');
    bytes
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), JobError> {
    write_atomic(path, bytes).map_err(|error| JobError::Write { path: path.display().to_string(), error })
}

/// Times stages for a caller that may show or cancel them.
pub struct StageClock<F> {
    on_stage: F,
    times: Vec<StageTime>,
    started: Option<(&'static str, Instant)>,
}

impl<F: FnMut(&'static str) -> bool> StageClock<F> {
    /// `on_stage` hears each start and says whether to go on.
    pub fn new(on_stage: F) -> Self {
        Self { on_stage, times: Vec::new(), started: None }
    }

    /// Ends the last stage and gives all times.
    pub fn finish(mut self) -> Vec<StageTime> {
        self.end();
        self.times
    }

    fn end(&mut self) {
        if let Some((stage, start)) = self.started.take() {
            self.times.push(StageTime { stage: stage.to_owned(), seconds: start.elapsed().as_secs_f64() });
        }
    }
}

impl<F: FnMut(&'static str) -> bool> Observer for StageClock<F> {
    fn stage(&mut self, name: &'static str) -> bool {
        self.end();
        self.started = Some((name, Instant::now()));
        (self.on_stage)(name)
    }
}
