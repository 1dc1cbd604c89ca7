//! Packs of assets in the store. A source may be a folder of many files: its hash is the hash of all their names and hashes.

use super::job::{AssetJob, MadeAsset, files_of};
use super::make::make;
use super::report::AssetReport;
use crate::scene::error::JobError;
use crate::scene::memory::Shared;
use crate::scene::run::BuildContext;
use crate::stage_clock::StageClock;
use crate::store::{Cached, Digest, HashingObserver, Key, Stamp};
use brdfc_core::progress::{Progress, Stage};
use brdfc_source::InputError;
use brdfc_source::read::read_file_observed;
use brdfc_source::ubo_btf;
use std::path::PathBuf;

/// Stamps of files; `None` for a file that is missing.
fn stamps(files: &[PathBuf]) -> Vec<Option<Stamp>> {
    files.iter().map(|file| Stamp::of(&file.metadata().ok()?)).collect()
}

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
        // Photographs take a multiple of their files, and all threads work on them: it runs alone.
        let _share = shared.take(self.memory);
        progress.check()?;
        let files = files_of(&job.path);
        let before = stamps(&files);
        let source = self.source_of(job, &files)?;
        if let Some(cached) = self.look_up_asset(job, source) {
            return Ok(of_cached(job, cached, None));
        }
        let (bytes, report) = rayon::scope(|_| make(job, &clock)).map_err(JobError::Asset)?;
        if files_of(&job.path) != files || stamps(&files) != before {
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
            let source = self.source_of(job, &files_of(&job.path)).ok()?;
            Some(of_cached(job, self.look_up_asset(job, source)?, None))
        };
        self.unchanged_asset(job).or_else(read)
    }

    /// Returns an asset from the store if the stamp of none of its files has changed.
    fn unchanged_asset(&self, job: &AssetJob) -> Option<MadeAsset> {
        let files = files_of(&job.path);
        let known = |file: &PathBuf| Some((file.clone(), self.store.known(file)?));
        let known: Vec<_> = files.iter().map(known).collect::<Option<_>>()?;
        let cached = self.look_up_asset(job, digest_of(job, &known))?;
        Some(of_cached(job, cached, None))
    }

    fn look_up_asset(&self, job: &AssetJob, source: Digest) -> Option<Cached<AssetReport>> {
        self.store.look_up(&asset_key(job, source), self.placed)
    }

    /// Hash of all files of a source. Files whose stamps are known are not read.
    fn source_of(&self, job: &AssetJob, files: &[PathBuf]) -> Result<Digest, JobError> {
        let hashed = |file: &PathBuf| {
            if let Some(known) = self.store.known(file) {
                return Ok((file.clone(), known));
            }
            let mut observer = HashingObserver::new("", u64::MAX);
            read_file_observed(file, ubo_btf::MAX_BYTES, &mut observer)?;
            let (digest, stamp) = observer.finish().map_err(|error| InputError::io(file, error))?;
            if let Some(stamp) = stamp {
                self.store.remember(file, stamp, digest);
            }
            Ok((file.clone(), digest))
        };
        let hashed = files.iter().map(hashed).collect::<Result<Vec<_>, InputError>>()?;
        Ok(digest_of(job, &hashed))
    }
}

/// Hash of the names of files, relative to the source, and of their hashes.
fn digest_of(job: &AssetJob, files: &[(PathBuf, Digest)]) -> Digest {
    let name = |file: &PathBuf| file.strip_prefix(&job.path).unwrap_or(file).to_string_lossy().into_owned();
    let named: Vec<(String, Digest)> = files
        .iter()
        .map(|(file, digest)| if *file == job.path { (String::new(), *digest) } else { (name(file), *digest) })
        .collect();
    Digest::of(&serde_json::to_vec(&named).expect("names and hashes are JSON"))
}

fn asset_key(job: &AssetJob, source: Digest) -> Key {
    Key::new(job.kind.pack().name(), source, &(job.kind, &job.recipe))
}

fn of_cached(job: &AssetJob, cached: Cached<AssetReport>, clock: Option<StageClock<'_>>) -> MadeAsset {
    let Cached { report, files } = cached;
    MadeAsset { gates: report.check(&job.required), report, file: files[0], times: clock.map(StageClock::finish) }
}
