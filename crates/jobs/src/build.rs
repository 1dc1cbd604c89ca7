//! Builds: scenes become folders of packs.

use crate::encode::{EncodeOptions, options_over};
use crate::error::Error;
use crate::outputs::{make_folder, refuse_overwriting_any};
use crate::report::build::BuildReport;
use crate::scene::batch::{find, given, manifest_of};
use crate::scene::build::{BuildSettings, Built, build, build_works};
use crate::scene::current::PackFolder;
use crate::scene::explain::{Explained, explain};
use crate::scene::inputs::{folders, listed, manifest_among, read_manifest};
use crate::scene::manifest::Manifest;
use crate::scene::plan::{Job, Plan, plan};
use crate::scene::run::{Made, Outcomes};
use crate::scene::watch::named_in;
use crate::scene::works::Work;
use brdfc_core::progress::Progress;
use brdfc_core::words::counted;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A build that was set up: what `brdfc build` does.
///
/// What was made before of the same source by the same options is kept. The output folder changes at the end, all at once.
#[derive(Debug, Clone)]
pub struct Build {
    manifest: Manifest,
    /// The manifest's file, if there is one.
    file: Option<PathBuf>,
    /// What the scene was read from, for messages.
    inputs: String,
    /// Files of folders that are no kind of material.
    left_out: Vec<PathBuf>,
    /// The folders that were given, and those in which files match a pattern: a new file there may be a material.
    folders: Vec<PathBuf>,
    options: EncodeOptions,
    settings: BuildSettings,
}

impl Build {
    /// Where packs go by default.
    pub const DEFAULT_FOLDER: &str = "packs";

    /// The packs that a scene needs: `docs/scene.md` describes the manifest. Materials that it does not use are not opened.
    ///
    /// # Errors
    /// A manifest that cannot be read, or is none; patterns in it that nothing matches.
    pub fn from_manifest(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let (_, manifest) = read_manifest(path)?;
        Ok(Self {
            manifest,
            file: Some(path.to_owned()),
            inputs: path.display().to_string(),
            left_out: Vec::new(),
            folders: folders(&named_in(path).unwrap_or_default()),
            options: EncodeOptions::default(),
            settings: BuildSettings::new(Self::DEFAULT_FOLDER),
        })
    }

    /// The packs of files, folders, patterns and `synth:` addresses, each named after its file.
    ///
    /// # Errors
    /// Inputs without any material; two materials of one name.
    pub fn from_materials<I: Into<OsString>>(inputs: impl IntoIterator<Item = I>) -> Result<Self, Error> {
        let inputs: Vec<OsString> = inputs.into_iter().map(Into::into).collect();
        let named = given(&inputs);
        let found = find(&named)?;
        Ok(Self {
            manifest: manifest_of(&found.sources)?,
            file: None,
            inputs: listed(&inputs),
            left_out: found.others,
            folders: folders(&named),
            options: EncodeOptions::default(),
            settings: BuildSettings::new(Self::DEFAULT_FOLDER),
        })
    }

    /// Either: a manifest if that is what is given.
    ///
    /// # Errors
    /// As [`Self::from_manifest`] and [`Self::from_materials`]; a manifest among other inputs.
    pub fn from_inputs(inputs: &[OsString]) -> Result<Self, Error> {
        match manifest_among(inputs)? {
            Some(path) => Self::from_manifest(path),
            None => Self::from_materials(inputs),
        }
    }

    /// How materials are encoded that do not say so themselves.
    #[must_use]
    pub fn options(self, options: EncodeOptions) -> Self {
        Self { options, ..self }
    }

    /// Folder for packs and reports, by default `packs`. A build makes it if it is missing.
    #[must_use]
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Self {
        self.settings.out = folder.into();
        self
    }

    /// Other output folders, from which what they have is taken.
    #[must_use]
    pub fn reuse(mut self, folders: impl IntoIterator<Item = PathBuf>) -> Self {
        self.settings.from = folders.into_iter().collect();
        self
    }

    /// Whether what was made before is used; by default it is.
    #[must_use]
    pub fn cache(mut self, cache: bool) -> Self {
        self.settings.looks_up = cache;
        self
    }

