//! Parsers for the values of flags.

pub use brdfc_core::byte_count::bytes_from_text;
pub use brdfc_core::whole_number::{any_whole_number, whole_number};

use brdfc_formats::flat_btf::{AZIMUTH_ROWS, POLAR_ANGLES};
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

/// Parses numbers of polar angles and rows of azimuths of an indirection map, separated by an `x`.
///
/// # Errors
/// Returns what is expected.
pub fn views_of_map(text: &str) -> Result<[u32; 2], String> {
    let pair = text.split_once('x').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    let in_range = |[angles, rows]: &[u32; 2]| POLAR_ANGLES.contains(angles) && AZIMUTH_ROWS.contains(rows);
    pair.filter(in_range).ok_or_else(|| {
        let [angles, rows] = [POLAR_ANGLES, AZIMUTH_ROWS].map(|range| format!("{} to {}", range.start(), range.end()));
        format!("expected {angles} polar angles x {rows} rows of azimuths, such as 16x16")
    })
}
