//! Makes what a plan asks for: one job per material, and one for the environment where it is needed. What was made before
//! from the same is taken from the store.

pub use super::error::JobError;

use super::gates;
use super::grid_cache::StoreGridCache;
use super::maps::{MapsReport, Packed, WantedMaps, environment_file, map_recipe, material_maps, wanted_parts};
use super::memory::{self, Shared};
use super::plan::{EnvironmentJob, Job, Plan};
use super::scene_section::ENVIRONMENT;
use crate::encode::{PackRecipe, encode_cached};
use crate::report::gate::GateResult;
use crate::report::material::{MaterialReport, StageTime};
use crate::stage_clock::StageClock;
use crate::store::{Digest, HeardDigest, Kept, Key, Stamp, Store};
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_source::open::{Facts, Opened, open, open_file_heard};
use brdfc_source::{Input, InputError};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

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

/// A material that is in the store now.
#[derive(Debug, Clone)]
pub struct Made {
    /// What was measured.
    pub report: MaterialReport,
    /// What its maps hold, where it needs them.
    pub maps: Option<MapsReport>,
    /// Hash of what it was made of.
    pub source: Digest,
    /// What its gates saw.
    pub gates: Vec<GateResult>,
    /// Its files, by part.
    pub files: Vec<(&'static str, Digest)>,
    /// Seconds per stage; `None` where nothing had to be made.
    pub times: Option<Vec<StageTime>>,
    /// Seconds per stage when the pack was made, now or before.
    pub pack_times: Vec<StageTime>,
}

/// What the store keeps of a pack.
type PackNote = (MaterialReport, Vec<StageTime>);

impl Made {
    /// Whether it is what was asked for.
    pub fn passed(&self) -> bool {
        self.report.missed.is_none() && self.gates.iter().all(|gate| gate.passed)
    }
}

/// The environment's map, which is in the store now.
#[derive(Debug, Clone)]
pub struct MadeEnvironment {
    /// What it holds.
    pub report: Packed<BandwidthFacts>,
    /// The file.
    pub file: Digest,
    /// Seconds per stage; `None` where nothing had to be made.
    pub times: Option<Vec<StageTime>>,
}

/// The pack, as a part.
pub const PACK: &str = "brdf";

/// What all jobs share.
pub struct Workshop<'a> {
    /// What was made before, and where what is made is kept.
    pub store: &'a Store,
    /// Hashes of files of earlier builds that are in their places.
    pub placed: &'a BTreeSet<Digest>,
    /// Bytes that all may take together.
    pub memory: u64,
    /// Whether the first failure ends the work.
    pub fail_fast: bool,
}

/// Runs all jobs; one that fails does not stop the others, unless the workshop says so.
pub fn run(plan: &Plan, workshop: &Workshop<'_>, progress: &dyn Progress) -> Outcomes {
    let shared = Shared::new(workshop.memory);
    let stop = AtomicBool::new(false);
    // The environment comes first: it has no part in what materials share, and others wait for none of it.
    let first = usize::from(plan.environment.is_some());
    // Two materials of one source and recipe are made once.
    let same = |k: usize| plan.jobs[..k].iter().position(|job| job.is_same_work(&plan.jobs[k]));
    let twins: Vec<Option<usize>> = (0..plan.jobs.len()).map(same).collect();
    let environment = Mutex::new(None);
    let made = in_turn(first + plan.jobs.len(), |number| {
        let Some(number) = number.checked_sub(first) else {
            let job = plan.environment.as_ref()?;
            let part = progress.part(ENVIRONMENT);
            let result = workshop.environment(job, &shared, part.as_ref());
            part.finished(result.is_ok());
            *environment.lock().expect("nobody panics with it") = Some(result);
            return None;
        };
        if twins[number].is_some() {
            return None;
        }
        let job = &plan.jobs[number];
        let part = progress.part(&job.name);
        let result = if stop.load(Ordering::Relaxed) {
            Err(JobError::Cancelled(Cancelled))
        } else {
            let result = workshop.material(job, &shared, part.as_ref());
            part.finished(result.is_ok());
            result
        };
        if workshop.fail_fast && !result.as_ref().is_ok_and(Made::passed) {
            stop.store(true, Ordering::Relaxed);
        }
        Some(result)
    });
    let mut materials: Vec<Outcome> = Vec::new();
    for ((job, twin), result) in plan.jobs.iter().zip(twins).zip(made.into_iter().skip(first)) {
        let of_twin = || {
            let part = progress.part(&job.name);
            let result = match twin.and_then(|twin| materials[twin].result.as_ref().ok()) {
                Some(made) => Ok(Made { gates: gates::check(&job.gates, &made.report), times: None, ..made.clone() }),
                // What it fails by names the source as this material has it.
                None => workshop.material(job, &shared, part.as_ref()),
            };
            part.finished(result.is_ok());
            result
        };
        let result = result.unwrap_or_else(of_twin);
        materials.push(Outcome { name: job.name.clone(), result });
    }
    Outcomes { materials, environment: environment.into_inner().expect("nobody panics with it") }
}

