//! The two lists of every codec.

use super::{Column, List};
use brdfc_formats::PackKind;

/// The codecs, named by their folders in the formats.
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

/// Folder of a codec's specification.
fn folder_name(kind: PackKind) -> &'static str {
    kind.descriptor().specification.rsplit('/').nth(1).expect("a page in the codec's folder")
}

/// The codec of a folder.
pub fn kind(codec: &str) -> PackKind {
    PackKind::ALL.into_iter().find(|kind| folder_name(*kind) == codec).unwrap_or_else(|| panic!("no codec {codec}"))
}

/// Returns true if packs of a codec have reflectances and error metadata.
fn of_reflectances(codec: &str) -> bool {
    kind(codec).descriptor().brdf.is_some()
}

/// List of the packs in the codec's folder, which decoders read.
pub fn corpus(codec: &'static str) -> List {
    const ABOUT: &[&str] = &["Packs next to this file: hashes of the files and of their decoded values."];
    const COLUMNS: &[Column] = &[Column::everywhere("file"), Column::everywhere("values")];
    const OF_REFLECTANCES: &[Column] = &[
        Column::everywhere("errors"),
        Column::everywhere("file"),
        // The exponential comes from the C library.
        Column::on_one_platform("reflectances"),
        Column::everywhere("values"),
    ];
    let columns = if of_reflectances(codec) { OF_REFLECTANCES } else { COLUMNS };
    List { codec, file: "corpus.toml", about: ABOUT, columns }
}

/// List of the output of encoders for committed inputs.
pub fn encodes(codec: &'static str) -> List {
    const ABOUT: &[&str] = &[
        "Packs that tests/suite/golden.rs of the encoder makes: 'contents' are hashes of the stored metadata and texels;",
        "'file' of all bytes; the others of decoded values. Encoders use ln, exp and trigonometry of the C library.",
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
