//! A whole build: what a plan asks for is made, and then put in place together with its report.

use super::error::JobError;
use super::memory;
use super::plan::{Plan, REPORT, list_name};
use super::run::{Made, Outcome, Outcomes, Workshop, run};
use super::works::{Work, WorkResult, make};
use crate::error::Error;
use crate::file_name::folded;
use crate::output_folder::{Changes, Contents, OutputFolder};
use crate::report::build::{BuildReport, FileEntry, environment_map};
use crate::report::list::MaterialFile;
use crate::report::material::StageTime;
use crate::scene::maps::part_name;
use crate::store::{Digest, FOLDER, Store, placing, read_record, write_record};
use brdfc_core::progress::{Cancelled, Progress};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// How a build is done. None of it decides the bytes of a pack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BuildSettings {
    /// The output folder, which is there.
    pub out: PathBuf,
    /// Whether what was made before is used.
    pub looks_up: bool,
    /// Other output folders, of whose stores what is needed is taken.
    pub from: Vec<PathBuf>,
    /// Whether materials of earlier builds stay that this one does not ask for.
    pub keep: bool,
    /// Whether files may be replaced that no build wrote.
    pub force: bool,
    /// Whether the first failure ends the build, and leaves the folder as it was.
    pub fail_fast: bool,
    /// Whether a failure leaves the folder as it was, after all others were made.
    pub whole: bool,
    /// Bytes that all materials that are worked on may take together; `None`: 300 MiB for each thread.
    pub memory: Option<u64>,
}