/// Does all work in order, as many at a time as there are threads, and gives the results in that order.
///
/// Each thread of a pool of its own does whole pieces of work, one after the other; a thread that waits does parts of others'
/// loops. As tasks of the common pool they would be begun by a thread that waits for a part of a loop, too: more of them would
/// take memory, and the one below would stand still until the one above is done, or for ever, where that waits for its memory.
pub(super) fn in_turn<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<T>>> = Mutex::new((0..count).map(|_| None).collect());
    let one_by_one = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return;
            }
            let result = work(number);
            results.lock().expect("nobody panics with it")[number] = Some(result);
        }
    };
    match rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build() {
        Ok(pool) => {
            pool.broadcast(|_| one_by_one());
        }
        Err(_) => one_by_one(),
    }
    let results = results.into_inner().expect("nobody panics with it");
    results.into_iter().map(|result| result.expect("each was done")).collect()
}

/// What stands in the store of one material.
struct Shelf {
    source: Digest,
    pack: Option<Kept<PackNote>>,
    maps: Option<Kept<MapsReport>>,
}

/// Which parts of a material are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wanted {
    pack: bool,
    maps: bool,
}

impl Wanted {
    pub(super) const PACK: Self = Self { pack: true, maps: false };
    pub(super) const MAPS: Self = Self { pack: false, maps: true };
    const ALL: Self = Self { pack: true, maps: true };
}

impl Shelf {
    fn has(&self, job: &Job, wanted: Wanted) -> bool {
        let maps = self.maps.is_some() || job.maps == [false; 2];
        (self.pack.is_some() || !wanted.pack) && (maps || !wanted.maps)
    }
}

