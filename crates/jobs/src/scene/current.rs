//! What a scene needs of a folder of packs: taken from there where it is current, made where it is not.

use super::build::known_folder;
use super::error::JobError;
use super::maps::part_name;
use super::memory::{self, Shared};
use super::plan::{EnvironmentJob, Job};
use super::run::{Made, Workshop};
use crate::error::Error;
use crate::output_folder::OutputFolder;
use crate::report::build::environment_map;
use crate::report::gate::GateResult;
use crate::store::{Digest, Store};
use brdfc_core::progress::Progress;
use brdfc_formats::Pack;
use std::collections::BTreeSet;
use std::path::Path;

/// A folder that a build fills.
pub struct PackFolder {
    store: Store,
    folder: OutputFolder,
    placed: BTreeSet<Digest>,
}

/// A material of it, as its recipe and the bytes of its source now ask for.
pub struct Current {
    /// The pack, then the maps in the order of [`PARTS`](super::maps::PARTS) where the scene needs them.
    pub parts: Vec<Pack>,
    /// What nothing that was tried meets.
    pub missed: Option<String>,
    /// What its gates saw.
    pub gates: Vec<GateResult>,
    /// Files that stand in the folder but are others; they were made from something else.
    pub stale: Vec<String>,
    /// Files that are not in the folder.
    pub missing: Vec<String>,
}

impl PackFolder {
    /// A folder that is there.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let store = Store::open(path, true)?;
        let folder = known_folder(path, &store, &())?;
        let placed = folder.there().into_values().collect();
        Ok(Self { store, folder, placed })
    }

    /// A folder that a build filled, if there is one and nothing is to be finished there: nothing is written.
    pub fn looked_at(path: &Path) -> Option<Self> {
        let is_settled = Self::is_one(path) && !OutputFolder::is_unfinished(path);
        is_settled.then(|| Self::open(path).ok()).flatten()
    }

    /// Whether a build or an earlier call worked in this folder.
    pub fn is_one(path: &Path) -> bool {
        path.join(crate::store::FOLDER).is_dir()
    }

    fn workshop(&self) -> Workshop<'_> {
        let memory = memory::PER_THREAD * rayon::current_num_threads() as u64;
        Workshop { store: &self.store, placed: &self.placed, memory, fail_fast: false }
    }

    /// A material that needs not be made again.
    pub fn known(&self, job: &Job) -> Option<Made> {
        self.workshop().known(job)
    }

    /// A material, made before of the source with this hash.
    pub fn known_of(&self, job: &Job, source: Digest) -> Option<Made> {
        self.workshop().known_of(job, source)
    }

    /// A material. What had to be made is kept in the store; the files in the folder stay as they are.
    pub fn material(&self, job: &Job, progress: &dyn Progress) -> Result<Current, JobError> {
        let workshop = self.workshop();
        let made = workshop.material(job, &Shared::new(workshop.memory), progress)?;
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

    /// The map of the environment.
    pub fn environment(&self, job: &EnvironmentJob, progress: &dyn Progress) -> Result<Pack, JobError> {
        let workshop = self.workshop();
        let made = workshop.environment(job, &Shared::new(workshop.memory), progress)?;
        self.pack(&environment_map(), &made.file)
    }

    fn pack(&self, name: &str, digest: &Digest) -> Result<Pack, JobError> {
        let gone = || Error::write(name, &std::io::Error::other("it is gone from the store"));
        let bytes = self
            .store
            .object(digest)
            .or_else(|| self.folder.bytes(digest))
            .ok_or_else(gone)
            .map_err(JobError::Store)?;
        Pack::from_bytes(&bytes).map_err(JobError::Map)
    }
}
