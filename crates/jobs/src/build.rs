//! Builds folders of packs from scenes.

use crate::encode::{EncodeOptions, options_over};
use crate::error::Error;
use crate::outputs::{make_folder, refuse_overwriting_any};
use crate::report::build::BuildReport;
use crate::scene::assets::AssetJob;
use crate::scene::batch::{find, given, manifest_of};
use crate::scene::build::{BuildSettings, Built, build, build_works};
use crate::scene::current::PackFolder;
use crate::scene::explain::{Explained, explain};
use crate::scene::inputs::{folders, listed, manifest_among, read_manifest};
use crate::scene::manifest::Manifest;
use crate::scene::plan::{Job, Plan, plan};
use crate::scene::run::{Made, Outcomes};
use crate::scene::scene_section::{ENVIRONMENTS, is_environment};
use crate::scene::watch::named_in;
use crate::scene::works::Work;
use brdfc_core::progress::Progress;
use brdfc_core::words::counted;
use brdfc_source::Reading;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Settings of a build, as `brdfc build` runs it.
///
/// A build reuses packs that were made from the same sources with the same options. It replaces the files in the output folder at
/// the end, all at once.
#[derive(Debug, Clone)]
pub struct Build {
    manifest: Manifest,
    /// The manifest's file, if there is one.
    file: Option<PathBuf>,
    /// Names of the inputs, for messages.
    inputs: String,
    /// Files in input folders that are not materials.
    left_out: Vec<PathBuf>,
    /// Input folders, and folders of patterns, where a new file may be a material.
    folders: Vec<PathBuf>,
    options: EncodeOptions,
    reading: Reading,
    settings: BuildSettings,
}

impl Build {
    /// Output folder of builds that set none, relative to the working directory.
    pub const DEFAULT_FOLDER: &str = "packs";

