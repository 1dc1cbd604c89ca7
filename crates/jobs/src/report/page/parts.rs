//! Files of a build other than packs, with a summary and an image of their contents.

use crate::error::Error;
use crate::report::build::FileEntry;
use crate::store::Digest;
use brdfc_bandwidth::facts::BandwidthFacts;
use brdfc_core::words::counted;
use brdfc_environment::facts::EnvironmentFacts;
use brdfc_formats::{Pack, PackKind};
use brdfc_importance::ImportanceFacts;
use brdfc_lobes::LobesFacts;
use brdfc_render::rendering::{Panel, bandwidth_panel};
use brdfc_source::read::{MAX_FILE_BYTES, read_regular_file};
use std::fmt::Display;
use std::path::Path;

/// A map of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct PagePart {
    /// File name of the map, in the folder of packs.
    pub file: String,
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Summary of its contents.
    pub summary: String,
    /// Image of a bandwidth map, from 1/256 of its largest value and less (dark) to the largest (light).
    pub image: Option<Panel>,
}

/// Reads a pack that a report lists, and the bytes of its file.
///
/// # Errors
/// Returns an error if the file cannot be read, is no pack or differs from the listed one.
pub(super) fn listed_pack(folder: &Path, listed: &[FileEntry], name: &str) -> Result<(Pack, u64), Error> {
    let path = folder.join(name);
    let bytes = read_regular_file(&path, MAX_FILE_BYTES)?;
    let entry = listed.iter().find(|file| file.file == name);
    if entry.is_some_and(|file| file.blake3 != Digest::of(&bytes)) {
        return Err(wrong_file(&path, "changed since the build"));
    }
    let pack = Pack::from_bytes(&bytes).map_err(|error| wrong_file(&path, error))?;
    Ok((pack, bytes.len() as u64))
}

/// Error about a file that differs from the report.
fn wrong_file(path: &Path, what: impl Display) -> Error {
    Error::input(format!("{}: {what}; run 'brdfc build'", path.display()))
}

/// Error about a pack of another kind than the report lists.
pub(super) fn wrong_kind(path: &Path, found: PackKind, expected: &str) -> Error {
    wrong_file(path, format!("found {}, expected {expected}, as report.json lists", found.summary()))
}

/// Reads and describes lobes, a bandwidth map, importance samples or a prefiltered environment that a report lists.
///
/// # Errors
/// Same as [`listed_pack`]. Also returns an error for a pack of another kind.
pub(super) fn map_part(
    folder: &Path,
    listed: &[FileEntry],
    name: &str,
    kind: PackKind,
) -> Result<(Pack, PagePart), Error> {
    let (pack, bytes_on_disk) = listed_pack(folder, listed, name)?;
    let wrong = || wrong_kind(&folder.join(name), pack.kind(), kind.summary());
    let (bytes_on_gpu, summary, image) = match &pack {
        other if other.kind() != kind => return Err(wrong()),
        Pack::Bandwidth(map) => {
            let facts = BandwidthFacts::new(map);
            (facts.gpu_bytes, bandwidth_summary(&facts), Some(bandwidth_panel(map)))
        }
        Pack::Importance(pack) => {
            let facts = ImportanceFacts::new(pack);
            (facts.gpu_bytes, samples_summary(&facts), None)
        }
        Pack::Lobes(pack) => {
            let facts = LobesFacts::new(pack);
            (facts.gpu_bytes, lobes_summary(&facts), None)
        }
        Pack::Environment(pack) => {
            let facts = EnvironmentFacts::new(pack);
            (facts.gpu_bytes, environment_summary(&facts), None)
        }
        _ => return Err(wrong()),
    };
    Ok((pack, PagePart { file: name.to_owned(), bytes_on_disk, bytes_on_gpu, summary, image }))
}

fn bandwidth_summary(facts: &BandwidthFacts) -> String {
    let [width, height] = facts.size;
    let (largest, mean, unit) = (facts.largest, facts.mean, &facts.unit);
    let what = format!("bandwidth, {width} x {height} values: mean {mean:.2}, largest {largest:.1} {unit}");
    facts.remark().map_or(what.clone(), |remark| format!("{what}. {remark}"))
}

fn lobes_summary(facts: &LobesFacts) -> String {
    let [normal, mirror, viewer] = facts.anchors;
    let fetches = counted(facts.fetches, "look-up");
    format!(
        "lobes, {fetches}: {normal} around the normal, {mirror} around the mirror direction, {viewer} around the viewer"
    )
}

fn environment_summary(facts: &EnvironmentFacts) -> String {
    let EnvironmentFacts { side, levels, largest, .. } = facts;
    format!("prefiltered environment, 6 faces of {side} x {side}, {levels} levels: largest {largest} W/(m² sr)")
}

fn samples_summary(facts: &ImportanceFacts) -> String {
    let ImportanceFacts { polar, azimuths, samples, .. } = facts;
    format!("importance samples: {samples} for each of {polar} x {azimuths} outgoing directions")
}
