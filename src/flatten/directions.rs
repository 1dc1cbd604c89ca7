//! Sets of directions, as flags name them.

use crate::CliError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::direction_list;
use brdfc_source::Input;
use brdfc_source::read::MAX_TEXT_BYTES;
use std::path::Path;

/// The set where none is named.
pub(crate) fn default_set() -> Input {
    "ubo2003".into()
}

/// Two numbers with an `x` between them.
pub(super) fn pair(text: &str) -> Option<[u32; 2]> {
    let (a, b) = text.split_once('x')?;
    Some([a.parse().ok()?, b.parse().ok()?])
}

/// A set of directions by its name, or from a file.
pub(crate) fn direction_set(option: &str, input: &Input) -> Result<DirectionSet, CliError> {
    let text = input.path().and_then(Path::to_str).unwrap_or_default();
    let named = |set: DirectionSet, name: &str| DirectionSet { name: name.to_owned(), ..set };
    match text {
        "ubo2003" => return Ok(DirectionSet::ubo2003()),
        "ubo2014" => return Ok(DirectionSet::ubo2014()),
        _ => {}
    }
    if let Some(grid) = text.strip_prefix("grid:") {
        let parsed = grid.split_once('@').and_then(|(size, angle)| Some((pair(size)?, angle.parse::<f64>().ok()?)));
        let Some(([zeniths, azimuths], angle)) = parsed else {
            let allowed = "grid:ZxA@DEGREES, such as grid:5x12@75";
            return Err(CliError::Usage(format!("--{option}: found {text}; allowed {allowed}")));
        };
        if zeniths == 1 {
            let allowed = "2 polar angles or more: the first is the zenith, to which azimuths and DEGREES say nothing";
            return Err(CliError::Usage(format!("--{option}: found {text}; allowed {allowed}")));
        }
        return DirectionSet::grid(zeniths as usize, azimuths as usize, angle)
            .map(|set| named(set, text))
            .map_err(|error| CliError::Usage(format!("--{option}: {error}")));
    }
    if !input.is_stdin() && input.extension()? != "csv" {
        let allowed = "ubo2003, ubo2014, grid:ZxA@DEGREES, a .csv file, or - for one from stdin";
        return Err(CliError::Usage(format!("--{option}: found {input}; allowed {allowed}")));
    }
    let bytes = input.read(MAX_TEXT_BYTES)?;
    direction_list::from_csv(&bytes)
        .map(|set| named(set, &input.short_name()))
        .map_err(|error| CliError::Input(format!("{input}: {error}")))
}