impl BuildSettings {
    /// A build into `out` that uses what was made before and makes what it can.
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

/// A build that came to its end.
#[derive(Debug)]
pub struct Built {
    /// What became of each material.
    pub outcomes: Outcomes,
    /// All of it, times included.
    pub report: BuildReport,
    /// What changed in the folder; `None` where it was left as it was.
    pub changes: Option<Changes>,
}

/// Makes what is not there yet, and makes the folder what the report says. A material that fails has no files there; where a
/// file could not be written, or the build was to end at the first failure, the folder stays as it was.
///
/// # Errors
/// A folder that cannot be written to, holds files of somebody else, or not all that is to be kept; cancellation.
pub fn build(plan: &Plan, settings: &BuildSettings, progress: &dyn Progress) -> Result<Built, Error> {
    let (store, mut folder) = opened(settings, progress)?;
    let there = folder.there();
    let mut names: BTreeSet<String> = plan.files().collect();
    if let Some(kept) = kept(plan, settings, &store, &there)? {
        names.extend(kept.files.into_iter().map(|(name, _)| name));
    }
    folder.refuse_removing(plan.sources(), &names.iter().map(String::as_str).collect())?;
    folder.refuse_foreign(names.iter().map(String::as_str), settings.force)?;
    let placed: BTreeSet<Digest> = there.into_values().collect();
    let workshop =
        Workshop { store: &store, placed: &placed, memory: settings.memory(), fail_fast: settings.fail_fast };
    let outcomes = run(plan, &workshop, progress);
    // With `fail_fast` it is the failure of another that stops the rest.
    let stopped = outcomes.errors().any(JobError::is_cancelled);
    if stopped && !(settings.fail_fast && outcomes.any_failed()) {
        return Err(Cancelled.into());
    }
    let mut report = BuildReport::new(plan, &outcomes);
    let broken = outcomes.errors().next().is_some();
    let failed = broken || !outcomes.materials.iter().all(Outcome::passed);
    let unwritten = outcomes.errors().any(|error| matches!(error, JobError::Store(_)));
    if settings.fail_fast && failed || settings.whole && broken || unwritten {
        return Ok(Built { outcomes, report, changes: None });
    }
    let changes = {
        let _placing = placing();
        progress.check()?;
        folder.place(&store, progress, |there| {
            let mut stays = Vec::new();
            if let Some(kept) = kept(plan, settings, &store, there)? {
                stays = kept.files;
                report = report.clone().with_kept(kept.report);
            }
            stays.extend(files(&outcomes, report.clone().lasting(plan, &settings.out)));
            Ok(stays)
        })?
    };
    let kept = report.materials.iter().filter(|entry| entry.kept).map(|entry| entry.material.as_str());
    write_notes(&store, plan, &outcomes, &kept.collect::<Vec<_>>());
    store.prune();
    Ok(Built { outcomes, report, changes: Some(changes) })
}

/// What stays of the build before.
struct KeptBuild {
    report: BuildReport,
    files: Vec<(String, Contents)>,
}

/// What stays of the build before, where that was asked for. Files that are missing or damaged come back from the store.
///
/// # Errors
/// Files of earlier builds that no report lists; those that are lost.
fn kept(
    plan: &Plan,
    settings: &BuildSettings,
    store: &Store,
    there: &BTreeMap<String, Digest>,
) -> Result<Option<KeptBuild>, Error> {
    if !settings.keep {
        return Ok(None);
    }
    let out = settings.out.as_path();
    let without = "or a build without --keep";
    let earlier = match BuildReport::open(&out.join(REPORT)) {
        Ok(report) => report,
        Err(error) => match unlisted(plan, out, there) {
            None => return Ok(None),
            Some(file) => {
                let found = format!("{file} of an earlier build, which --keep finds in no report");
                let allowed = format!("with the {REPORT} of that build, {without}");
                return Err(Error::io(format!("{error}\n{}: found {found}; allowed {allowed}", out.display())));
            }
        },
    };
    let asked: BTreeSet<String> = plan.jobs.iter().map(|job| folded(&job.name)).collect();
    let report = earlier.kept_beside(&asked, plan.environment.is_some());
    let lists = report.materials.iter().filter_map(|entry| Some((entry.list.as_ref()?, entry.file()?.to_bytes())));
    let lists: BTreeMap<&str, Vec<u8>> = lists
        .filter(|(list, bytes)| list.blake3 == Digest::of(bytes))
        .map(|(list, b)| (list.file.as_str(), b))
        .collect();
    let contents = |FileEntry { file, blake3 }: &FileEntry| {
        let is_there = there.get(file) == Some(blake3);
        let contents = match lists.get(file.as_str()) {
            _ if is_there || store.object(blake3).is_some() => Contents::Kept(*blake3),
            Some(list) => Contents::Bytes(list.clone()),
            None => {
                let path = out.join(file);
                let found = if path.exists() { "other bytes than those" } else { "nothing in place" };
                let allowed = format!("the file that {REPORT} lists, which --keep is to leave there, {without}");
                let found = format!("{found} of the build before, and no copy in the store");
                return Err(Error::io(format!("{}: found {found}; allowed {allowed}", path.display())));
            }
        };
        Ok((file.clone(), contents))
    };
    let files = report.files().map(contents).collect::<Result<_, Error>>()?;
    Ok(Some(KeptBuild { report, files }))
}

/// A file of an earlier build that this one does not write: one that is known, or else a material's list.
fn unlisted(plan: &Plan, out: &Path, there: &BTreeMap<String, Digest>) -> Option<String> {
    let written: BTreeSet<String> = plan.files().collect();
    let is_other = |name: &String| !written.contains(name);
    there.keys().cloned().chain(MaterialFile::names_in(out)).find(is_other)
}

/// What is known of a material besides its report, and differs between machines and runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BuiltNote {
    /// Path or address of its source.
    pub source: String,
    /// Hash of what was read of it.
    pub digest: Option<Digest>,
    /// Seconds per stage when its pack was made.
    pub stages: Vec<StageTime>,
}

const NOTES: &str = "built";

