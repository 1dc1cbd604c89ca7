//! The two lists of every codec.

use super::{Column, List};
use brdfc_formats::PackKind;

/// The codecs, by their folders of the formats.
pub fn codecs() -> Vec<&'static str> {
    let codecs: Vec<&str> = PackKind::ALL.into_iter().map(folder_name).collect();
    let folders = std::fs::read_dir(crate::repository().join("formats/src")).expect("the formats");
    let mut folders: Vec<String> = folders
        .map(|folder| folder.expect("a folder"))
        .filter(|folder| folder.path().join("golden").is_dir())
        .map(|folder| folder.file_name().display().to_string())
        .collect();
    folders.retain(|folder| !codecs.contains(&folder.as_str()));
    assert!(folders.is_empty(), "goldens of no codec: {folders:?}");
    codecs
}

/// The folder that a codec's specification is in.
fn folder_name(kind: PackKind) -> &'static str {
    kind.descriptor().specification.rsplit('/').nth(1).expect("a page in the codec's folder")
}

/// The codec of a folder.
pub fn kind(codec: &str) -> PackKind {
    PackKind::ALL.into_iter().find(|kind| folder_name(*kind) == codec).unwrap_or_else(|| panic!("no codec {codec}"))
}

/// Whether packs of a codec have reflectances, and say how wrong they are.
fn of_reflectances(codec: &str) -> bool {
    kind(codec).descriptor().brdf.is_some()
}

/// Packs in the codec's folder, as decoders read them.
pub fn corpus(codec: &'static str) -> List {
    const ABOUT: &[&str] = &["Packs beside this file: hashes of the files and of what decoders make of them."];
    const COLUMNS: &[Column] = &[Column::everywhere("file"), Column::everywhere("values")];
    const OF_REFLECTANCES: &[Column] = &[
        Column::everywhere("errors"),
        Column::everywhere("file"),
        // The exponential is the C library's.
        Column::on_one_platform("reflectances"),
        Column::everywhere("values"),
    ];
    let columns = if of_reflectances(codec) { OF_REFLECTANCES } else { COLUMNS };
    List { codec, file: "corpus.toml", about: ABOUT, columns }
}

/// What encoders make of committed inputs.
pub fn encodes(codec: &'static str) -> List {
    const ABOUT: &[&str] = &[
        "What tests/suite/golden.rs of the encoder makes: 'contents' are hashes of what an encoder stores, entries and texels; 'file' of",
        "all bytes; the others of what decoders make of them. Encoders use ln, exp and trigonometry of the C library.",
    ];
    const COLUMNS: &[Column] =
        &[Column::on_one_platform("contents"), Column::on_one_platform("file"), Column::on_one_platform("values")];
    const OF_REFLECTANCES: &[Column] = &[
        Column::on_one_platform("contents"),
        Column::on_one_platform("errors"),
        Column::on_one_platform("file"),
        Column::on_one_platform("reflectances"),
        Column::on_one_platform("values"),
    ];
    let columns = if of_reflectances(codec) { OF_REFLECTANCES } else { COLUMNS };
    List { codec, file: "encode.toml", about: ABOUT, columns }
}
