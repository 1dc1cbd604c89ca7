//! Verifies packs, folders of builds and reports by checksums, hashes and cross-references.

use crate::error::Error;
use crate::output_folder::OutputFolder;
use crate::pack_files::entries;
use crate::report::build::{BuildReport, FileEntry};
use crate::report::list::{MATERIAL_VERSION, MaterialFile};
use crate::scene::plan::REPORT;
use crate::scene::run::PACK;
use crate::store::Digest;
use crate::write::folder_of;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::Pack;
use brdfc_source::json::json_problem;
use brdfc_source::read::{MAX_FILE_BYTES, MAX_TEXT_BYTES, read_regular_file};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file that was checked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct CheckedFile {
    /// Path of the file, as given or in the given folder.
    pub file: String,
    /// Kind of the file: the name of a pack's decoder, 'report' or 'list'; absent if the file cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<&'static str>,
    /// Fault of the file; absent if the file is valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
}

/// Check of one file.
#[derive(Debug, Clone)]
enum Check {
    /// A pack: its checksum and layout, and its hash if a report lists it.
    Pack(Option<Digest>),
    /// A `MATERIAL.json` with this hash.
    List(Digest),
    /// A result that is already known.
    Known(CheckedFile),
}

/// Files to check, collected from paths and then read by [`Self::run`].
#[derive(Debug, Clone, Default)]
pub struct Checks {
    checks: Vec<(PathBuf, Check)>,
    /// Locks of the folders, which prevent builds from moving files during the checks.
    held: Vec<Arc<File>>,
}

impl Checks {
    /// Adds the checks of a path: a pack (`.ktx2`), the folder of a build with a `report.json`, a folder of packs, or a `report.json` or
    /// `MATERIAL.json` with the files that it lists. Packs that the report of the folder does not list are checked without a hash.
    ///
    /// Builds that put files into such a folder wait until the checks are done.
    ///
    /// # Errors
    /// Returns an error if the path does not exist or is of another kind, if a folder has no packs, or if a build keeps
    /// moving files in the folder.
    pub fn add(&mut self, path: &Path) -> Result<(), Error> {
        let metadata = path.metadata().map_err(|error| Error::read(path, &error))?;
        if metadata.is_dir() {
            return self.add_folder(path);
        }
        match path.extension().map(|extension| extension.to_ascii_lowercase()) {
            Some(extension) if extension == "ktx2" => self.checks.push((path.to_owned(), Check::Pack(None))),
            Some(extension) if extension == "json" => self.add_json(path)?,
            _ => {
                let allowed = "a pack (.ktx2), a folder of packs, a report.json or a MATERIAL.json";
                return Err(Error::usage(format!("{}: cannot be verified; expected {allowed}", path.display())));
            }
        }
        Ok(())
    }

    fn add_folder(&mut self, folder: &Path) -> Result<(), Error> {
        self.hold(folder)?;
        let report = folder.join(REPORT);
        let before = self.checks.len();
        let mut listed = BTreeSet::new();
        if report.exists() || OutputFolder::is_unfinished(folder) {
            listed = self.add_report(&report);
        } else if OutputFolder::is_placed(folder) || !MaterialFile::names_in(folder).is_empty() {
            self.known(&report, None, Some("missing".to_owned()));
        }
        let read = |error: std::io::Error| Error::read(folder, &error);
        let mut packs = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(read)? {
            let path = entry.map_err(read)?.path();
            let is_pack = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ktx2"));
            if is_pack && !listed.contains(&path) && path.is_file() {
                packs.push((path, Check::Pack(None)));
            }
        }
        packs.sort_by(|(a, _), (b, _)| a.cmp(b));
        self.checks.extend(packs);
        if self.checks.len() == before {
            return Err(Error::check(format!(
                "{}: nothing to verify; expected packs or a report.json",
                folder.display()
            )));
        }
        Ok(())
    }

    fn hold(&mut self, folder: &Path) -> Result<(), Error> {
        self.held.extend(OutputFolder::hold_still(folder)?.map(Arc::new));
        Ok(())
    }

    fn known(&mut self, path: &Path, kind: Option<&'static str>, fault: Option<String>) {
        let file = CheckedFile { file: path.display().to_string(), kind, fault };
        self.checks.push((path.to_owned(), Check::Known(file)));
    }

