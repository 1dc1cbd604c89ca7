//! Runs the jobs of a plan: one per material, and one for the environment if the scene needs its maps. Unchanged
//! results come from the store.

pub use super::error::JobError;

use super::assets::{AssetJob, MadeAsset};
use super::gates;
use super::grid_cache::StoreGridCache;
use super::lobes::{LOBES, LobesReport, material_lobes};
use super::maps::{
    ENVIRONMENT_PARTS, EnvironmentMaps, MapsReport, Packed, RequestedMaps, TEXTURE, environment_maps, map_recipe,
    material_maps, requested_parts,
};
use super::memory::{self, Shared};
use super::plan::{EnvironmentJob, Job, Plan};
use super::scene_section::ENVIRONMENT;
use super::textures::TextureJob;
use crate::encode::{PackRecipe, encode_cached};
use crate::report::gate::GateResult;
use crate::report::material::{MaterialReport, StageTime};
use crate::stage_clock::StageClock;
use crate::store::{Cached, Digest, HashingObserver, Key, Stamp, Store};
use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::{Smooth, Tally};
use brdfc_lobes::LobesRecipe;
use brdfc_source::open::{Facts, Opened, open, open_file_observed};
use brdfc_source::tile_image::open_colours_observed;
use brdfc_source::{Input, InputError, Reading};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Results of a build.
#[derive(Debug)]
pub struct Outcomes {
    /// Results of the materials, in the order of the plan.
    pub materials: Vec<Outcome>,
    /// Results of the assets that are no materials, in the order of the plan.
    pub assets: Vec<Outcome<MadeAsset>>,
    /// Result of the environment; `None` if the plan has none.
    pub environment: Option<Result<MadeEnvironment, JobError>>,
}

/// Result of one material or of another asset.
#[derive(Debug)]
pub struct Outcome<T = Made> {
    /// Its name.
    pub name: String,
    /// Report and times, or the error.
    pub result: Result<T, JobError>,
}

/// A material whose files are in the store.
#[derive(Debug, Clone)]
pub struct Made {
    /// Measurements of the pack.
    pub report: MaterialReport,
    /// Contents of its lobes and maps, if the scene needs them.
    pub maps: Option<MapsReport>,
    /// Hash of its source.
    pub source: Digest,
    /// Results of its gates.
    pub gates: Vec<GateResult>,
    /// Files of the material, by part.
    pub files: Vec<(&'static str, Digest)>,
    /// Seconds per stage; `None` if all parts came from the store.
    pub times: Option<Vec<StageTime>>,
    /// Seconds per stage of the run that made the pack, which may be an earlier one.
    pub pack_times: Vec<StageTime>,
}

/// Record of a pack in the store: its report, and seconds per stage.
type PackNote = (MaterialReport, Vec<StageTime>);
/// Record of lobes in the store: their report, and repairs of the source's values.
type LobesNote = (LobesReport, Tally);

impl Made {
    /// Limits that the pack or the lobes miss.
    pub fn missed(&self) -> impl Iterator<Item = String> {
        let of_lobes = self.maps.as_ref().and_then(|maps| maps.lobes.as_ref()?.missed());
        self.report.missed.iter().cloned().chain(of_lobes)
    }

    /// Returns true if the pack and the lobes meet their limits, and the pack passes all gates.
    pub fn passed(&self) -> bool {
        self.missed().next().is_none() && self.gates.iter().all(|gate| gate.passed)
    }
}

/// The maps of the environment, whose files are in the store.
#[derive(Debug, Clone)]
pub struct MadeEnvironment {
    /// Contents of the maps.
    pub report: EnvironmentMaps,
    /// Hashes of the files, in the order of [`EnvironmentJob::files`].
    pub files: Vec<Digest>,
    /// Seconds per stage; `None` if the maps came from the store.
    pub times: Option<Vec<StageTime>>,
}

/// Name of the pack among the parts of a material.
pub const PACK: &str = "brdf";

/// State that all jobs of a build share.
pub struct BuildContext<'a> {
    /// Cache of results: jobs look them up and add their own.
    pub store: &'a Store,
    /// Hashes of the unchanged files of earlier builds in the output folder.
    pub placed: &'a BTreeSet<Digest>,
    /// Memory limit of all jobs together, bytes.
    pub memory: u64,
    /// True if the first failure stops the build.
    pub fail_fast: bool,
}

