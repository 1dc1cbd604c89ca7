//! Packs of assets in the store. A source may be a folder of many files: its hash is the hash of all their names and hashes.

use super::job::{AssetJob, MadeAsset, files_of};
use super::make::{checked_input, make};
use super::report::AssetReport;
use crate::scene::error::JobError;
use crate::scene::memory::Shared;
use crate::scene::run::BuildContext;
use crate::stage_clock::StageClock;
use crate::store::{Cached, Digest, HashingObserver, Key, Stamp};
use brdfc_core::progress::{Progress, Stage};
use brdfc_source::InputError;
use brdfc_source::read::ReadListener as _;
use rayon::prelude::*;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Bytes of a file that are hashed at a time.
const PIECE: usize = 1 << 20;

/// Hash of a file; and its stamp if the file was read and any later change is certain to change the stamp.
type Hashed = (Digest, Option<Stamp>);

impl BuildContext<'_> {
    /// Returns an asset from the store, or makes it.
    ///
    /// # Errors
    /// Returns an error if the source cannot be read, changes while it is read or is of another kind, if a file cannot be written, or if
    /// cancelled.
    pub(in crate::scene) fn asset(
        &self,
        job: &AssetJob,
        shared: &Shared,
        progress: &dyn Progress,
    ) -> Result<MadeAsset, JobError> {
        progress.check()?;
        if let Some(made) = self.unchanged_asset(job) {
            return Ok(made);
        }
        let clock = StageClock::new(progress);
        clock.stage(Stage::Read, 1)?;
        let input = checked_input(job).map_err(JobError::Asset)?;
        let files = files_of(&job.path);
        if files.iter().any(|file| file.is_dir()) {
            // A folder whose files do not belong together: its reader states why.
            make(job, &input, &clock).map_err(JobError::Asset)?;
        }
        let hashes = self.hashes_of(&files, &clock)?;
        files.iter().zip(&hashes).for_each(|(file, (digest, stamp))| self.remember(file, *digest, *stamp));
        let source = digest_of(job, &files, &hashes);
        if let Some(cached) = self.look_up_asset(job, source) {
            return Ok(of_cached(job, cached, None));
        }
        // Photographs take a multiple of their files, and all threads work on them: it runs alone.
        let _share = shared.take(self.memory);
        progress.check()?;
        let (bytes, report) = rayon::scope(|_| make(job, &input, &clock)).map_err(JobError::Asset)?;
        // Files whose stamps are known are not read again: those written just now are, and all with `--no-cache`.
        let again = self.hashes_of(&files, &())?;
        if files_of(&job.path) != files || digest_of(job, &files, &again) != source {
            let error = std::io::Error::other("its files changed while they were read");
            return Err(InputError::io(&job.path, error).into());
        }
        // A finished pack is stored even if the build is cancelled.
        let _ = clock.stage(Stage::Write, 1);
        let files = self.store.keep(asset_key(job, source), &[bytes], &report).map_err(JobError::Store)?;
        Ok(of_cached(job, Cached { report, files }, Some(clock)))
    }

    /// Returns an asset from the store if it was made from the current contents of its files.
    pub(in crate::scene) fn known_asset(&self, job: &AssetJob) -> Option<MadeAsset> {
        let read = || {
            let files = files_of(&job.path);
            let source = digest_of(job, &files, &self.hashes_of(&files, &()).ok()?);
            Some(of_cached(job, self.look_up_asset(job, source)?, None))
        };
        self.unchanged_asset(job).or_else(read)
    }

    /// Returns an asset from the store if the stamp of none of its files has changed.
    fn unchanged_asset(&self, job: &AssetJob) -> Option<MadeAsset> {
        let files = files_of(&job.path);
        let known: Vec<Hashed> =
            files.iter().map(|file| Some((self.store.known(file)?, None))).collect::<Option<_>>()?;
        let cached = self.look_up_asset(job, digest_of(job, &files, &known))?;
        Some(of_cached(job, cached, None))
    }

    fn look_up_asset(&self, job: &AssetJob, source: Digest) -> Option<Cached<AssetReport>> {
        self.store.look_up(&asset_key(job, source), self.placed)
    }

    /// Hashes of the files of a source. Files whose stamps are known are not read.
    fn hashes_of(&self, files: &[PathBuf], progress: &dyn Progress) -> Result<Vec<Hashed>, JobError> {
        let hash = |file: &PathBuf| match self.store.known(file) {
            Some(known) => Ok((known, None)),
            None => hash_of(file, progress),
        };
        files.par_iter().map(hash).collect()
    }
}

/// Hashes a file piece by piece: a BTF may exceed the memory limit.
fn hash_of(path: &Path, progress: &dyn Progress) -> Result<Hashed, JobError> {
    let io = |error: std::io::Error| InputError::io(path, error);
    let metadata = path.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(io(std::io::Error::other("not a file")).into());
    }
    let mut file = File::open(path).map_err(io)?;
    let mut observer = HashingObserver::new("", u64::MAX);
    observer.opened(&file, metadata.len()).map_err(|error| InputError::format(path, error))?;
    let mut piece = vec![0; PIECE.min(metadata.len() as usize + 1)];
    loop {
        progress.check()?;
        let count = file.read(&mut piece).map_err(io)?;
        if count == 0 {
            return Ok(observer.finish().map_err(io)?);
        }
        observer.bytes(&piece[..count]);
    }
}

/// Hash of the names of files, relative to the folder of the source, and of their hashes.
fn digest_of(job: &AssetJob, files: &[PathBuf], hashes: &[Hashed]) -> Digest {
    let folder = if job.path.is_dir() { Some(job.path.as_path()) } else { job.path.parent() };
    let name = |file: &PathBuf| {
        if *file == job.path {
            return String::new();
        }
        let within = folder.and_then(|folder| file.strip_prefix(folder).ok());
        within.unwrap_or(file).to_string_lossy().into_owned()
    };
    let named: Vec<(String, Digest)> = files.iter().map(name).zip(hashes.iter().map(|hashed| hashed.0)).collect();
    Digest::of(&serde_json::to_vec(&named).expect("names and hashes are JSON"))
}

fn asset_key(job: &AssetJob, source: Digest) -> Key {
    Key::new(job.kind.pack().name(), source, &(job.kind, &job.recipe))
}

fn of_cached(job: &AssetJob, cached: Cached<AssetReport>, clock: Option<StageClock<'_>>) -> MadeAsset {
    let Cached { report, files } = cached;
    MadeAsset { gates: report.check(&job.required), report, file: files[0], times: clock.map(StageClock::finish) }
}
