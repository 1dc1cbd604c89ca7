//! Direction sets, as flags specify them.

use crate::Error;
use brdfc_core::words::quoted;
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::direction_list;
use brdfc_source::Input;
use brdfc_source::read::MAX_TEXT_BYTES;
use std::fmt::Display;
use std::path::Path;

/// Default direction set.
pub fn default_set() -> Input {
    "ubo2003".into()
}

/// Parses two numbers separated by an `x`.
fn pair(text: &str) -> Option<[u32; 2]> {
    let (a, b) = text.split_once('x')?;
    Some([a.parse().ok()?, b.parse().ok()?])
}

/// Resolves a direction set by name, or reads it from a file.
pub fn direction_set(option: &str, input: &Input) -> Result<DirectionSet, Error> {
    let text = input.path().and_then(Path::to_str).unwrap_or_default();
    let named = |set: DirectionSet, name: &str| DirectionSet { name: name.to_owned(), ..set };
    match text {
        "ubo2003" => return Ok(DirectionSet::ubo2003()),
        "ubo2014" => return Ok(DirectionSet::ubo2014()),
        _ => {}
    }
    let wrong = |found: &dyn Display, allowed: &str| {
        Error::wrong_usage(format!("--{option}"), quoted(&found.to_string()), allowed)
    };
    if let Some(grid) = text.strip_prefix("grid:") {
        let parsed = grid.split_once('@').and_then(|(size, angle)| Some((pair(size)?, angle.parse::<f64>().ok()?)));
        let Some(([zeniths, azimuths], angle)) = parsed else {
            let allowed = "grid:ZxA@DEGREES, such as grid:5x12@75";
            return Err(wrong(&text, allowed));
        };
        if zeniths == 1 {
            let allowed = "2 polar angles or more, because the first is the zenith";
            return Err(wrong(&text, allowed));
        }
        return DirectionSet::grid(zeniths as usize, azimuths as usize, angle)
            .map(|set| named(set, text))
            .map_err(|error| Error::usage(format!("--{option}: {error}")));
    }
    if !input.is_stdin() && input.extension()? != "csv" {
        let allowed = "ubo2003, ubo2014, grid:ZxA@DEGREES, a .csv file, or - for one from stdin";
        return Err(wrong(&input, allowed));
    }
    let bytes = input.read(MAX_TEXT_BYTES)?;
    direction_list::from_csv(&bytes)
        .map(|set| named(set, &input.short_name()))
        .map_err(|error| Error::input(format!("{input}: {error}")))
}

/// Describes an error of a recipe by the flags that set it.
pub fn by_flags(error: &FormatError) -> String {
    let FormatError { field, found, allowed, .. } = error;
    match field.as_ref() {
        "bytes of factors" => format!("--max-bytes: found {found}, expected {allowed}"),
        _ => error.to_string(),
    }
}
