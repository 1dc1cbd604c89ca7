//! The build cache: what a pack was made from, so that unchanged materials are not made again.
//!
//! One `bincode` file per material in a folder beside the packs. A stale or broken entry is no error: the material is
//! made again.

use crate::brdf::encode::Recipe;
use crate::report::material::MaterialReport;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Folder of the cache, inside the output folder.
pub const FOLDER: &str = ".brdfc-cache";

/// Everything that decides a pack's bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// Hash of the program: a new version makes everything again.
    pub program: [u8; 32],
    /// Hash of the source's bytes, or of its address.
    pub source: [u8; 32],
    /// All options.
    pub recipe: Recipe,
}

/// What is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// What the pack was made from.
    pub key: Key,
    /// Hash of the pack.
    pub pack: [u8; 32],
    /// What was measured.
    pub report: MaterialReport,
}

/// Hash of a file's bytes.
pub fn hash_file(path: &Path) -> std::io::Result<[u8; 32]> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(path)?)?;
    Ok(*hasher.finalize().as_bytes())
}

/// Hash of bytes in memory.
pub fn hash(bytes: &[u8]) -> [u8; 32] {
    *blake3::hash(bytes).as_bytes()
}

/// Hash of this very program.
pub fn hash_program() -> std::io::Result<[u8; 32]> {
    hash_file(&std::env::current_exe()?)
}

fn path(out: &Path, material: &str) -> PathBuf {
    out.join(FOLDER).join(format!("{material}.bincode"))
}

/// The report of a material whose pack is there, whole, and made from the same key.
pub fn look_up(out: &Path, material: &str, pack: &Path, key: &Key) -> Option<MaterialReport> {
    let bytes = std::fs::read(path(out, material)).ok()?;
    let config = bincode::config::standard().with_limit::<{ 1 << 20 }>();
    let (entry, _): (Entry, usize) = bincode::serde::decode_from_slice(&bytes, config).ok()?;
    (entry.key == *key && hash_file(pack).ok()? == entry.pack).then_some(entry.report)
}

/// Keeps an entry.
pub fn store(out: &Path, material: &str, entry: &Entry) -> std::io::Result<()> {
    std::fs::create_dir_all(out.join(FOLDER))?;
    let bytes = bincode::serde::encode_to_vec(entry, bincode::config::standard()).map_err(std::io::Error::other)?;
    super::write::write_atomic(&path(out, material), &bytes)
}
