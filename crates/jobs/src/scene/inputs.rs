//! What a scene is made of: a manifest, or a list of materials.

use super::batch::{address_of, find, given, is_material, manifest_of};
use super::manifest::Manifest;
use super::patterns::Named;
use super::plan::{Plan, plan};
use super::watch::named_in;
use crate::encode::options::EncodeOptions;
use crate::error::Error;
use brdfc_core::words::counted;
use brdfc_source::read::{MAX_TEXT_BYTES, read_file};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A scene as it was read, before options decide how its materials are made.
#[derive(Debug, Clone)]
pub struct Scene {
    manifest: Manifest,
    /// The manifest's file, if there is one.
    file: Option<PathBuf>,
    /// What it was read from, for messages.
    inputs: String,
    /// Files of folders that are no kind of material.
    left_out: Vec<PathBuf>,
    /// Where a new file would be a material.
    folders: Vec<PathBuf>,
}

impl Scene {
    /// The scene of a manifest. Patterns in it become the files that match.
    ///
    /// # Errors
    /// A file that cannot be read, or breaks the rules of `docs/scene.md`; patterns that nothing matches.
    pub fn of_manifest(path: &Path) -> Result<Self, Error> {
        let (_, manifest) = read_manifest(path)?;
        let inputs = path.display().to_string();
        let folders = folders(&named_in(path).unwrap_or_default());
        Ok(Self { manifest, file: Some(path.to_owned()), inputs, left_out: Vec::new(), folders })
    }

    /// The materials of files, folders, patterns and `synth:` addresses, each of which is used.
    ///
    /// # Errors
    /// Inputs without any material; two materials of one name.
    pub fn of_materials(inputs: &[OsString]) -> Result<Self, Error> {
        let named = given(inputs);
        let found = find(&named)?;
        let manifest = manifest_of(&found.sources)?;
        Ok(Self { manifest, file: None, inputs: listed(inputs), left_out: found.others, folders: folders(&named) })
    }

    /// Of a manifest if that is what is given, and otherwise of materials.
    ///
    /// # Errors
    /// As [`Self::of_manifest`] and [`Self::of_materials`]; a manifest among other inputs.
    pub fn of_inputs(inputs: &[OsString]) -> Result<Self, Error> {
        match manifest_among(inputs)? {
            Some(path) => Self::of_manifest(&path),
            None => Self::of_materials(inputs),
        }
    }

    /// What a build of it will do. `options` win over the table `defaults` of the manifest, not over what a material says of
    /// itself.
    ///
    /// # Errors
    /// Options out of range or that do not go together; nothing to build.
    pub fn plan(&self, options: &EncodeOptions) -> Result<Plan, Error> {
        let mut manifest = self.manifest.clone();
        manifest.defaults.options = options.over(&manifest.defaults.options);
        let folder = self.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut plan = plan(&manifest, folder)?;
        if self.file.is_none() {
            "materials".clone_into(&mut plan.scene);
        }
        if plan.is_empty() {
            return Err(Error::check(format!(
                "nothing to build: found {}, and no use of any, in {}; allowed one or more ([[uses]], material = \"...\")",
                counted(plan.skipped.len(), "material"),
                self.inputs,
            )));
        }
        Ok(plan)
    }

    /// The manifest's file, if there is one.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The folders that were given, and those in which files match a pattern: a new file there may be a material.
    pub fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// Files of folders that are no kind of material.
    pub fn left_out(&self) -> &[PathBuf] {
        &self.left_out
    }
}

/// The manifest, if that is what is given: one file that is no kind of material is taken for one, whatever its name.
///
/// # Errors
/// Standard input; a manifest among other inputs.
pub fn manifest_among(inputs: &[OsString]) -> Result<Option<PathBuf>, Error> {
    let alone = inputs.len() == 1;
    if inputs.iter().any(|input| input == "-") {
        return Err(Error::usage(
            "inputs: found -; allowed a manifest, or files, folders, patterns and synth: addresses: standard input is for \
             commands of one file, such as 'brdfc encode -' (a file of this name is ./-)"
                .to_owned(),
        ));
    }
    let is_manifest = |input: &OsString| {
        let path = Path::new(input);
        let named = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let is_pattern = Named::new("", input).is_pattern();
        named || alone && address_of(input).is_none() && !path.is_dir() && !is_pattern && !is_material(path)
    };
    match inputs.iter().find(|input| is_manifest(input)) {
        Some(_) if !alone => {
            let found = listed(inputs);
            Err(Error::wrong_usage("inputs", found, "one manifest, or files and folders"))
        }
        manifest => Ok(manifest.map(PathBuf::from)),
    }
}

/// The folders in which a new file would be found.
fn folders(named: &[Named]) -> Vec<PathBuf> {
    let folder = |input: &Named| {
        let base = if input.is_pattern() { input.base().0 } else { input.path() };
        Some(if base.as_os_str().is_empty() { PathBuf::from(".") } else { base }).filter(|base| base.is_dir())
    };
    named.iter().filter_map(folder).collect()
}

/// Inputs in one line.
fn listed(inputs: &[OsString]) -> String {
    inputs.iter().map(|input| input.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// A manifest with its text. Patterns in it became the files that match.
///
/// # Errors
/// A file that cannot be read, or breaks the rules of `docs/scene.md`; patterns that nothing matches.
pub fn read_manifest(path: &Path) -> Result<(String, Manifest), Error> {
    let bytes = read_file(path, MAX_TEXT_BYTES)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let byte = bytes[error.valid_up_to()];
        Error::input(format!("{}: line {line}, text: found byte {byte:#04x}; allowed UTF-8", path.display()))
    })?;
    let in_file = |error: &dyn std::fmt::Display| Error::input(format!("{}: {error}", path.display()));
    let manifest = Manifest::parse(text).map_err(|error| in_file(&error))?;
    let manifest = manifest.expanded(path.parent().unwrap_or(Path::new(""))).map_err(|error| in_file(&error))?;
    Ok((text.to_owned(), manifest))
}
