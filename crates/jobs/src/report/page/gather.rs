//! Gathers the contents of a page: the report in a folder, its packs, and their sources if they still exist.

use super::against::{Regression, regressions};
use super::evidence::{Evidence, LitBall, evidence};
use super::parts::{PagePart, listed_pack, map_part, wrong_kind};
use super::view_link::ViewLink;
use crate::error::Error;
use crate::output_folder::OutputFolder;
use crate::report::build::{BuildReport, EnvironmentEntry, MaterialEntry};
use crate::scene::build::{BuiltNote, notes};
use crate::scene::plan::REPORT;
use crate::scene::run::{kind_of, opened_with_digest};
use crate::write::folder_of;
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_formats::{BrdfPack, Pack, PackKind};
use brdfc_source::Input;
use rayon::prelude::*;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Contents of a page about a build.
#[derive(Debug)]
pub struct Page {
    /// Name of the scene.
    pub scene: String,
    /// Materials of the scene, sorted by name.
    pub materials: Vec<PageMaterial>,
    /// The environment that lights the scene, with its maps.
    pub environment: Option<(EnvironmentEntry, Vec<PagePart>)>,
    /// Materials that no use refers to.
    pub skipped: Vec<String>,
    /// True if the build was compared with an earlier one.
    pub is_compared: bool,
    /// Regressions against the earlier build.
    pub regressions: Vec<Regression>,
    /// The viewer page to link to.
    pub view: Option<ViewLink>,
}

/// One material of a page.
#[derive(Debug)]
pub struct PageMaterial {
    /// The material's entry in the build report.
    pub entry: MaterialEntry,
    /// Source and seconds per stage of the build, if known.
    pub note: BuiltNote,
    /// Renderings and errors; absent without a pack.
    pub evidence: Option<Evidence>,
    /// Its lobes, bandwidth map and importance samples, if the scene has them.
    pub maps: Vec<PagePart>,
    /// Why the pack was not compared with its source; absent if it was.
    pub without_source: Option<String>,
}

/// The report of a folder and of an earlier build.
#[derive(Debug)]
pub struct Reports {
    folder: PathBuf,
    new: BuildReport,
    old: Option<BuildReport>,
    /// No build moves files meanwhile.
    _held: Option<File>,
}

impl Reports {
    /// Reads both reports. `against` is the `report.json` of the earlier build. Builds wait until the page is gathered before
    /// they move files into the folder.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or is not a report, or if a build keeps moving files in the folder.
    pub fn open(folder: &Path, against: Option<&Path>) -> Result<Self, Error> {
        let held = OutputFolder::hold_still(folder)?;
        if OutputFolder::is_unfinished(folder) {
            let text = "a build was stopped while it replaced files; 'brdfc build' finishes it";
            return Err(Error::input(format!("{}: {text}", folder.display())));
        }
        let new = BuildReport::open(&folder.join(REPORT))?;
        let old = |path: &Path| {
            let _held = OutputFolder::hold_still(folder_of(path))?;
            BuildReport::open(path)
        };
        Ok(Self { folder: folder.to_owned(), new, old: against.map(old).transpose()?, _held: held })
    }

    /// All files of the build (packs, maps and lists) and the sources of its packs.
    pub fn files(&self) -> Vec<PathBuf> {
        let own = self.new.files().map(|entry| self.folder.join(&entry.file));
        let sources = notes(&self.folder).into_values().map(|note| PathBuf::from(note.source));
        own.chain(sources).collect()
    }

    /// Packs of the materials that have one, with the materials' names.
    ///
    /// # Errors
    /// Returns an error if a pack cannot be read or differs from the report.
    pub fn brdf_packs(&self) -> Result<Vec<(String, BrdfPack)>, Error> {
        let made = self.new.materials.iter().filter(|entry| entry.report.is_some());
        let named = made.filter_map(|entry| Some((entry, entry.pack.as_ref()?)));
        named.map(|(entry, name)| Ok((entry.material.clone(), brdf_pack(&self.folder, entry, name)?))).collect()
    }

    /// Number of materials in the newer build.
    pub fn count(&self) -> usize {
        self.new.materials.len()
    }
}