/// Result of one item of a build.
enum Finished {
    Environment(Result<MadeEnvironment, JobError>),
    /// `None` for a material that is made as another one.
    Material(Option<Box<Result<Made, JobError>>>),
    Asset(Result<MadeAsset, JobError>),
}

/// Runs a job, unless the build stops at the first failure and one has failed.
fn attempt<T>(
    name: &str,
    context: &BuildContext<'_>,
    stop: &AtomicBool,
    progress: &dyn Progress,
    passed: impl Fn(&T) -> bool,
    work: impl Fn(&dyn Progress) -> Result<T, JobError>,
) -> Result<T, JobError> {
    let part = progress.part(name);
    if stop.load(Ordering::Relaxed) {
        return Err(JobError::Cancelled(Cancelled));
    }
    let result = work(part.as_ref());
    part.finished(result.is_ok());
    if context.fail_fast && !result.as_ref().is_ok_and(passed) {
        stop.store(true, Ordering::Relaxed);
    }
    result
}

/// Runs all jobs. A job that fails does not stop the others, unless `fail_fast` is set.
pub fn run(plan: &Plan, context: &BuildContext<'_>, progress: &dyn Progress) -> Outcomes {
    let shared = Shared::new(context.memory);
    let stop = AtomicBool::new(false);
    // The environment runs first: it does not depend on the materials, and they do not depend on it.
    let first = usize::from(plan.environment.is_some());
    // Materials with the same source and recipe are made once.
    let same = |k: usize| plan.jobs[..k].iter().position(|job| job.is_same_work(&plan.jobs[k]));
    let twins: Vec<Option<usize>> = (0..plan.jobs.len()).map(same).collect();
    let last = first + plan.jobs.len();
    let finished = in_turn(last + plan.assets.len(), |number| {
        if number >= last {
            let job = &plan.assets[number - last];
            let work = |part: &dyn Progress| context.asset(job, &shared, part);
            return Finished::Asset(attempt(&job.name, context, &stop, progress, MadeAsset::passed, work));
        }
        let Some(number) = number.checked_sub(first) else {
            let job = plan.environment.as_ref().expect("the first item is the environment");
            let part = progress.part(ENVIRONMENT);
            let result = context.environment(job, &shared, part.as_ref());
            part.finished(result.is_ok());
            return Finished::Environment(result);
        };
        if twins[number].is_some() {
            return Finished::Material(None);
        }
        let job = &plan.jobs[number];
        let work = |part: &dyn Progress| context.material(job, &shared, part);
        Finished::Material(Some(Box::new(attempt(&job.name, context, &stop, progress, Made::passed, work))))
    });
    let (mut made, mut assets, mut environment) = (Vec::new(), Vec::new(), None);
    for one in finished {
        match one {
            Finished::Material(result) => made.push(result.map(|result| *result)),
            Finished::Asset(result) => assets.push(result),
            Finished::Environment(result) => environment = Some(result),
        }
    }
    let mut materials: Vec<Outcome> = Vec::new();
    for ((job, twin), result) in plan.jobs.iter().zip(twins).zip(made) {
        let of_twin = || {
            let part = progress.part(&job.name);
            let result = match twin.and_then(|twin| materials[twin].result.as_ref().ok()) {
                Some(made) => {
                    let lobes = made.maps.as_ref().and_then(|maps| maps.lobes.as_ref());
                    Ok(Made { gates: gates::check(&job.gates, &made.report, lobes), times: None, ..made.clone() })
                }
                // Run it again: the error names the source as this material declares it.
                None => context.material(job, &shared, part.as_ref()),
            };
            part.finished(result.is_ok());
            result
        };
        let result = result.unwrap_or_else(of_twin);
        materials.push(Outcome { name: job.name.clone(), result });
    }
    let asset = |(job, result): (&AssetJob, _)| Outcome { name: job.name.clone(), result };
    let assets = plan.assets.iter().zip(assets).map(asset).collect();
    Outcomes { materials, assets, environment }
}