/// Keeps notes for pages about the build. They are no part of it: where they cannot be kept nothing else is wrong.
fn write_notes(store: &Store, plan: &Plan, outcomes: &Outcomes, kept: &[&str]) {
    let note = |(name, made): (&str, &Made)| {
        let input = &plan.job(name)?.input;
        let source = match input.path() {
            Some(path) => std::path::absolute(path).ok()?.display().to_string(),
            None => input.to_string(),
        };
        Some((name.to_owned(), BuiltNote { source, digest: Some(made.source), stages: made.pack_times.clone() }))
    };
    let path = store.root().join(NOTES);
    let mut notes: BTreeMap<String, BuiltNote> = if kept.is_empty() { BTreeMap::new() } else { notes_in(&path) };
    notes.retain(|name, _| kept.contains(&name.as_str()));
    notes.extend(outcomes.made().filter_map(note));
    let _ = crate::write::write_atomic(&path, &write_record(&notes));
}

/// The notes of the build that filled a folder, by material; none where its store is gone.
pub fn notes(out: &Path) -> BTreeMap<String, BuiltNote> {
    notes_in(&out.join(FOLDER).join(NOTES))
}

fn notes_in(path: &Path) -> BTreeMap<String, BuiltNote> {
    read_record(path).unwrap_or_default()
}

/// Makes some pieces of a build and keeps them in the store of its folder, which stays as it is otherwise.
pub fn build_works(
    works: &[Work<'_>],
    settings: &BuildSettings,
    progress: &dyn Progress,
) -> Result<Vec<WorkResult>, Error> {
    let (store, folder) = opened(settings, progress)?;
    let placed = folder.there().into_values().collect();
    let workshop = Workshop { store: &store, placed: &placed, memory: settings.memory(), fail_fast: false };
    Ok(make(works, &workshop, progress))
}

/// The store and the folder, with what was brought from elsewhere.
fn opened(settings: &BuildSettings, progress: &dyn Progress) -> Result<(Store, OutputFolder), Error> {
    let store = Store::open(&settings.out, settings.looks_up)?;
    settings.from.iter().try_for_each(|other| store.take_from(other))?;
    let folder = known_folder(&settings.out, &store, progress)?;
    Ok((store, folder))
}

/// An output folder with what its report says is there; a report that can be read is a build's own.
pub(super) fn known_folder(out: &Path, store: &Store, progress: &dyn Progress) -> Result<OutputFolder, Error> {
    let mut folder = OutputFolder::open(out, store, progress)?;
    if let Ok((report, digest)) = BuildReport::open_with_digest(&out.join(REPORT)) {
        let listed = report.files().map(|file| (file.file.clone(), file.blake3));
        folder.also_placed(listed.chain([(REPORT.to_owned(), digest)]));
    }
    Ok(folder)
}

/// Everything that stands in the folder, the report last.
fn files(outcomes: &Outcomes, report: BuildReport) -> Vec<(String, Contents)> {
    let mut files = Vec::new();
    for (name, made) in outcomes.made() {
        for (part, digest) in &made.files {
            files.push((part_name(name, part), Contents::Kept(*digest)));
        }
    }
    for entry in report.materials.iter().filter(|entry| !entry.kept) {
        if let Some(list) = entry.file() {
            files.push((list_name(&entry.material), Contents::Bytes(list.to_bytes())));
        }
    }
    if let Some(Ok(made)) = &outcomes.environment {
        files.push((environment_map(), Contents::Kept(made.file)));
    }
    files.push((REPORT.to_owned(), Contents::Bytes(report.to_file())));
    files
}

impl Outcome {
    /// Whether it is what was asked for.
    pub fn passed(&self) -> bool {
        self.result.as_ref().is_ok_and(Made::passed)
    }
}

impl Outcomes {
    /// The materials that were made, by name.
    pub fn made(&self) -> impl Iterator<Item = (&str, &Made)> {
        self.materials.iter().filter_map(|outcome| Some((outcome.name.as_str(), outcome.result.as_ref().ok()?)))
    }

    /// Why materials or the environment failed.
    pub fn errors(&self) -> impl Iterator<Item = &JobError> {
        let environment = self.environment.iter().filter_map(|result| result.as_ref().err());
        self.materials.iter().filter_map(|outcome| outcome.result.as_ref().err()).chain(environment)
    }
}
