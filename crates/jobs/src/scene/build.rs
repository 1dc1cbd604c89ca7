//! A build from a plan to the files and the report in the output folder.

use super::assets::MadeAsset;
use super::error::JobError;
use super::memory;
use super::plan::{Plan, REPORT, list_name};
use super::run::{BuildContext, Made, Outcome, Outcomes, run};
use super::works::{Work, WorkResult, make};
use crate::error::Error;
use crate::file_name::folded;
use crate::output_folder::{Changes, Contents, OutputFolder};
use crate::report::build::{BuildReport, FileEntry};
use crate::report::list::MaterialFile;
use crate::report::material::StageTime;
use crate::scene::maps::part_name;
use crate::store::{Digest, FOLDER, Store, placing, read_record, write_record};
use brdfc_core::progress::{Cancelled, Progress};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Settings of a build. None of them affects the bytes of a pack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildSettings {
    /// The output folder, which exists.
    pub out: PathBuf,
    /// True if results of earlier builds are reused.
    pub looks_up: bool,
    /// Other output folders, whose stores are copied into this one.
    pub from: Vec<PathBuf>,
    /// True if materials of earlier builds stay that are not part of this one.
    pub keep: bool,
    /// True if the build may replace files that no build wrote.
    pub force: bool,
    /// True if the first failure stops the build and leaves the folder unchanged.
    pub fail_fast: bool,
    /// True if a failure leaves the folder unchanged. The other materials are still made.
    pub whole: bool,
    /// Memory limit of all jobs that run at a time, bytes; `None`: 300 MiB per thread.
    pub memory: Option<u64>,
}

impl BuildSettings {
    /// Settings for a build into `out` that reuses earlier results and continues after failures.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        Self {
            out: out.into(),
            looks_up: true,
            from: Vec::new(),
            keep: false,
            force: false,
            fail_fast: false,
            whole: false,
            memory: None,
        }
    }

    fn memory(&self) -> u64 {
        self.memory.unwrap_or_else(|| memory::PER_THREAD * rayon::current_num_threads() as u64)
    }
}

/// A completed build: its results, its report, and the changes in the folder.
#[derive(Debug)]
pub struct Built {
    /// Result of each material.
    pub outcomes: Outcomes,
    /// The full report, including times.
    pub report: BuildReport,
    /// Changes in the folder; `None` if the build left it unchanged.
    pub changes: Option<Changes>,
}

/// Makes all parts that are not in the store, and updates the folder to match the report. Materials that fail have no
/// files there. The folder stays unchanged if a file cannot be written, and after a failure with `fail_fast` or
/// `whole`.
///
/// # Errors
/// Returns an error if the folder cannot be written to, if a file that no build wrote is in the way, if a file that
/// `keep` retains is lost, or if the caller cancels.
pub fn build(plan: &Plan, settings: &BuildSettings, progress: &dyn Progress) -> Result<Built, Error> {
    let (store, mut folder) = opened(settings, progress)?;
    let there = folder.there();
    let mut names: BTreeSet<String> = plan.files().collect();
    if let Some(retained) = retained(plan, settings, &store, &there)? {
        names.extend(retained.files.into_iter().map(|(name, _)| name));
    }
    folder.refuse_removing(plan.sources(), &names.iter().map(String::as_str).collect())?;
    folder.refuse_foreign(names.iter().map(String::as_str), settings.force)?;
    let placed: BTreeSet<Digest> = there.into_values().collect();
    let context =
        BuildContext { store: &store, placed: &placed, memory: settings.memory(), fail_fast: settings.fail_fast };
    let outcomes = run(plan, &context, progress);
    // With `fail_fast`, the failure of one job cancels the rest.
    let stopped = outcomes.errors().any(JobError::is_cancelled);
    if stopped && !(settings.fail_fast && outcomes.any_failed()) {
        return Err(Cancelled.into());
    }
    let mut report = BuildReport::new(plan, &outcomes);
    let broken = outcomes.errors().next().is_some();
    let passed = outcomes.materials.iter().all(|one| one.passed()) && outcomes.assets.iter().all(|one| one.passed());
    let failed = broken || !passed;
    let unwritten = outcomes.errors().any(|error| matches!(error, JobError::Store(_)));
    if settings.fail_fast && failed || settings.whole && broken || unwritten {
        return Ok(Built { outcomes, report, changes: None });
    }
    let changes = {
        let _placing = placing();
        progress.check()?;
        folder.place(&store, progress, |there| {
            let mut stays = Vec::new();
            if let Some(retained) = retained(plan, settings, &store, there)? {
                stays = retained.files;
                report = report.clone().with_retained(retained.report);
            }
            stays.extend(files(plan, &outcomes, report.clone().without_run_details(plan, &settings.out)));
            Ok(stays)
        })?
    };
    let retained = report.materials.iter().filter(|entry| entry.retained).map(|entry| entry.material.as_str());
    write_notes(&store, plan, &outcomes, &retained.collect::<Vec<_>>());
    store.prune();
    Ok(Built { outcomes, report, changes: Some(changes) })
}