/// Runs `work` for 0 to `count`, one item per thread at a time, and returns the results in that order.
///
/// The items run on a separate thread pool: each of its threads runs whole items one after the other, and a thread
/// that waits runs iterations of the other items' loops. As tasks of the global pool, items could be stolen by a
/// thread that waits for part of a loop. More items would then hold memory, and the item below on that thread's stack
/// would be blocked until the stolen item ends, or would deadlock if the stolen item waits for memory.
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
            results.lock().expect("no thread panics while it holds the lock")[number] = Some(result);
        }
    };
    match rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads()).build() {
        Ok(pool) => {
            pool.broadcast(|_| one_by_one());
        }
        Err(_) => one_by_one(),
    }
    let results = results.into_inner().expect("no thread panics while it holds the lock");
    results.into_iter().map(|result| result.expect("each item has run")).collect()
}

/// Entries of one material in the store.
struct CachedMaterial {
    source: Digest,
    pack: Option<Cached<PackNote>>,
    lobes: Option<Cached<LobesNote>>,
    maps: Option<Cached<MapsReport>>,
    texture: Option<Cached<Packed<BandwidthFacts>>>,
}

/// The requested parts of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RequestedParts {
    pack: bool,
    lobes: bool,
    maps: bool,
}

impl RequestedParts {
    const NONE: Self = Self { pack: false, lobes: false, maps: false };
    pub(super) const PACK: Self = Self { pack: true, ..Self::NONE };
    pub(super) const LOBES: Self = Self { lobes: true, ..Self::NONE };
    pub(super) const MAPS: Self = Self { maps: true, ..Self::NONE };
    const ALL: Self = Self { pack: true, lobes: true, maps: true };
}

impl CachedMaterial {
    fn has(&self, job: &Job, requested: RequestedParts) -> bool {
        let lobes = self.lobes.is_some() || job.lobes.is_none();
        let maps = self.maps.is_some() || job.maps == [false; 2];
        let maps = maps && (self.texture.is_some() || job.texture.is_none());
        (self.pack.is_some() || !requested.pack) && (lobes || !requested.lobes) && (maps || !requested.maps)
    }
}