    /// Adds a `report.json` with its files, which are returned.
    fn add_report(&mut self, path: &Path) -> BTreeSet<PathBuf> {
        let folder = folder_of(path);
        if OutputFolder::is_unfinished(folder) {
            let fault = "a build was stopped while it replaced files; 'brdfc build' finishes it";
            self.known(folder, None, Some(fault.to_owned()));
        }
        let (report, fault) = match BuildReport::open_unchecked(path) {
            Ok((report, _, fault)) => (report, fault),
            Err(error) => {
                let text = error.message();
                let fault = text.strip_prefix(&format!("{}: ", path.display())).unwrap_or(text).to_owned();
                self.known(path, None, Some(fault));
                return BTreeSet::new();
            }
        };
        let faults: Vec<String> = fault.into_iter().chain(report_fault(&report)).collect();
        let fault = (!faults.is_empty()).then(|| faults.join("; "));
        self.known(path, Some("report"), fault);
        let lists: BTreeSet<&FileEntry> = report.materials.iter().filter_map(|entry| entry.list.as_ref()).collect();
        let checks = report.files().map(|entry| {
            let check = if lists.contains(entry) { Check::List(entry.blake3) } else { Check::Pack(Some(entry.blake3)) };
            (folder.join(&entry.file), check)
        });
        let checks: Vec<_> = checks.collect();
        let files = checks.iter().map(|(path, _)| path.clone()).collect();
        self.checks.extend(checks);
        files
    }

    /// Adds a `report.json` or a `MATERIAL.json`, distinguished by content, not by name.
    fn add_json(&mut self, path: &Path) -> Result<(), Error> {
        self.hold(folder_of(path))?;
        let is_list = read_regular_file(path, MAX_TEXT_BYTES).is_ok_and(|bytes| {
            let parsed: Result<serde_json::Value, _> = serde_json::from_slice(&bytes);
            parsed.is_ok_and(|value| value.get("material").is_some())
        });
        if !is_list {
            self.add_report(path);
            return Ok(());
        }
        match list_in(path) {
            Ok(list) => {
                let folder = folder_of(path);
                let fault = list_fault(&list, folder);
                self.known(path, Some("list"), fault);
                let packs = list.parts.values().map(|name| (folder.join(name), Check::Pack(None)));
                self.checks.extend(packs.collect::<Vec<_>>());
            }
            Err(fault) => self.known(path, None, Some(fault)),
        }
        Ok(())
    }

    /// Number of files to check.
    pub fn count(&self) -> usize {
        self.checks.len()
    }

    /// Runs all checks. Results are in the order in which they were added.
    ///
    /// # Errors
    /// Returns an error if cancelled.
    pub fn run(self, progress: &dyn Progress) -> Result<Vec<CheckedFile>, Error> {
        progress.stage(Stage::Verify, self.checks.len())?;
        let files = self.checks.into_par_iter().map(|(path, check)| {
            progress.check()?;
            let file = match check {
                Check::Known(file) => file,
                Check::Pack(listed) => checked(&path, MAX_FILE_BYTES, listed, pack_kind),
                Check::List(listed) => checked(&path, MAX_TEXT_BYTES, Some(listed), |_| Ok("list")),
            };
            progress.step()?;
            Ok(file)
        });
        files.collect()
    }
}

/// Checks the bytes of a file, and its hash if a report lists it.
fn checked(
    path: &Path,
    limit: u64,
    listed: Option<Digest>,
    kind: impl FnOnce(&[u8]) -> Result<&'static str, String>,
) -> CheckedFile {
    let found = bytes_of(path, limit, listed).and_then(|(bytes, changed)| Ok((kind(&bytes)?, changed)));
    let (kind, fault) = match found {
        Ok((kind, changed)) => (Some(kind), changed),
        Err(fault) => (None, Some(fault)),
    };
    CheckedFile { file: path.display().to_string(), kind, fault }
}

fn pack_kind(bytes: &[u8]) -> Result<&'static str, String> {
    Pack::from_bytes(bytes).map(|pack| pack.kind().name()).map_err(|error| error.to_string())
}

/// The bytes of a file, and the fault if their hash differs from the listed one.
fn bytes_of(path: &Path, limit: u64, listed: Option<Digest>) -> Result<(Vec<u8>, Option<String>), String> {
    let bytes = read_regular_file(path, limit).map_err(|error| {
        let text = error.to_string();
        text.strip_prefix(&format!("{}: ", path.display())).map_or(text.clone(), str::to_owned)
    })?;
    let digest = Digest::of(&bytes);
    let changed = listed.filter(|listed| *listed != digest);
    let fault = changed.map(|listed| format!("changed since the build: found BLAKE3 {digest}, expected {listed}"));
    Ok((bytes, fault))
}

