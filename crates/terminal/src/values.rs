//! Parsers for the values of flags.

pub use brdfc_core::byte_count::bytes_from_text;
pub use brdfc_core::whole_number::{any_whole_number, whole_number};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parses one of several values by its name; each has a help text, which may be empty.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: &'static [(&'static str, T, &'static str)],
) -> impl TypedValueParser<Value = T> {
    let possible = all.iter().map(|(name, _, help)| match *help {
        "" => PossibleValue::new(*name),
        help => PossibleValue::new(*name).help(help),
    });
    let find = move |given: String| all.iter().find(|(name, ..)| *name == given).expect("a name of one").1;
    PossibleValuesParser::new(possible).map(find)
}