/// Entries and files of the previous build that stay with `keep`.
struct Retained {
    report: BuildReport,
    files: Vec<(String, Contents)>,
}

/// Selects what stays of the previous build; `None` without `keep`. Missing and damaged files come from the store.
///
/// # Errors
/// Returns an error if a file of an earlier build is in no report, or if a listed file is lost.
fn retained(
    plan: &Plan,
    settings: &BuildSettings,
    store: &Store,
    there: &BTreeMap<String, Digest>,
) -> Result<Option<Retained>, Error> {
    if !settings.keep {
        return Ok(None);
    }
    let out = settings.out.as_path();
    let without = "or build without --keep";
    let earlier = match BuildReport::open(&out.join(REPORT)) {
        Ok(report) => report,
        Err(error) => match unlisted(plan, out, there) {
            None => return Ok(None),
            Some(file) => {
                let lost = format!("--keep needs the {REPORT} of the build that made {file}");
                return Err(Error::io(format!("{error}\n{}: {lost}; restore it, {without}", out.display())));
            }
        },
    };
    let names = plan.jobs.iter().map(|job| &job.name).chain(plan.assets.iter().map(|job| &job.name));
    let asked: BTreeSet<String> = names.map(|name| folded(name)).collect();
    let report = earlier.retained_with(&asked, plan.environment.is_some());
    let lists = report.materials.iter().filter_map(|entry| Some((entry.list.as_ref()?, entry.file()?.to_bytes())));
    let lists: BTreeMap<&str, Vec<u8>> = lists
        .filter(|(list, bytes)| list.blake3 == Digest::of(bytes))
        .map(|(list, b)| (list.file.as_str(), b))
        .collect();
    let contents = |FileEntry { file, blake3 }: &FileEntry| {
        let is_there = there.get(file) == Some(blake3);
        let contents = match lists.get(file.as_str()) {
            _ if is_there || store.object(blake3).is_some() => Contents::Cached(*blake3),
            Some(list) => Contents::Bytes(list.clone()),
            None => {
                let path = out.join(file);
                let lost = if path.exists() { "changed since the build" } else { "missing" };
                let lost = format!("{lost}, and the store has no copy for --keep");
                return Err(Error::io(format!("{}: {lost}; restore it, {without}", path.display())));
            }
        };
        Ok((file.clone(), contents))
    };
    let files = report.files().map(contents).collect::<Result<_, Error>>()?;
    Ok(Some(Retained { report, files }))
}

/// Finds a file of an earlier build that this build does not write: a known one, or else the list of a material.
fn unlisted(plan: &Plan, out: &Path, there: &BTreeMap<String, Digest>) -> Option<String> {
    let written: BTreeSet<String> = plan.files().collect();
    let is_other = |name: &String| !written.contains(name);
    there.keys().cloned().chain(MaterialFile::names_in(out)).find(is_other)
}

/// Facts about a material that are not in its report, because they differ between machines and runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BuiltNote {
    /// Path or address of its source.
    pub source: String,
    /// Settings of reading it, in JSON.
    pub reading: String,
    /// Hash of the source.
    pub digest: Option<Digest>,
    /// Seconds per stage of the run that made its pack.
    pub stages: Vec<StageTime>,
}

const NOTES: &str = "built";

/// Writes the notes that report pages use. They are optional, so errors are ignored.
fn write_notes(store: &Store, plan: &Plan, outcomes: &Outcomes, retained: &[&str]) {
    let note = |(name, made): (&str, &Made)| {
        let job = plan.job(name)?;
        let (input, reading) = (&job.input, &job.reading);
        let reading = serde_json::to_string(reading).ok()?;
        let source = match input.path() {
            Some(path) => std::path::absolute(path).ok()?.display().to_string(),
            None => input.to_string(),
        };
        let (digest, stages) = (Some(made.source), made.pack_times.clone());
        Some((name.to_owned(), BuiltNote { source, reading, digest, stages }))
    };
    let path = store.root().join(NOTES);
    let mut notes: BTreeMap<String, BuiltNote> = if retained.is_empty() { BTreeMap::new() } else { notes_in(&path) };
    notes.retain(|name, _| retained.contains(&name.as_str()));
    notes.extend(outcomes.made().filter_map(note));
    let _ = crate::write::write_atomic(&path, &write_record(&notes));
}

