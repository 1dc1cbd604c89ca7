//! Compares the output of encoders for committed inputs with the list of a codec.

use super::corpus::{add, entries, moved};
use super::{Change, blessing, hash, lists};
use crate::codec::Measured;
use crate::codecs::tested;
use brdfc_formats::container::{MAX_TEXEL_BYTES, PackedTexture};
use std::collections::BTreeMap;

/// Maximum size of a file for the corpus of packs that later versions must read.
const CORPUS_BYTES: usize = 12 << 10;

/// Files by name, as `corpus` has them.
pub type Packs = BTreeMap<String, Vec<u8>>;

/// The entry that is derived from all others.
const CHECKSUM: &str = "brdfc.checksum";

/// Hash of the data that an encoder stores, independent of the container: format and extent, entries except measured
/// values, texels.
fn contents(bytes: &[u8], measured: &[Measured]) -> String {
    let texture = PackedTexture::from_bytes(bytes).and_then(|packed| packed.unpack_levels(MAX_TEXEL_BYTES));
    let texture =
        texture.unwrap_or_else(|error| panic!("the container's reader refuses a pack that was just made: {error}"));
    // vkFormat to layerCount.
    let mut stored = bytes[12..36].to_vec();
    for (key, value) in texture.entries.iter().filter(|(key, _)| *key != CHECKSUM) {
        let mut value = value.clone();
        match measured.iter().find(|(entry, _)| entry == key) {
            Some((_, None)) => continue,
            Some((_, Some(range))) => drop(value.drain(range.clone())),
            // An entry that is itself a file.
            None if key.starts_with("brdfc.image.") => value = contents(&value, &[]).into_bytes(),
            None => {}
        }
        stored.extend(format!("{key} {} ", value.len()).into_bytes());
        stored.extend(value);
    }
    stored.extend(&texture.texels);
    hash(&stored)
}

/// Compares encoded packs with a codec's list. Blessing also adds small packs to the corpus if `selected` returns true.
pub fn check_encodes(codec: &'static str, packs: &Packs, selected: impl Fn(&str) -> bool) {
    if blessing() {
        for (file, bytes) in packs.iter().filter(|(file, bytes)| selected(file) && bytes.len() <= CORPUS_BYTES) {
            add(codec, file.trim_end_matches(".ktx2"), bytes);
        }
    }
    let measured = tested(lists::kind(codec)).measured();
    let mut found = entries(packs);
    for (name, hashes) in &mut found {
        hashes.insert("contents", contents(&packs[name], measured));
    }
    lists::encodes(codec).check(found, |changes| inverse_summary(codec, changes));
}

/// Summary of the decoder for changed contents. Their values do not test the decoder, but committed packs do.
fn inverse_summary(codec: &'static str, changes: &[Change]) -> String {
    if changes.iter().all(|change| change.column != "contents") {
        return String::new();
    }
    match moved(codec) {
        0 => format!("The decoder is unchanged: the committed packs of {codec} have the same values."),
        count => format!("The decoder changed, too: {count} committed packs of {codec} have other values."),
    }
}