impl Workshop<'_> {
    /// A material, from the store or made now.
    ///
    /// # Errors
    /// Sources that cannot be read, recipes that cannot be followed, files that cannot be written, cancellation.
    pub fn material(&self, job: &Job, shared: &Shared, progress: &dyn Progress) -> Result<Made, JobError> {
        let (shelf, times) = self.shelf(job, Wanted::ALL, shared, progress)?;
        Ok(of_shelf(job, shelf, times))
    }

    /// A material that is in the store, made of what its source is now.
    pub fn known(&self, job: &Job) -> Option<Made> {
        let known = job.input.path().and_then(|path| self.store.known(path));
        let read = || Some(opened_with_digest(&job.input, &kind_of(&job.input), u64::MAX).ok()?.1);
        self.known_of(job, known.or_else(read)?)
    }

    /// A material that is in the store, made of the source with this hash.
    pub fn known_of(&self, job: &Job, source: Digest) -> Option<Made> {
        let shelf = self.look_up(job, source);
        shelf.has(job, Wanted::ALL).then(|| of_shelf(job, shelf, None))
    }

    /// Some parts of a material; whether anything had to be made.
    pub(super) fn made_part(
        &self,
        job: &Job,
        wanted: Wanted,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<bool, JobError> {
        Ok(self.shelf(job, wanted, shared, progress)?.1.is_some())
    }

    /// What is wanted of a material, and seconds per stage where something had to be made.
    fn shelf(
        &self,
        job: &Job,
        wanted: Wanted,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<(Shelf, Option<Vec<StageTime>>), JobError> {
        progress.check()?;
        let known = job.input.path().and_then(|path| self.store.known(path));
        if let Some(source) = known {
            let shelf = self.look_up(job, source);
            if shelf.has(job, wanted) {
                return Ok((shelf, None));
            }
        }
        let clock = StageClock::new(progress);
        clock.stage(Stage::Read, 1)?;
        let length = job.input.path().and_then(|path| path.metadata().ok()).map_or(0, |metadata| metadata.len());
        let extension = kind_of(&job.input);
        let bytes = memory::of_source(&extension, length).saturating_add(job.recipe.memory());
        let _share = shared.take(bytes);
        progress.check()?;
        // On the pool's threads, so that no more than those work.
        let (shelf, all_kept) = rayon::scope(|_| self.fill(job, wanted, &extension, &clock))?;
        Ok((shelf, if all_kept { None } else { Some(clock.finish()) }))
    }

    /// Reads the source, and makes what is not in the store; whether nothing had to be made.
    fn fill(
        &self,
        job: &Job,
        wanted: Wanted,
        extension: &str,
        clock: &StageClock<'_>,
    ) -> Result<(Shelf, bool), JobError> {
        let longest = memory::longest_source(extension, self.memory);
        let (opened, source, stamp) = opened_with_digest(&job.input, extension, longest)?;
        if let Some(path) = job.input.path() {
            self.remember(path, source, stamp);
        }
        let mut shelf = self.look_up(job, source);
        if shelf.has(job, wanted) {
            return Ok((shelf, true));
        }
        if wanted.pack && shelf.pack.is_none() {
            shelf.pack = Some(self.make_pack(&opened, source, &job.recipe, clock)?);
        }
        if wanted.maps && job.maps != [false; 2] && shelf.maps.is_none() {
            shelf.maps = Some(self.make_maps(&opened, source, job.maps, clock)?);
        }
        Ok((shelf, false))
    }

    fn look_up(&self, job: &Job, source: Digest) -> Shelf {
        let (store, placed, has_maps) = (self.store, self.placed, job.maps != [false; 2]);
        Shelf {
            source,
            pack: store.look_up(&pack_key(source, &job.recipe), placed),
            maps: if has_maps { store.look_up(&maps_key(source, job.maps), placed) } else { None },
        }
    }

    /// Notes by what a source is known again that was read.
    fn remember(&self, path: &Path, digest: Digest, stamp: Option<Stamp>) {
        if let Some(stamp) = stamp {
            self.store.remember(path, stamp, digest);
        }
    }

    fn make_pack(
        &self,
        opened: &Opened,
        source: Digest,
        recipe: &PackRecipe,
        clock: &StageClock<'_>,
    ) -> Result<Kept<PackNote>, JobError> {
        let cache = StoreGridCache { store: self.store, source };
        let encoded = encode_cached(opened.source.as_ref(), recipe, &cache, clock)?;
        let report = MaterialReport::new(&encoded, opened, clock)?;
        // What is finished is kept, cancelled or not.
        let _ = clock.stage(Stage::Write, 1);
        let note = (report, clock.so_far());
        let files = self.store.keep(pack_key(source, recipe), &[encoded.bytes], &note).map_err(JobError::Store)?;
        Ok(Kept { report: note, files })
    }

    fn make_maps(
        &self,
        opened: &Opened,
        source: Digest,
        wanted: WantedMaps,
        clock: &StageClock<'_>,
    ) -> Result<Kept<MapsReport>, JobError> {
        let (files, report) = material_maps(opened.source.as_ref(), wanted, clock)?;
        let _ = clock.stage(Stage::Write, 1);
        let files = self.store.keep(maps_key(source, wanted), &files, &report).map_err(JobError::Store)?;
        Ok(Kept { report, files })
    }

    /// The environment's map, from the store or made now.
    pub fn environment(
        &self,
        job: &EnvironmentJob,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<MadeEnvironment, JobError> {
        progress.check()?;
        let path = job.path.as_path();
        let key = |source| Key::new("environment", source, &DEFAULT_EPSILON);
        let kept = |source| self.store.look_up(&key(source), self.placed);
        let found = |Kept { report, files }, times| MadeEnvironment { report, file: files[0], times };
        if let Some(kept) = self.store.known(path).and_then(kept) {
            return Ok(found(kept, None));
        }
        let clock = StageClock::new(progress);
        let _share = shared.take(self.memory / 2);
        let extension = extension_of(path);
        let mut heard = HeardDigest::new(&extension, memory::longest_source(&extension, self.memory));
        let (bytes, report) = rayon::scope(|_| environment_file(path, &mut heard, &clock))?;
        let (source, stamp) = heard.finish().map_err(|error| InputError::io(path, error))?;
        self.remember(path, source, stamp);
        if let Some(kept) = kept(source) {
            return Ok(found(kept, None));
        }
        let _ = clock.stage(Stage::Write, 1);
        let files = self.store.keep(key(source), &[bytes], &report).map_err(JobError::Store)?;
        Ok(found(Kept { report, files }, Some(clock.finish())))
    }
}

/// A source of this kind and of so many bytes at most, the hash of what was read of it, and by what it is known again.
///
/// # Errors
/// What cannot be read, or changes meanwhile.
pub(crate) fn opened_with_digest(
    source: &Input,
    extension: &str,
    longest: u64,
) -> Result<(Opened, Digest, Option<Stamp>), InputError> {
    let Some(path) = source.path() else {
        let opened = open(source, None)?;
        let digest = match &opened.facts {
            Facts::Synth(model) => Digest::of(model.address.as_bytes()),
            _ => Digest::of(source.to_string().as_bytes()),
        };
        return Ok((opened, digest, None));
    };
    let mut heard = HeardDigest::new(extension, longest);
    let opened = open_file_heard(path, None, &mut heard)?;
    let (digest, stamp) = heard.finish().map_err(|error| InputError::io(path, error))?;
    Ok((opened, digest, stamp))
}

/// The ending of a file's name, by which its kind is told.
pub(crate) fn kind_of(source: &Input) -> String {
    source.path().map_or(String::new(), extension_of)
}

fn of_shelf(job: &Job, shelf: Shelf, times: Option<Vec<StageTime>>) -> Made {
    let pack = shelf.pack.expect("the shelf is complete");
    let mut files = vec![(PACK, pack.files[0])];
    let maps = shelf.maps.map(|maps| {
        files.extend(wanted_parts(job.maps).zip(maps.files));
        maps.report
    });
    let (report, pack_times) = pack.report;
    let gates = gates::check(&job.gates, &report);
    Made { report, maps, source: shelf.source, gates, files, times, pack_times }
}

fn pack_key(source: Digest, recipe: &PackRecipe) -> Key {
    Key::new(PACK, source, recipe)
}

fn maps_key(source: Digest, wanted: WantedMaps) -> Key {
    Key::new("maps", source, &(map_recipe(), wanted))
}

fn extension_of(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_lowercase())
}