/// Reads the notes of the build that filled a folder, by material; empty if its store is missing.
pub fn notes(out: &Path) -> BTreeMap<String, BuiltNote> {
    notes_in(&out.join(FOLDER).join(NOTES))
}

fn notes_in(path: &Path) -> BTreeMap<String, BuiltNote> {
    read_record(path).unwrap_or_default()
}

/// Makes some work items of a build and stores them in the cache of its folder. The files of the folder stay unchanged.
///
/// # Errors
/// Returns an error if the folder or a store cannot be opened.
pub fn build_works(
    works: &[Work<'_>],
    settings: &BuildSettings,
    progress: &dyn Progress,
) -> Result<Vec<WorkResult>, Error> {
    let (store, folder) = opened(settings, progress)?;
    let placed = folder.there().into_values().collect();
    let context = BuildContext { store: &store, placed: &placed, memory: settings.memory(), fail_fast: false };
    Ok(make(works, &context, progress))
}

/// Opens the store and the folder, and copies the entries of the stores in `from`.
fn opened(settings: &BuildSettings, progress: &dyn Progress) -> Result<(Store, OutputFolder), Error> {
    let store = Store::open(&settings.out, settings.looks_up)?;
    settings.from.iter().try_for_each(|other| store.take_from(other))?;
    let folder = known_folder(&settings.out, &store, progress)?;
    Ok((store, folder))
}

/// Opens an output folder with the files that its report lists. A valid report was written by a build.
pub(super) fn known_folder(out: &Path, store: &Store, progress: &dyn Progress) -> Result<OutputFolder, Error> {
    let mut folder = OutputFolder::open(out, store, progress)?;
    if let Ok((report, digest)) = BuildReport::open_with_digest(&out.join(REPORT)) {
        let listed = report.files().map(|file| (file.file.clone(), file.blake3));
        folder.also_placed(listed.chain([(REPORT.to_owned(), digest)]));
    }
    Ok(folder)
}

/// All files of a build, the report last.
fn files(plan: &Plan, outcomes: &Outcomes, report: BuildReport) -> Vec<(String, Contents)> {
    let mut files = Vec::new();
    for (name, made) in outcomes.made() {
        for (part, digest) in &made.files {
            files.push((part_name(name, part), Contents::Cached(*digest)));
        }
    }
    for (job, outcome) in plan.assets.iter().zip(&outcomes.assets) {
        files.extend(outcome.result.iter().map(|made| (job.file(), Contents::Cached(made.file))));
    }
    if let (Some(job), Some(Ok(made))) = (&plan.environment, &outcomes.environment) {
        files.extend(job.files().zip(made.files.iter().map(|digest| Contents::Cached(*digest))));
    }
    for entry in report.materials.iter().filter(|entry| !entry.retained) {
        if let Some(list) = entry.file() {
            files.push((list_name(&entry.material), Contents::Bytes(list.to_bytes())));
        }
    }
    files.push((REPORT.to_owned(), Contents::Bytes(report.to_file())));
    files
}

impl Outcome {
    /// Returns true if the material was made, meets its limits and passes all gates.
    pub fn passed(&self) -> bool {
        self.result.as_ref().is_ok_and(Made::passed)
    }
}

impl Outcome<MadeAsset> {
    /// Returns true if the asset was made, meets its target and passes all gates.
    pub fn passed(&self) -> bool {
        self.result.as_ref().is_ok_and(MadeAsset::passed)
    }
}

impl Outcomes {
    /// The materials that were made, by name.
    pub fn made(&self) -> impl Iterator<Item = (&str, &Made)> {
        self.materials.iter().filter_map(|outcome| Some((outcome.name.as_str(), outcome.result.as_ref().ok()?)))
    }

    /// Errors of the materials, of the other assets and of the environment.
    pub fn errors(&self) -> impl Iterator<Item = &JobError> {
        let environment = self.environment.iter().filter_map(|result| result.as_ref().err());
        let assets = self.assets.iter().filter_map(|outcome| outcome.result.as_ref().err());
        self.materials.iter().filter_map(|outcome| outcome.result.as_ref().err()).chain(assets).chain(environment)
    }
}