impl BuildContext<'_> {
    /// Returns a material from the store, or makes it.
    ///
    /// # Errors
    /// Returns an error if the source cannot be read, the encoder fails, a file cannot be written, or the caller
    /// cancels.
    pub fn material(&self, job: &Job, shared: &Shared, progress: &dyn Progress) -> Result<Made, JobError> {
        let (cached, times) = self.cached_or_made(job, RequestedParts::ALL, shared, progress)?;
        Ok(made_from_cache(job, cached, times))
    }

    /// Returns a material from the store if it was made from the current contents of its source.
    pub fn known(&self, job: &Job) -> Option<Made> {
        let known = job.input.path().and_then(|path| self.store.known(path));
        let read = || Some(opened_with_digest(&job.input, Reading::default(), &kind_of(&job.input), u64::MAX).ok()?.1);
        self.known_of(job, known.or_else(read)?)
    }

    /// Returns a material from the store if it was made from the source with this hash.
    pub fn known_of(&self, job: &Job, source: Digest) -> Option<Made> {
        let cached = self.look_up(job, source);
        cached.has(job, RequestedParts::ALL).then(|| made_from_cache(job, cached, None))
    }

    /// Makes the requested parts of a material. Returns true if any of them was not in the store.
    pub(super) fn made_part(
        &self,
        job: &Job,
        requested: RequestedParts,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<bool, JobError> {
        Ok(self.cached_or_made(job, requested, shared, progress)?.1.is_some())
    }

    /// Returns the requested parts of a material, and the seconds per stage if any of them had to be made.
    fn cached_or_made(
        &self,
        job: &Job,
        requested: RequestedParts,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<(CachedMaterial, Option<Vec<StageTime>>), JobError> {
        progress.check()?;
        let known = job.input.path().and_then(|path| self.store.known(path));
        if let Some(source) = known {
            let cached = self.look_up(job, source);
            if cached.has(job, requested) {
                return Ok((cached, None));
            }
        }
        let clock = StageClock::new(progress);
        clock.stage(Stage::Read, 1)?;
        let length = job.input.path().and_then(|path| path.metadata().ok()).map_or(0, |metadata| metadata.len());
        let extension = kind_of(&job.input);
        let of_lobes = job.lobes.map_or(0, |_| memory::LOBES);
        let bytes = memory::of_source(&extension, length, job.reading.smooth.and_then(Smooth::strength).is_some())
            .saturating_add(job.recipe.memory().max(of_lobes));
        let _share = shared.take(bytes);
        progress.check()?;
        // On the pool's threads, so that the number of busy threads does not change.
        let (cached, all_cached) = rayon::scope(|_| self.fill(job, requested, &extension, &clock))?;
        Ok((cached, if all_cached { None } else { Some(clock.finish()) }))
    }

    /// Reads the source and makes the parts that are not in the store. Also returns true if all parts were in the
    /// store.
    fn fill(
        &self,
        job: &Job,
        requested: RequestedParts,
        extension: &str,
        clock: &StageClock<'_>,
    ) -> Result<(CachedMaterial, bool), JobError> {
        let longest = memory::longest_source(extension, self.memory);
        let (opened, source, stamp) = opened_with_digest(&job.input, job.reading, extension, longest)?;
        if let Some(path) = job.input.path() {
            self.remember(path, source, stamp);
        }
        let mut cached = self.look_up(job, source);
        if cached.has(job, requested) {
            return Ok((cached, true));
        }
        let mut all_cached = true;
        let source = values_of(source, job.reading);
        if requested.pack && cached.pack.is_none() {
            cached.pack = Some(self.make_pack(&opened, source, &job.recipe, clock)?);
            all_cached = false;
        }
        if let Some(recipe) = job.lobes.filter(|_| requested.lobes && cached.lobes.is_none()) {
            cached.lobes = Some(self.make_lobes(&opened, source, &recipe, clock)?);
            all_cached = false;
        }
        if requested.maps && job.maps != [false; 2] && cached.maps.is_none() {
            cached.maps = Some(self.make_maps(&opened, source, job.maps, clock)?);
            all_cached = false;
        }
        if let Some(texture) = job.texture.as_ref().filter(|_| requested.maps && cached.texture.is_none()) {
            let (map, is_cached) = self.texture(texture, clock)?;
            cached.texture = Some(map);
            all_cached &= is_cached;
        }
        Ok((cached, all_cached))
    }

    fn look_up(&self, job: &Job, source: Digest) -> CachedMaterial {
        let (store, placed) = (self.store, self.placed);
        let values = values_of(source, job.reading);
        CachedMaterial {
            source,
            pack: store.look_up(&pack_key(values, &job.recipe), placed),
            lobes: job.lobes.and_then(|recipe| store.look_up(&lobes_key(values, &recipe), placed)),
            maps: if job.has_maps() { store.look_up(&maps_key(values, job.maps), placed) } else { None },
            texture: job.texture.as_ref().and_then(|texture| {
                store.look_up(&Key::new(TEXTURE, store.known(&texture.path)?, &texture.recipe()), placed)
            }),
        }
    }

    /// Records the stamp of a source that was read, so that the next build need not read it.
    pub(super) fn remember(&self, path: &Path, digest: Digest, stamp: Option<Stamp>) {
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
    ) -> Result<Cached<PackNote>, JobError> {
        let cache = StoreGridCache { store: self.store, source };
        let encoded = encode_cached(opened.source.as_ref(), recipe, &cache, clock)?;
        let report = MaterialReport::new(&encoded, opened, clock)?;
        // A finished pack is stored even if the build is cancelled.
        let _ = clock.stage(Stage::Write, 1);
        let note = (report, clock.so_far());
        let files = self.store.keep(pack_key(source, recipe), &[encoded.bytes], &note).map_err(JobError::Store)?;
        Ok(Cached { report: note, files })
    }

    fn make_lobes(
        &self,
        opened: &Opened,
        source: Digest,
        recipe: &LobesRecipe,
        clock: &StageClock<'_>,
    ) -> Result<Cached<LobesNote>, JobError> {
        let (bytes, report, repairs) = material_lobes(opened.source.as_ref(), recipe, clock)?;
        let _ = clock.stage(Stage::Write, 1);
        let note = (report, repairs);
        let files = self.store.keep(lobes_key(source, recipe), &[bytes], &note).map_err(JobError::Store)?;
        Ok(Cached { report: note, files })
    }

    fn make_maps(
        &self,
        opened: &Opened,
        source: Digest,
        requested: RequestedMaps,
        clock: &StageClock<'_>,
    ) -> Result<Cached<MapsReport>, JobError> {
        let (files, report) = material_maps(opened.source.as_ref(), requested, clock)?;
        let _ = clock.stage(Stage::Write, 1);
        let files = self.store.keep(maps_key(source, requested), &files, &report).map_err(JobError::Store)?;
        Ok(Cached { report, files })
    }

    /// Reads a texture, and returns its map from the store or makes it. Also returns true if it was in the store.
    fn texture(
        &self,
        job: &TextureJob,
        clock: &StageClock<'_>,
    ) -> Result<(Cached<Packed<BandwidthFacts>>, bool), JobError> {
        let path = job.path.as_path();
        let extension = extension_of(path);
        let mut observer = HashingObserver::new(&extension, memory::longest_source(&extension, self.memory));
        let image = open_colours_observed(path, &mut observer)?;
        let (digest, stamp) = observer.finish().map_err(|error| InputError::io(path, error))?;
        self.remember(path, digest, stamp);
        let key = || Key::new(TEXTURE, digest, &job.recipe());
        if let Some(cached) = self.store.look_up(&key(), self.placed) {
            return Ok((cached, true));
        }
        clock.stage(Stage::BandwidthMap, 1)?;
        let (bytes, report) = job.map(&image).map_err(JobError::Map)?;
        let _ = clock.stage(Stage::Write, 1);
        let files = self.store.keep(key(), &[bytes], &report).map_err(JobError::Store)?;
        Ok((Cached { report, files }, false))
    }

    /// Returns the maps of the environment from the store, or makes them.
    ///
    /// # Errors
    /// Returns an error if the image cannot be read, a file cannot be written, or the caller cancels.
    pub fn environment(
        &self,
        job: &EnvironmentJob,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<MadeEnvironment, JobError> {
        progress.check()?;
        let path = job.path.as_path();
        let parts = || requested_parts(ENVIRONMENT_PARTS, job.maps);
        let key = |part, source| Key::new(ENVIRONMENT, source, &(part, DEFAULT_EPSILON));
        let look_up = |source| {
            let mut found = MadeEnvironment { report: EnvironmentMaps::default(), files: Vec::new(), times: None };
            for part in parts() {
                let Cached { report, files } = self.store.look_up(&key(part, source), self.placed)?;
                found.report = found.report.with(report);
                found.files.extend(files);
            }
            Some(found)
        };
        if let Some(cached) = self.store.known(path).and_then(look_up) {
            return Ok(cached);
        }
        let clock = StageClock::new(progress);
        let _share = shared.take(self.memory / 2);
        let extension = extension_of(path);
        let mut observer = HashingObserver::new(&extension, memory::longest_source(&extension, self.memory));
        let (files, report) = rayon::scope(|_| environment_maps(path, job.maps, &mut observer, &clock))?;
        let (source, stamp) = observer.finish().map_err(|error| InputError::io(path, error))?;
        self.remember(path, source, stamp);
        if let Some(cached) = look_up(source) {
            return Ok(cached);
        }
        let _ = clock.stage(Stage::Write, 1);
        let mut kept = Vec::new();
        for (part, bytes) in parts().zip(files) {
            kept.extend(self.store.keep(key(part, source), &[bytes], &report.only(part)).map_err(JobError::Store)?);
        }
        Ok(MadeEnvironment { report, files: kept, times: Some(clock.finish()) })
    }
}

/// Opens a source of at most `longest` bytes. Also returns the hash of its contents, and the stamp by which a later
/// build recognises it.
///
/// # Errors
/// Returns an error if the source cannot be read, or changes while it is read.
pub(crate) fn opened_with_digest(
    source: &Input,
    reading: Reading,
    extension: &str,
    longest: u64,
) -> Result<(Opened, Digest, Option<Stamp>), InputError> {
    let Some(path) = source.path() else {
        let opened = open(source, reading)?;
        let digest = match &opened.facts {
            Facts::Synth(model) => Digest::of(model.address.as_bytes()),
            _ => Digest::of(source.to_string().as_bytes()),
        };
        return Ok((opened, digest, None));
    };
    let mut observer = HashingObserver::new(extension, longest);
    let opened = open_file_observed(path, reading, &mut observer)?;
    let (digest, stamp) = observer.finish().map_err(|error| InputError::io(path, error))?;
    Ok((opened, digest, stamp))
}

/// Returns the extension of a file, in lower case, which determines its kind; empty for addresses.
pub(crate) fn kind_of(source: &Input) -> String {
    source.path().map_or(String::new(), extension_of)
}

fn made_from_cache(job: &Job, cached: CachedMaterial, times: Option<Vec<StageTime>>) -> Made {
    let pack = cached.pack.expect("all parts are in the store");
    let mut files = vec![(PACK, pack.files[0])];
    let lobes = cached.lobes.map_or((None, Vec::new()), |lobes| (Some(lobes.report), lobes.files));
    let maps = cached.maps.map_or((None, Vec::new()), |maps| (Some(maps.report), maps.files));
    let texture = cached.texture.map_or((None, Vec::new()), |texture| (Some(texture.report), texture.files));
    files.extend(job.lighting_parts().zip(lobes.1.into_iter().chain(maps.1).chain(texture.1)));
    let maps = MapsReport::of(lobes.0, maps.0, texture.0);
    let (report, pack_times) = pack.report;
    let gates = gates::check(&job.gates, &report, maps.as_ref().and_then(|maps| maps.lobes.as_ref()));
    Made { report, maps, source: cached.source, gates, files, times, pack_times }
}

/// Hash of the values of a source: its own without settings of reading.
fn values_of(source: Digest, reading: Reading) -> Digest {
    if reading == Reading::default() {
        return source;
    }
    Digest::of(&serde_json::to_vec(&(source, reading)).expect("hashes and settings are JSON"))
}

fn pack_key(source: Digest, recipe: &PackRecipe) -> Key {
    Key::new(PACK, source, recipe)
}

fn lobes_key(source: Digest, recipe: &LobesRecipe) -> Key {
    Key::new(LOBES, source, recipe)
}

fn maps_key(source: Digest, requested: RequestedMaps) -> Key {
    Key::new("maps", source, &(map_recipe(), requested))
}

fn extension_of(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_lowercase())
}
