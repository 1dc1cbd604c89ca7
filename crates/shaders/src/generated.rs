//! Translated decoders from `generated.json`. `brdfc-translate` makes them, and `./scripts/bless` writes the file, so
//! that no program needs a translator.

use crate::interface::Interface;
use crate::language::Language;
use brdfc_formats::PackKind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// One translated decoder. The WGSL itself is not included.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generated {
    /// Bindings and callable functions.
    pub interface: Interface,
    /// Lines of the declarations and functions, by the name of the language.
    pub texts: BTreeMap<String, Vec<String>>,
    /// Words of the compute shader in SPIR-V.
    #[serde(with = "hexadecimal")]
    pub spirv: Vec<u32>,
}

impl Generated {
    /// Path of the file with all decoders, by the name of the decoder.
    pub const FILE: &str = "crates/shaders/src/generated.json";

    /// Returns a translated decoder.
    ///
    /// # Panics
    /// Panics if the file lacks the decoder.
    pub fn of(decoder: PackKind) -> &'static Self {
        static ALL: OnceLock<BTreeMap<String, Generated>> = OnceLock::new();
        let all = ALL.get_or_init(|| serde_json::from_str(include_str!("generated.json")).expect("written by a test"));
        all.get(decoder.name()).unwrap_or_else(|| panic!("{} lacks {}: ./scripts/bless", Self::FILE, decoder.name()))
    }

    /// The text in a language.
    pub(crate) fn text(&self, language: Language) -> String {
        self.texts[language.name()].join("\n") + "\n"
    }
}

/// Words as lines of hexadecimal digits.
mod hexadecimal {
    use serde::de::Error as _;
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    /// Words per line.
    const WORDS: usize = 12;

    pub fn serialize<S: Serializer>(words: &[u32], serializer: S) -> Result<S::Ok, S::Error> {
        let line = |words: &[u32]| words.iter().map(|word| format!("{word:x}")).collect::<Vec<_>>().join(" ");
        words.chunks(WORDS).map(line).collect::<Vec<_>>().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u32>, D::Error> {
        let lines = Vec::<String>::deserialize(deserializer)?;
        let words = lines.iter().flat_map(|line| line.split(' '));
        words.map(|word| u32::from_str_radix(word, 16).map_err(D::Error::custom)).collect()
    }
}
