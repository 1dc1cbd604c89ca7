//! Keys of a TOML section, from the type into which it is deserialised.

use serde::de::{Deserialize, Deserializer, Error, Visitor};

/// Names of the fields of a struct.
///
/// # Panics
/// Panics if the type is not a struct.
pub fn keys_of<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    let mut keys = None;
    let _ = T::deserialize(Keys(&mut keys));
    keys.expect("a struct")
}

/// Deserializer that records the requested fields and then fails.
struct Keys<'a>(&'a mut Option<&'static [&'static str]>);

impl<'de> Deserializer<'de> for Keys<'_> {
    type Error = serde::de::value::Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
        Err(Error::custom("keys alone"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Self::Error> {
        *self.0 = Some(fields);
        Err(Error::custom("keys alone"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_the_fields() {
        #[derive(serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        struct Table {
            _first_key: u32,
            #[serde(default, rename = "other")]
            _second: Option<String>,
        }
        assert_eq!(keys_of::<Table>(), ["-first-key", "other"]);
    }
}
