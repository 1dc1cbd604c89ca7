//! Packs and maps of a scene from an output folder. Parts that are not current are made.

use super::assets::{AssetJob, MadeAsset};
use super::build::known_folder;
use super::error::JobError;
use super::maps::part_name;
use super::memory::{self, Shared};
use super::plan::{EnvironmentJob, Job};
use super::run::{BuildContext, Made};
use crate::error::Error;
use crate::output_folder::OutputFolder;
use crate::report::gate::GateResult;
use crate::store::{Digest, Store};
use brdfc_core::progress::Progress;
use brdfc_formats::Pack;
use std::collections::BTreeSet;
use std::path::Path;

/// An output folder with its store.
pub struct PackFolder {
    store: Store,
    folder: OutputFolder,
    placed: BTreeSet<Digest>,
}

/// A material made from its current recipe and source.
pub struct Current {
    /// The pack, then the lobes and maps of [`Job::lighting_parts`].
    pub parts: Vec<Pack>,
    /// The limits that no trial met.
    pub missed: Option<String>,
    /// Results of its gates.
    pub gates: Vec<GateResult>,
    /// Names of files in the folder that were made from another recipe or source.
    pub stale: Vec<String>,
    /// Files that are not in the folder.
    pub missing: Vec<String>,
}

impl PackFolder {
    /// Opens an existing folder.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written to.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let store = Store::open(path, true)?;
        let folder = known_folder(path, &store, &())?;
        let placed = folder.there().into_values().collect();
        Ok(Self { store, folder, placed })
    }

    /// Opens a folder that a build filled; `None` if there is none, or if an interrupted build has to be finished
    /// there first.
    pub fn looked_at(path: &Path) -> Option<Self> {
        let is_settled = Self::is_one(path) && !OutputFolder::is_unfinished(path);
        is_settled.then(|| Self::open(path).ok()).flatten()
    }

    /// Returns true if the folder has a store.
    pub fn is_one(path: &Path) -> bool {
        path.join(crate::store::FOLDER).is_dir()
    }

    fn context(&self) -> BuildContext<'_> {
        let memory = memory::PER_THREAD * rayon::current_num_threads() as u64;
        BuildContext { store: &self.store, placed: &self.placed, memory, fail_fast: false }
    }

    /// Returns a material if it is current.
    pub fn known(&self, job: &Job) -> Option<Made> {
        self.context().known(job)
    }

    /// Returns an asset that is no material if it is current.
    pub fn known_asset(&self, job: &AssetJob) -> Option<MadeAsset> {
        self.context().known_asset(job)
    }

    /// Returns a material if it was made from the source with this hash.
    pub fn known_of(&self, job: &Job, source: Digest) -> Option<Made> {
        self.context().known_of(job, source)
    }

    /// Returns a material, and makes the parts that are not current. New parts go to the store; the files in the
    /// folder stay unchanged.
    ///
    /// # Errors
    /// Returns an error if the source cannot be read, the encoder fails, the store cannot be written to, or the
    /// caller cancels.
    pub fn material(&self, job: &Job, progress: &dyn Progress) -> Result<Current, JobError> {
        let context = self.context();
        let made = context.material(job, &Shared::new(context.memory), progress)?;
        let mut current = Current {
            parts: Vec::new(),
            missed: made.report.missed,
            gates: made.gates,
            stale: Vec::new(),
            missing: Vec::new(),
        };
        for (part, digest) in &made.files {
            let name = part_name(&job.name, part);
            current.parts.push(self.pack(&name, digest)?);
            if self.folder.holds_other(&name, digest) {
                current.stale.push(name);
            } else if !self.folder.has(&name) {
                current.missing.push(name);
            }
        }
        Ok(current)
    }

    /// Returns the maps of the environment in the order of [`EnvironmentJob::files`], and makes them if they are not current.
    ///
    /// # Errors
    /// Returns an error if the image cannot be read, the store cannot be written to, or the caller cancels.
    pub fn environment(&self, job: &EnvironmentJob, progress: &dyn Progress) -> Result<Vec<Pack>, JobError> {
        let context = self.context();
        let made = context.environment(job, &Shared::new(context.memory), progress)?;
        job.files().zip(&made.files).map(|(name, digest)| self.pack(&name, digest)).collect()
    }

    fn pack(&self, name: &str, digest: &Digest) -> Result<Pack, JobError> {
        let gone = || Error::write(name, &std::io::Error::other("missing from the store"));
        let bytes = self
            .store
            .object(digest)
            .or_else(|| self.folder.bytes(digest))
            .ok_or_else(gone)
            .map_err(JobError::Store)?;
        Pack::from_bytes(&bytes).map_err(JobError::Map)
    }
}