    /// Whether materials of earlier builds stay that this one does not ask for.
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.settings.keep = keep;
        self
    }

    /// Whether files may be replaced that no build wrote.
    #[must_use]
    pub fn force(mut self, force: bool) -> Self {
        self.settings.force = force;
        self
    }

    /// Whether the first failure ends the build, and leaves the folder as it was.
    #[must_use]
    pub fn fail_fast(mut self, fail_fast: bool) -> Self {
        self.settings.fail_fast = fail_fast;
        self
    }

    /// Whether a failure leaves the folder as it was, after all others were made.
    #[must_use]
    pub fn whole(mut self, whole: bool) -> Self {
        self.settings.whole = whole;
        self
    }

    /// Bytes that the materials in work may take together, by default 300 MiB for each thread of the pool.
    #[must_use]
    pub fn memory(mut self, bytes: u64) -> Self {
        self.settings.memory = Some(bytes);
        self
    }

    /// The manifest's file, if there is one.
    pub fn manifest(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Files of folders that are no kind of material.
    pub fn left_out(&self) -> &[PathBuf] {
        &self.left_out
    }

    /// What the build will do. Options win over the table `defaults` of the manifest, not over what a material says of itself.
    ///
    /// # Errors
    /// Options out of range or that do not go together; nothing to build.
    pub fn plan(&self) -> Result<Plan, Error> {
        let mut manifest = self.manifest.clone();
        manifest.defaults.options = options_over(&self.options, &manifest.defaults.options);
        let folder = self.manifest().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut plan = plan(&manifest, folder)?;
        if self.file.is_none() {
            "materials".clone_into(&mut plan.scene);
        }
        if plan.is_empty() {
            return Err(Error::check(format!(
                "nothing to build: found {}, and no use of any, in {}, expected one or more ([[uses]], material = \"...\")",
                counted(plan.skipped.len(), "material"),
                self.inputs,
            )));
        }
        Ok(plan)
    }

    /// The files that are read, and the folders in which a new file would be one of them, for `cargo::rerun-if-changed` and the
    /// like.
    ///
    /// # Errors
    /// As [`Self::plan`].
    pub fn files(&self) -> Result<Vec<PathBuf>, Error> {
        let plan = self.plan()?;
        let files = self.files_of(&plan).into_iter().map(Path::to_owned);
        Ok(files.chain(self.folders.iter().cloned()).collect())
    }

    /// The files alone, of a plan that is there.
    pub fn files_of<'a>(&'a self, plan: &'a Plan) -> Vec<&'a Path> {
        plan.sources().chain(self.manifest()).collect()
    }

    /// Builds, and fails if a material fails, misses its budget or does not pass its gates.
    ///
    /// # Errors
    /// All of that, with the materials' names; a folder that cannot be written to, or holds files that no build wrote.
    pub fn run(&self) -> Result<BuildReport, Error> {
        let built = self.run_with(&self.plan()?, &())?;
        let problems = built.outcomes.problems();
        match built.outcomes.verdict() {
            Ok(()) => Ok(built.report),
            Err(error) => {
                let text = format!("{error}\n{}", problems.join("\n"));
                Err(error.with_message(text))
            }
        }
    }

    /// Builds a plan of this build and reports to `progress`. Materials that fail are in the result, not an error.
    ///
    /// # Errors
    /// A folder that cannot be written to, or holds files that no build wrote; cancellation.
    pub fn run_with(&self, plan: &Plan, progress: &dyn Progress) -> Result<Built, Error> {
        self.prepare(plan)?;
        build(plan, &self.settings, progress)
    }

    /// Says what the build would do and between which sizes packs would be, and makes nothing; with `explains`, also what is needed
    /// of each material, and why.
    pub fn predict(&self, plan: &Plan, explains: bool) -> BuildReport {
        let folder = PackFolder::looked_at(&self.settings.out).filter(|_| self.settings.looks_up);
        let known = |job: &Job| folder.as_ref()?.known(job);
        let jobs = plan.jobs.iter();
        let known: BTreeMap<&str, Made> = jobs.filter_map(|job| Some((job.name.as_str(), known(job)?))).collect();
        let mut report = BuildReport::planned(plan, &known);
        if explains {
            let made = known.iter().map(|(name, made)| (*name, made)).collect();
            report.needs = explain(plan, &made, &|job, source| folder.as_ref()?.known_of(job, source));
        }
        report
    }

    /// What is needed of each material of a finished build, and why.
    pub fn explain(&self, plan: &Plan, outcomes: &Outcomes) -> Vec<Explained> {
        let folder = PackFolder::looked_at(&self.settings.out);
        explain(plan, &outcomes.made().collect(), &|job, source| folder.as_ref()?.known_of(job, source))
    }

    /// Makes some parts of [`Plan::works`] and keeps them in the store of the output folder, from which a whole build takes them.
    /// Of each part: whether it was made now.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub fn run_works(&self, works: &[Work<'_>], progress: &dyn Progress) -> Result<Vec<Result<bool, Error>>, Error> {
        let made = build_works(works, &self.settings, progress)?;
        Ok(made.into_iter().map(|made| made.map_err(Error::from)).collect())
    }

    /// Makes the output folder, unless what goes there would be written over what is read.
    ///
    /// # Errors
    /// Either; a folder that cannot be made.
    pub fn prepare(&self, plan: &Plan) -> Result<(), Error> {
        let out = self.settings.out.as_path();
        refuse_overwriting_any("--out", plan.files().map(|file| out.join(file)), &self.files_of(plan))?;
        make_folder(out)
    }
}
