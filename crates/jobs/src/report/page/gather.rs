//! Gathers the contents of a page: the report in a folder, its packs, and their sources if they still exist.

use super::against::{Regression, regressions};
use super::assets::{PageAsset, page_asset};
use super::evidence::{Evidence, LitBall, ThumbnailScenes, evidence};
use super::parts::{PagePart, listed_pack, map_part, wrong_kind};
use super::view_link::{ViewLink, escaped};
use crate::error::Error;
use crate::output_folder::OutputFolder;
use crate::report::build::{AssetEntry, BuildReport, EnvironmentEntry, MaterialEntry};
use crate::scene::build::{BuiltNote, notes};
use crate::scene::plan::REPORT;
use crate::scene::run::{kind_of, opened_with_digest};
use crate::write::folder_of;
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::{BrdfPack, Pack, PackKind};
use brdfc_source::Input;
use rayon::prelude::*;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::slice;

/// Contents of a page about a build.
#[derive(Debug)]
pub struct Page {
    /// Name of the scene.
    pub scene: String,
    /// Materials of the scene, sorted by name.
    pub materials: Vec<PageMaterial>,
    /// RTI captures, BTFs and environments, sorted by name.
    pub assets: Vec<PageAsset>,
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
    /// Number of materials and assets that are left out because they passed.
    pub left_out: usize,
    /// Names of the pages with the renderings of [`PER_PAGE`] materials each; empty if this page has them.
    pub parts: Vec<String>,
}

/// Maximum number of materials on a page. If there are more, renderings are on pages of their own.
pub const PER_PAGE: usize = 100;

impl Page {
    /// Address of the section of a material or asset; `None` for one that the page leaves out or the build no longer has.
    pub(super) fn address(&self, material: &str) -> Option<String> {
        if self.assets.iter().any(|asset| asset.entry.asset == material) {
            return Some(format!("#{material}"));
        }
        let at = self.materials.binary_search_by(|one| one.entry.material.as_str().cmp(material)).ok()?;
        let part = self.parts.get(at / PER_PAGE).map_or(String::new(), |part| escaped(part));
        Some(format!("{part}#{material}"))
    }

    /// Name of the first material of a part.
    pub(super) fn first_of(&self, part: usize) -> &str {
        self.materials.get(part * PER_PAGE).map_or("", |material| &material.entry.material)
    }
}

/// Settings of [`gather`].
#[derive(Debug, Clone)]
pub struct PageOptions<'a> {
    /// Relative growth of figures that is no regression.
    pub tolerance: f64,
    /// Name of the page, from which other pages are named.
    pub name: &'a str,
    /// The viewer page to link to.
    pub view: Option<ViewLink>,
    /// True to keep the renderings of pages that are written.
    pub keeps_renderings: bool,
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
    /// True to leave out materials that passed.
    only_missed: bool,
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
        Ok(Self { folder: folder.to_owned(), new, old: against.map(old).transpose()?, only_missed: false, _held: held })
    }

    /// Leaves out materials that passed, or not.
    pub fn only_missed(self, only_missed: bool) -> Self {
        Self { only_missed, ..self }
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

    /// Packs of the assets that can be drawn by themselves, with the names of the assets.
    ///
    /// # Errors
    /// Returns an error if a pack cannot be read or differs from the report.
    pub fn tree_packs(&self) -> Result<Vec<(String, PwtPack)>, Error> {
        let mut found = Vec::new();
        for entry in &self.new.assets {
            let Some(listed) = &entry.pack else { continue };
            if let (Pack::Pwt(pack), _) = listed_pack(&self.folder, slice::from_ref(listed), &listed.file)? {
                found.push((entry.asset.clone(), pack));
            }
        }
        Ok(found)
    }

    /// Number of materials and assets of the page.
    pub fn count(&self) -> usize {
        let materials = self.new.materials.iter().filter(|entry| !self.only_missed || !entry.passed()).count();
        materials + self.new.assets.iter().filter(|entry| !self.only_missed || !entry.passed()).count()
    }
}

