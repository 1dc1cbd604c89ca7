//! Hashes of bytes, and keys of entries.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// A BLAKE3 hash: 64 hexadecimal digits in text and JSON, 32 bytes in binary formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest([u8; 32]);

impl Digest {
    /// Hashes bytes in memory.
    pub fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// Returns the hash of all bytes that the hasher has received.
    pub(super) fn finish(hasher: &blake3::Hasher) -> Self {
        Self(*hasher.finalize().as_bytes())
    }

    /// The 32 bytes of the hash.
    pub fn bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl Serialize for Digest {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() { serializer.collect_str(self) } else { self.0.serialize(serializer) }
    }
}

impl<'de> Deserialize<'de> for Digest {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if !deserializer.is_human_readable() {
            return <[u8; 32]>::deserialize(deserializer).map(Self);
        }
        let text = String::deserialize(deserializer)?;
        blake3::Hash::from_hex(&text).map(|hash| Self(*hash.as_bytes())).map_err(D::Error::custom)
    }
}

impl schemars::JsonSchema for Digest {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Digest".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "pattern": "^[0-9a-f]{64}$" })
    }
}

/// Key of an entry: a hash of all inputs that affect the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Key(Digest);

/// Hash of the encoders' sources. Programs with the same encoders make the same bytes.
const ENCODERS: &str = env!("BRDFC_ENCODERS");

impl Key {
    /// Returns the key of a part that a resolved recipe makes from a source.
    pub fn new(part: &str, source: Digest, recipe: &impl Serialize) -> Self {
        let recipe =
            bincode::serde::encode_to_vec(recipe, bincode::config::standard()).expect("recipes are plain data");
        let mut hasher = blake3::Hasher::new();
        for piece in [ENCODERS.as_bytes(), part.as_bytes(), source.bytes(), &recipe] {
            hasher.update(&(piece.len() as u64).to_le_bytes());
            hasher.update(piece);
        }
        Self(Digest::finish(&hasher))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal_where_people_read_it() {
        let digest = Digest::of(b"pack");
        let text = serde_json::to_string(&digest).unwrap();
        assert_eq!(text, format!("\"{}\"", blake3::hash(b"pack").to_hex()));
        assert_eq!(serde_json::from_str::<Digest>(&text).unwrap(), digest);
        assert!(serde_json::from_str::<Digest>("\"12\"").is_err());
    }

    #[test]
    fn everything_that_decides_changes_the_key() {
        let (a, b) = (Digest::of(b"a"), Digest::of(b"b"));
        let key = Key::new("brdf", a, &4u32);
        assert_eq!(key, Key::new("brdf", a, &4u32));
        for other in [Key::new("maps", a, &4u32), Key::new("brdf", b, &4u32), Key::new("brdf", a, &5u32)] {
            assert_ne!(key, other);
        }
    }
}
