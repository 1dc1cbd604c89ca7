//! Hashes all sources that determine the bytes of packs, and the versions of their dependencies. Builds reuse packs of earlier
//! builds with the same hash, even if other parts of the program have changed.

use std::hash::{DefaultHasher, Hasher as _};
use std::path::{Path, PathBuf};

/// Sources that determine the bytes of packs, relative to this crate. Code that prints, draws or manages files is not
/// included, unless it shares a folder with such sources.
const SOURCES: [&str; 21] = [
    "../../formats/src",
    "../core/src",
    "../readers/src",
    "../source/src",
    "../metrics/src",
    "../codec/src",
    "../codecs",
    "../encode/src",
    "../render/src/environment.rs",
    "src/environment.rs",
    "src/exposure.rs",
    "src/lobes.rs",
    "src/pack_files.rs",
    "src/pwt",
    "src/report/fit.rs",
    "src/report/material.rs",
    "src/scene/assets",
    "src/scene/lobes.rs",
    "src/scene/maps.rs",
    "src/scene/textures.rs",
    "../../Cargo.lock",
];

/// One of the sources, which is missing if this crate was unpacked by itself.
const CHECKOUT: &str = "../../formats/src";

fn main() {
    let mut files = Vec::new();
    if !Path::new(CHECKOUT).is_dir() {
        // Published versions do not change, and all crates of one version are published together.
        println!("cargo:rustc-env=BRDFC_ENCODERS={}", std::env::var("CARGO_PKG_VERSION").unwrap_or_default());
        return;
    }
    for place in SOURCES {
        println!("cargo:rerun-if-changed={place}");
        gather(Path::new(place), &mut files);
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in &files {
        let bytes = std::fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        // Ignores line endings, which depend on the checkout.
        bytes.split(|byte| *byte == b'\r').for_each(|piece| hasher.write(piece));
        hasher.write(file.to_string_lossy().replace('\\', "/").as_bytes());
    }
    // Logarithms may be rounded differently elsewhere.
    hasher.write(std::env::var("TARGET").unwrap_or_default().as_bytes());
    println!("cargo:rustc-env=BRDFC_ENCODERS={:016x}", hasher.finish());
}

fn gather(place: &Path, files: &mut Vec<PathBuf>) {
    if place.is_file() {
        files.push(place.to_owned());
        return;
    }
    let entries = std::fs::read_dir(place).unwrap_or_else(|error| panic!("{}: {error}", place.display()));
    for entry in entries.flatten() {
        let path = entry.path();
        let is_source_folder = path.is_dir() && !path.ends_with("tests") && !path.ends_with("testdata");
        if is_source_folder || path.extension().is_some_and(|extension| extension == "rs" || extension == "wgsl") {
            gather(&path, files);
        }
    }
}
