//! The two lists of every codec.

use super::{Column, List, folder};

/// The codecs: every folder of the formats that has goldens.
pub fn codecs() -> Vec<&'static str> {
    let folders = std::fs::read_dir(crate::repository().join("formats/src")).expect("the formats can be listed");
    let name = |folder: std::fs::DirEntry| folder.file_name().into_string().ok();
    let names = folders.filter_map(|folder| name(folder.ok()?));
    let mut codecs: Vec<&str> = names.filter(|name| folder(name).is_dir()).map(|name| &*name.leak()).collect();
    codecs.sort_unstable();
    codecs
}

/// Whether packs of a codec have reflectances, and say how wrong they are.
fn of_reflectances(codec: &str) -> bool {
    ["table", "wavelet"].contains(&codec)
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
