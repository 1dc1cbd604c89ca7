//! What a build is asked for: a manifest, or a list of materials.

use crate::output::remark;
use crate::{CliError, Common};
use brdfc_core::words::{counted, join_truncated};
use brdfc_jobs::encode::options::EncodeOptions;
use brdfc_jobs::scene::batch::{address_of, find, given, is_material, manifest_of};
use brdfc_jobs::scene::manifest::Manifest;
use brdfc_jobs::scene::patterns::Named;
use brdfc_jobs::scene::plan::{Plan, plan};
use brdfc_source::read::{MAX_TEXT_BYTES, read_file};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A plan, and where it comes from.
pub(crate) struct Asked {
    pub(crate) plan: Plan,
    /// The manifest, if there is one.
    pub(crate) manifest: Option<PathBuf>,
}

impl Asked {
    /// The files that are read, whether they are there or not.
    pub(crate) fn files(&self) -> Vec<&Path> {
        self.plan.sources().chain(self.manifest.as_deref()).collect()
    }
}

/// So many names of files are told.
const NAMED: usize = 5;

/// The manifest, if that is what is given: one file that is no kind of material is taken for one, whatever its name.
pub(crate) fn manifest_among(inputs: &[OsString]) -> Result<Option<PathBuf>, CliError> {
    let alone = inputs.len() == 1;
    if inputs.iter().any(|input| input == "-") {
        return Err(CliError::Usage(
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
            Err(CliError::Usage(format!("inputs: found {found}; allowed one manifest, or files and folders")))
        }
        manifest => Ok(manifest.map(PathBuf::from)),
    }
}

/// Inputs in one line.
pub(crate) fn listed(inputs: &[OsString]) -> String {
    inputs.iter().map(|input| input.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// The plan of what is given.
pub(crate) fn asked(inputs: &[OsString], options: &EncodeOptions, common: Common) -> Result<Asked, CliError> {
    if let Some(path) = manifest_among(inputs)? {
        let (_, mut manifest) = read_manifest(&path)?;
        manifest.defaults.options = options.over(&manifest.defaults.options);
        let plan = plan(&manifest, path.parent().unwrap_or(Path::new("")))?;
        return Ok(Asked { plan, manifest: Some(path) });
    }
    let found = find(&given(inputs))?;
    if !found.others.is_empty() {
        let names: Vec<String> = found.others.iter().map(|path| path.display().to_string()).collect();
        let (count, names) = (counted(names.len(), "file"), join_truncated(&names, NAMED));
        remark(common, &format!("left out, no measured materials: {count} ({names})"));
    }
    let mut manifest = manifest_of(&found.sources)?;
    manifest.defaults.options = options.clone();
    let mut plan = plan(&manifest, Path::new(""))?;
    plan.scene = "materials".to_owned();
    Ok(Asked { plan, manifest: None })
}

/// A manifest with its text. Patterns in it became the files that match.
pub(crate) fn read_manifest(path: &Path) -> Result<(String, Manifest), CliError> {
    let bytes = read_file(path, MAX_TEXT_BYTES)?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let byte = bytes[error.valid_up_to()];
        CliError::Input(format!("{}: line {line}, text: found byte {byte:#04x}; allowed UTF-8", path.display()))
    })?;
    let in_file = |error: &dyn std::fmt::Display| CliError::Input(format!("{}: {error}", path.display()));
    let manifest = Manifest::parse(text).map_err(|error| in_file(&error))?;
    let manifest = manifest.expanded(path.parent().unwrap_or(Path::new(""))).map_err(|error| in_file(&error))?;
    Ok((text.to_owned(), manifest))
}