/// Fault within a report. A material's figures must match its list, whose hash is in the report.
fn report_fault(report: &BuildReport) -> Option<String> {
    for entry in &report.materials {
        let Some(list) = entry.file() else { continue };
        let digest = Digest::of(&list.to_bytes());
        let name = &entry.material;
        let hashed: BTreeSet<&String> = entry.files.iter().map(|file| &file.file).collect();
        if hashed != list.parts.values().collect() {
            return Some(format!("{name}: the hashed files are not the parts of the material"));
        }
        match &entry.list {
            None => return Some(format!("{name}: no hash of its list of parts")),
            Some(listed) if listed.blake3 != digest => {
                return Some(format!("{name}: the figures do not match the hash of {}", listed.file));
            }
            Some(_) => {}
        }
    }
    let environment = report.environment.as_ref().filter(|entry| entry.maps.is_some());
    if environment.is_some_and(|entry| !entry.files.iter().map(|file| &file.file).eq(entry.names())) {
        return Some("environment: the hashed files are not its maps".to_owned());
    }
    (report.files().next().is_none()).then(|| "no files: the build made no material".to_owned())
}

fn list_in(path: &Path) -> Result<MaterialFile, String> {
    let bytes = read_regular_file(path, MAX_TEXT_BYTES).map_err(|error| error.to_string())?;
    let allowed = "the MATERIAL.json of a build by this version of brdfc";
    let list: MaterialFile = serde_json::from_slice(&bytes)
        .map_err(|error| format!("found {}, expected {allowed}", json_problem(&error)))?;
    if let Some(name) = list.parts.values().find(|name| !crate::file_name::is_plain(name)) {
        return Err(format!("the part {name:?} is outside the folder; expected {allowed}"));
    }
    match list.version {
        MATERIAL_VERSION => Ok(list),
        version => Err(format!("found layout version {version}, expected {MATERIAL_VERSION}")),
    }
}

/// Fault of a list. It must have the key/value data of its pack, including the checksum.
fn list_fault(list: &MaterialFile, folder: &Path) -> Option<String> {
    let Some(name) = list.parts.get(PACK) else { return Some("no pack among the parts".to_owned()) };
    let bytes = read_regular_file(&folder.join(name), MAX_FILE_BYTES).ok()?;
    (entries(&bytes) != list.report.entries).then(|| format!("the key/value data differ from the data in {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{PackRecipe, encode};
    use brdfc_core::address::parse_synth;

    fn checked(path: &Path) -> Result<Vec<CheckedFile>, Error> {
        let mut checks = Checks::default();
        checks.add(path)?;
        checks.run(&())
    }

    /// Flips each bit of a small pack in turn.
    #[test]
    fn each_flipped_bit_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let white = parse_synth("synth:lambert").expect("a model");
        let bytes = encode(white.as_ref(), &PackRecipe::default(), &()).expect("a pack").bytes;
        let path = folder.path().join("white.ktx2");
        std::fs::write(&path, &bytes).expect("written");
        assert_eq!(checked(&path).expect("a pack")[0].fault, None);
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(Pack::from_bytes(&flipped).is_err(), "bit {bit}");
        }
        let mut flipped = bytes.clone();
        flipped[bytes.len() - 1] ^= 1;
        std::fs::write(&path, &flipped).expect("written");
        let found = checked(&path).expect("a file");
        assert!(found[0].fault.as_ref().is_some_and(|fault| fault.contains("checksum")), "{found:?}");
    }

    #[test]
    fn nothing_to_check_is_no_success() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = checked(folder.path()).expect_err("an empty folder");
        assert_eq!(error.kind(), crate::ErrorKind::Check, "{error}");
        assert_eq!(checked(&folder.path().join("gone.ktx2")).expect_err("no file").kind(), crate::ErrorKind::Io);
        std::fs::write(folder.path().join("image.png"), b"").expect("written");
        assert_eq!(checked(&folder.path().join("image.png")).expect_err("an image").kind(), crate::ErrorKind::Usage);
        assert_eq!(Checks::default().run(&()).expect("nothing"), []);
    }
}