/// Writes a page of [`Page::parts`], given by its name, with these materials.
pub type WritePart<'a> = &'a mut dyn FnMut(&Page, &str, &[PageMaterial]) -> Result<(), Error>;

/// Draws the packs of a folder and their sources. If there are more than [`PER_PAGE`] materials, `write` receives the name of each
/// further page and its materials, and the page itself has no renderings: those of thousands of materials exceed the memory.
///
/// # Errors
/// Returns an error if a pack cannot be read or differs from the report, and those of `write`.
pub fn gather(
    reports: Reports,
    options: PageOptions<'_>,
    write: WritePart<'_>,
    progress: &dyn Progress,
) -> Result<Page, Error> {
    let Reports { folder, new: mut report, old, only_missed, _held } = reports;
    let folder = folder.as_path();
    let notes = notes(folder);
    let is_compared = old.is_some();
    let regressions = old.map_or(Vec::new(), |old| regressions(&report, &old, options.tolerance));
    let (environment, ball) = report.environment.map(|entry| environment(folder, entry)).transpose()?.unzip();
    let ball = ball.flatten();
    let scenes = ThumbnailScenes::new();
    let drawn = |entry: MaterialEntry| {
        progress.check()?;
        let note = notes.get(&entry.material).cloned().unwrap_or_default();
        let name = entry.material.clone();
        let part = progress.part(&name);
        let material = material(folder, entry, note, ball.as_ref(), &scenes);
        part.finished(material.is_ok());
        material
    };
    let all = report.materials.len() + report.assets.len();
    report.materials.retain(|entry| !only_missed || !entry.passed());
    report.assets.retain(|entry| !only_missed || !entry.passed());
    let asset = |entry: AssetEntry| {
        progress.check()?;
        let name = entry.asset.clone();
        let part = progress.part(&name);
        let asset = page_asset(folder, entry);
        part.finished(asset.is_ok());
        asset
    };
    let assets = report.assets.into_iter().map(asset).collect::<Result<Vec<_>, Error>>()?;
    let count = report.materials.len();
    let parts = if count > PER_PAGE { (1..=count.div_ceil(PER_PAGE)).collect() } else { Vec::new() };
    let mut page = Page {
        scene: report.scene,
        materials: Vec::with_capacity(count),
        environment,
        skipped: report.skipped,
        is_compared,
        regressions,
        view: options.view,
        left_out: all - count - assets.len(),
        assets,
        parts: parts.into_iter().map(|part| part_name(options.name, part)).collect(),
    };
    let mut entries = report.materials.into_iter();
    while page.materials.len() < count {
        let next: Vec<MaterialEntry> = entries.by_ref().take(PER_PAGE).collect();
        let mut next = next.into_par_iter().map(drawn).collect::<Result<Vec<_>, Error>>()?;
        if let Some(name) = page.parts.get(page.materials.len() / PER_PAGE) {
            write(&page, name, &next)?;
            if !options.keeps_renderings {
                next.iter_mut().filter_map(|material| material.evidence.as_mut()).for_each(Evidence::drop_renderings);
            }
        }
        page.materials.append(&mut next);
    }
    Ok(page)
}

/// Name of a page of sections: that of the page, with a number before its extension.
fn part_name(name: &str, part: usize) -> String {
    match name.rsplit_once('.') {
        Some((stem, extension)) => format!("{stem}-{part}.{extension}"),
        None => format!("{name}-{part}"),
    }
}

fn material(
    folder: &Path,
    entry: MaterialEntry,
    note: BuiltNote,
    ball: Option<&LitBall>,
    scenes: &ThumbnailScenes,
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
    let evidence = evidence(&pack, of_source, lobes.as_ref().zip(ball), scenes)?;
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
