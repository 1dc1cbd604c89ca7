//! Messages that name options.

use std::fmt::{Display, Formatter};
use std::ops::Range;

/// Text of a message, and the positions of the option keys in it. Callers choose how keys are named: text that the user
/// wrote is never taken for a key.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Message {
    text: String,
    keys: Vec<Range<usize>>,
}

impl Message {
    /// Appends text without keys.
    #[must_use]
    pub fn with_text(mut self, text: impl Display) -> Self {
        self.text += &text.to_string();
        self
    }

    /// Appends the key of an option.
    #[must_use]
    pub fn with_key(mut self, key: &str) -> Self {
        let start = self.text.len();
        self.text += key;
        self.keys.push(start..self.text.len());
        self
    }

    /// Appends a message with its keys.
    #[must_use]
    pub fn with_message(mut self, other: &Self) -> Self {
        let start = self.text.len();
        self.text += &other.text;
        self.keys.extend(other.keys.iter().map(|key| start + key.start..start + key.end));
        self
    }

    /// Replaces each key by its name.
    #[must_use]
    pub fn named(&self, name: impl Fn(&str) -> String) -> Self {
        let (mut text, mut end) = (String::new(), 0);
        for key in &self.keys {
            text += &self.text[end..key.start];
            text += &name(&self.text[key.clone()]);
            end = key.end;
        }
        Self::from(text + &self.text[end..])
    }

    /// The text, with the keys of a manifest.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Self { text, keys: Vec::new() }
    }
}

impl From<&str> for Message {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl Display for Message {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.pad(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_keys_are_renamed() {
        let problem = Message::from("conflicts with ").with_key("bits").with_text(", as in bits");
        let message = Message::from("bits.brdf: ").with_key("levels").with_text(": ").with_message(&problem);
        assert_eq!(message.to_string(), "bits.brdf: levels: conflicts with bits, as in bits");
        let named = message.named(|key| format!("--{key}"));
        assert_eq!(named.as_str(), "bits.brdf: --levels: conflicts with --bits, as in bits");
        assert_eq!(named.named(|_| String::new()), named);
    }
}