    /// Builds the packs that a scene needs. `docs/manifest.md` describes the manifest. Unused materials are not opened.
    ///
    /// # Errors
    /// Returns an error if the manifest cannot be read or is invalid, or if a pattern in it matches no file.
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
            reading: Reading::default(),
            settings: BuildSettings::new(Self::DEFAULT_FOLDER),
        })
    }

    /// Builds packs of files, folders, patterns and `synth:` addresses. Packs are named after their files.
    ///
    /// # Errors
    /// Returns an error if the inputs have no material, or if two materials have one name.
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
            reading: Reading::default(),
            settings: BuildSettings::new(Self::DEFAULT_FOLDER),
        })
    }

    /// Builds a manifest if the input is one, otherwise materials.
    ///
    /// # Errors
    /// Returns the errors of [`Self::from_manifest`] and [`Self::from_materials`], and an error for a manifest among other inputs.
    pub fn from_inputs(inputs: &[OsString]) -> Result<Self, Error> {
        match manifest_among(inputs)? {
            Some(path) => Self::from_manifest(path),
            None => Self::from_materials(inputs),
        }
    }

    /// Sets the options of materials that have none of their own.
    #[must_use]
    pub fn options(self, options: EncodeOptions) -> Self {
        Self { options, ..self }
    }

    /// Sets the settings of reading materials that have none of their own.
    #[must_use]
    pub fn reading(self, reading: Reading) -> Self {
        Self { reading, ..self }
    }

    /// Lights materials without a manifest by an environment: a latitude-longitude image, a cube map or a prefiltered
    /// environment. The build also makes their lobes and the prefiltered environment.
    ///
    /// # Errors
    /// Returns an error for a manifest, which names its own environment, and for files that are not .exr, .hdr or .ktx2.
    pub fn environment(mut self, image: impl Into<String>) -> Result<Self, Error> {
        const FLAG: &str = "--environment";
        let image = image.into();
        if self.file.is_some() {
            return Err(Error::usage(format!("{FLAG} does not apply to manifests; set environment in [scene]")));
        }
        if !is_environment(&image) {
            return Err(Error::wrong_usage(FLAG, image, ENVIRONMENTS));
        }
        self.manifest.scene.environment = Some(image);
        Ok(self)
    }

    /// Sets the folder for packs and reports, by default `packs`. A build creates it if missing.
    #[must_use]
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Self {
        self.settings.out = folder.into();
        self
    }

    /// Sets other output folders from which packs are reused.
    #[must_use]
    pub fn reuse(mut self, folders: impl IntoIterator<Item = PathBuf>) -> Self {
        self.settings.from = folders.into_iter().collect();
        self
    }

    /// Sets whether earlier packs are reused. Default: true.
    #[must_use]
    pub fn cache(mut self, cache: bool) -> Self {
        self.settings.looks_up = cache;
        self
    }

    /// Sets whether to retain materials of earlier builds that this one does not request.
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.settings.keep = keep;
        self
    }

    /// Sets whether to replace files that no build wrote.
    #[must_use]
    pub fn force(mut self, force: bool) -> Self {
        self.settings.force = force;
        self
    }

    /// Sets whether the first failure ends the build and leaves the folder unchanged.
    #[must_use]
    pub fn fail_fast(mut self, fail_fast: bool) -> Self {
        self.settings.fail_fast = fail_fast;
        self
    }

    /// Sets whether a failure leaves the folder unchanged, after all other materials were made.
    #[must_use]
    pub fn whole(mut self, whole: bool) -> Self {
        self.settings.whole = whole;
        self
    }

    /// Sets the memory limit for concurrent materials, in bytes. Default: 300 MiB for each thread of the pool.
    #[must_use]
    pub fn memory(mut self, bytes: u64) -> Self {
        self.settings.memory = Some(bytes);
        self
    }

    /// The manifest's file, if there is one.
    pub fn manifest(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Files in input folders that are not materials.
    pub fn left_out(&self) -> &[PathBuf] {
        &self.left_out
    }

    /// Plans the build. Options override the table `defaults` of the manifest, but not options of materials.
    ///
    /// # Errors
    /// Returns an error if options are out of range or incompatible, or if there is nothing to build.
    pub fn plan(&self) -> Result<Plan, Error> {
        let mut manifest = self.manifest.clone();
        self.reading.check().map_err(|error| Error::wrong_usage(error.field, error.found, error.allowed))?;
        manifest.defaults.reading = self.reading.over(manifest.defaults.reading);
        manifest.defaults.options = options_over(&self.options, &manifest.defaults.options);
        let folder = self.manifest().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut plan = plan(&manifest, folder)?;
        if self.file.is_none() {
            "materials".clone_into(&mut plan.scene);
        }
        if plan.is_empty() {
            return Err(Error::check(format!(
                "{}: nothing to build: {} and no uses; add [[uses]] with material = \"...\"",
                self.inputs,
                counted(plan.skipped.len(), "material"),
            )));
        }
        Ok(plan)
    }

    /// The files that the build reads, and the folders where a new file may become an input, for `cargo::rerun-if-changed` and
    /// similar uses.
    ///
    /// # Errors
    /// Returns the errors of [`Self::plan`].
    pub fn files(&self) -> Result<Vec<PathBuf>, Error> {
        let plan = self.plan()?;
        let files = self.files_of(&plan).into_iter().map(Path::to_owned);
        Ok(files.chain(self.folders.iter().cloned()).collect())
    }

    /// Returns true if options of materials were set, or their environment, and the plan has no material.
    pub fn ignores_options(&self, plan: &Plan) -> bool {
        let lit = self.file.is_none() && plan.has_environment;
        let is_set = lit || self.options != EncodeOptions::default() || self.reading != Reading::default();
        is_set && plan.jobs.is_empty()
    }

    /// The files that the build reads, for an existing plan.
    pub fn files_of<'a>(&'a self, plan: &'a Plan) -> Vec<&'a Path> {
        plan.sources().chain(self.manifest()).collect()
    }

    /// Runs the build.
    ///
    /// # Errors
    /// Returns an error if a material fails, misses its limits or fails its gates, with the materials' names, and if the folder
    /// cannot be written to or holds files that no build wrote.
    pub fn run(&self) -> Result<BuildReport, Error> {
        let built = self.run_with(&self.plan()?, &())?;
        let problems: Vec<String> = built.outcomes.problems().iter().map(ToString::to_string).collect();
        match built.outcomes.verdict() {
            Ok(()) => Ok(built.report),
            Err(error) => {
                let text = format!("{error}\n{}", problems.join("\n"));
                Err(error.with_message(text))
            }
        }
    }

    /// Runs a plan of this build and reports to `progress`. The result includes failed materials.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written to or holds files that no build wrote, or if cancelled.
    pub fn run_with(&self, plan: &Plan, progress: &dyn Progress) -> Result<Built, Error> {
        self.prepare(plan)?;
        build(plan, &self.settings, progress)
    }

    /// Reports a planned build with bounds of the sizes of packs, without building. With `explains`, also reports the requirements of
    /// each material and their reasons.
    pub fn predict(&self, plan: &Plan, explains: bool) -> BuildReport {
        let folder = PackFolder::looked_at(&self.settings.out).filter(|_| self.settings.looks_up);
        let known = |job: &Job| folder.as_ref()?.known(job);
        let jobs = plan.jobs.iter();
        let known: BTreeMap<&str, Made> = jobs.filter_map(|job| Some((job.name.as_str(), known(job)?))).collect();
        let known_asset = |job: &AssetJob| folder.as_ref()?.known_asset(job);
        let assets = plan.assets.iter();
        let known_assets = assets.filter_map(|job| Some((job.name.as_str(), known_asset(job)?))).collect();
        let mut report = BuildReport::planned(plan, &known, &known_assets);
        if explains {
            let made = known.iter().map(|(name, made)| (*name, made)).collect();
            report.needs = explain(plan, &made, &|job, source| folder.as_ref()?.known_of(job, source));
        }
        report
    }

    /// Requirements of each material of a finished build, and their reasons.
    pub fn explain(&self, plan: &Plan, outcomes: &Outcomes) -> Vec<Explained> {
        let folder = PackFolder::looked_at(&self.settings.out);
        explain(plan, &outcomes.made().collect(), &|job, source| folder.as_ref()?.known_of(job, source))
    }

    /// Makes some parts of [`Plan::works`] and stores them in the output folder's store, for reuse by a complete build. The result
    /// for each part is true if it was made now.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written to.
    pub fn run_works(&self, works: &[Work<'_>], progress: &dyn Progress) -> Result<Vec<Result<bool, Error>>, Error> {
        let made = build_works(works, &self.settings, progress)?;
        Ok(made.into_iter().map(|made| made.map_err(Error::from)).collect())
    }

    /// Creates the output folder.
    ///
    /// # Errors
    /// Returns an error if an output would overwrite an input, or if the folder cannot be created.
    pub fn prepare(&self, plan: &Plan) -> Result<(), Error> {
        let out = self.settings.out.as_path();
        refuse_overwriting_any("--out", plan.files().map(|file| out.join(file)), &self.files_of(plan))?;
        make_folder(out)
    }
}
