//! Direction sets and indirection maps, as flags specify them.

use crate::Error;
use brdfc_core::words::{format_number, quoted};
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{IndirectionHeader, MAX_AZIMUTH_SAMPLES, MAX_ZENITH_SAMPLES};
use brdfc_readers::direction_list;
use brdfc_source::Input;
use brdfc_source::read::MAX_TEXT_BYTES;
use std::fmt::Display;
use std::path::Path;

/// Default views of the indirection map. Azimuths are as close as in `ubo2003` at its largest polar angle, where
/// blending views loses most.
pub const INDIRECTION: &str = "16x24";

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

fn wrong_indirection(text: &str) -> Error {
    Error::wrong_usage("--indirection", quoted(text), "polar angles x azimuths, such as 16x24")
}

/// Makes the header of the indirection map for `--texels`, `--indirection` and `--largest-angle` (in degrees).
pub fn map_header(texels: u32, indirection: &str, largest_angle: f64) -> Result<IndirectionHeader, Error> {
    if !(largest_angle > 0.0 && largest_angle <= 89.0) {
        return Err(Error::wrong_usage("--largest-angle", format_number(largest_angle), "above 0, up to 89 degrees"));
    }
    let [zenith_samples, azimuth_samples] = pair(indirection).ok_or_else(|| wrong_indirection(indirection))?;
    let largest_angle = largest_angle.to_radians() as f32;
    let header = IndirectionHeader { size: texels, zenith_samples, azimuth_samples, largest_angle };
    if !(2..=MAX_ZENITH_SAMPLES).contains(&zenith_samples) || !(3..=MAX_AZIMUTH_SAMPLES).contains(&azimuth_samples) {
        let allowed = format!("2 to {MAX_ZENITH_SAMPLES} polar angles x 3 to {MAX_AZIMUTH_SAMPLES} azimuths");
        return Err(Error::wrong_usage("--indirection", indirection, allowed));
    }
    Ok(header)
}

/// Describes an error of a recipe by the flags that set it.
pub fn by_flags(error: &FormatError) -> String {
    let FormatError { field, found, allowed, .. } = error;
    match field.as_ref() {
        "bytes of factors" => format!("--max-bytes: found {found}, expected {allowed}"),
        "size of the part displacement" | "size of the part indirection" => format!(
            "--texels x --indirection: found a map of {found} texels, expected {allowed}; lower --texels or --indirection"
        ),
        _ => error.to_string(),
    }
}