/// Draws the packs of a folder and their sources. `tolerance` is the relative growth of figures that is no regression.
///
/// # Errors
/// Returns an error if a pack cannot be read or differs from the report.
pub fn gather(reports: Reports, tolerance: f64, progress: &dyn Progress) -> Result<Page, Error> {
    let Reports { folder, new: report, old, _held } = reports;
    let folder = folder.as_path();
    let notes = notes(folder);
    let is_compared = old.is_some();
    let regressions = old.map_or(Vec::new(), |old| regressions(&report, &old, tolerance));
    let (environment, ball) = report.environment.map(|entry| environment(folder, entry)).transpose()?.unzip();
    let ball = ball.flatten();
    let drawn = |entry: MaterialEntry| {
        progress.check()?;
        let note = notes.get(&entry.material).cloned().unwrap_or_default();
        let name = entry.material.clone();
        let part = progress.part(&name);
        let material = material(folder, entry, note, ball.as_ref());
        part.finished(material.is_ok());
        material
    };
    let materials = report.materials.into_par_iter().map(drawn).collect::<Result<_, Error>>()?;
    Ok(Page {
        scene: report.scene,
        materials,
        environment,
        skipped: report.skipped,
        is_compared,
        regressions,
        view: None,
    })
}

fn material(
    folder: &Path,
    entry: MaterialEntry,
    note: BuiltNote,
    ball: Option<&LitBall>,
) -> Result<PageMaterial, Error> {
    let Some(name) = entry.pack.as_ref().filter(|_| entry.report.is_some()) else {
        return Ok(PageMaterial { entry, note, evidence: None, maps: Vec::new(), without_source: None });
    };
    let pack = brdf_pack(folder, &entry, name)?;
    let source = source_of(&note);
    let names = [
        (&entry.lobes, PackKind::Lobes),
        (&entry.bandwidth, PackKind::Bandwidth),
        (&entry.samples, PackKind::Importance),
        (&entry.texture, PackKind::Bandwidth),
    ];
    let (mut maps, mut lobes) = (Vec::new(), None);
    for (name, kind) in names {
        let Some(name) = name else { continue };
        let (pack, part) = map_part(folder, &entry.files, name, kind)?;
        maps.push(part);
        if let Pack::Lobes(pack) = pack {
            lobes = Some(pack);
        }
    }
    let of_source = source.as_ref().ok().map(|source| source.as_ref() as &dyn Source);
    let evidence = evidence(&pack, of_source, lobes.as_ref().zip(ball))?;
    Ok(PageMaterial { entry, note, evidence: Some(evidence), maps, without_source: source.err() })
}

/// Reads the pack of a material and checks it against the report.
fn brdf_pack(folder: &Path, entry: &MaterialEntry, name: &str) -> Result<BrdfPack, Error> {
    let (pack, _) = listed_pack(folder, &entry.files, name)?;
    BrdfPack::try_from(pack).map_err(|kind| wrong_kind(&folder.join(name), kind, "a pack of a BRDF"))
}

/// Opens the source of a material, if it still exists.
///
/// # Errors
/// Returns the reason as the page prints it.
pub fn source_of(note: &BuiltNote) -> Result<Box<dyn Source>, String> {
    if note.source.is_empty() {
        return Err("the path of the source is unknown: the folder has no store".to_owned());
    }
    let input = Input::from(note.source.as_str());
    let reading = serde_json::from_str(&note.reading)
        .map_err(|error| format!("{}: settings of reading: {error}", note.source))?;
    let (opened, digest, _) =
        opened_with_digest(&input, reading, &kind_of(&input), u64::MAX).map_err(|error| error.to_string())?;
    match note.digest {
        Some(built) if built != digest => Err(format!("{}: changed since the build", note.source)),
        _ => Ok(opened.source),
    }
}

/// An environment with its files.
type PageEnvironment = (EnvironmentEntry, Vec<PagePart>);

/// Reads the files of an environment, and makes a ball in it if lobes look it up.
fn environment(folder: &Path, entry: EnvironmentEntry) -> Result<(PageEnvironment, Option<LitBall>), Error> {
    let (mut parts, mut ball) = (Vec::new(), None);
    for (name, kind) in [(&entry.prefiltered, PackKind::Environment), (&entry.bandwidth, PackKind::Bandwidth)] {
        // A planned environment has names without files.
        let Some(name) = name.as_ref().filter(|_| !entry.files.is_empty()) else { continue };
        let (pack, part) = map_part(folder, &entry.files, name, kind)?;
        parts.push(part);
        if let Pack::Environment(pack) = pack {
            ball = Some(LitBall::new(pack));
        }
    }
    Ok(((entry, parts), ball))
}
