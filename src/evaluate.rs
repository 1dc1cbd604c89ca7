//! Evaluation at given directions: `brdfc eval`.
//!
//! Materials and packs have `f_r` at direction pairs ([`values_at`]); flat BTFs and polynomial wavelet trees have colours at
//! positions ([`Relightable`]).

pub use brdfc_jobs::pwt::Relightable;
pub use brdfc_metrics::values::values_at;
pub use brdfc_readers::scan_csv::{Body, TexelQuery, texels_from_bytes};

use crate::{DirectionPair, Error, Input, Material, Reading, open_with};
use brdfc_core::words::format_number;
use brdfc_readers::scan_csv::directions_from_bytes;

/// Checks a level of detail before the pack is known.
///
/// # Errors
/// Returns an error if no pack has such a level.
pub fn check_level(level: Option<f32>) -> Result<(), Error> {
    match level {
        Some(level) if !(0.0..=64.0).contains(&level) => Err(wrong_level(level, "0 to the pack's number of levels")),
        _ => Ok(()),
    }
}

fn wrong_level(found: f32, allowed: &str) -> Error {
    Error::wrong_usage("lod", format_number(found), allowed)
}

/// Opens a material, or a pack at a level of detail from 0 (coarsest) to its number of levels (finest, the default).
///
/// # Errors
/// Returns the errors of [`crate::open`], and one for a level that the pack does not have or an input that is not a pack.
pub fn open_level(input: impl Into<Input>, reading: impl Into<Reading>) -> Result<Material, Error> {
    let reading = reading.into();
    let level = reading.level;
    check_level(level)?;
    let material = open_with(input, reading)?;
    match (level, material.facts().levels()) {
        (Some(level), Some(0)) if level > 0.0 => Err(Error::usage("lod: the pack has one level; omit the option")),
        (Some(level), Some(levels)) if level > levels as f32 => {
            Err(wrong_level(level, &format!("0 to {levels}, the pack's levels")))
        }
        (Some(_), None) => Err(Error::usage("lod does not apply to this input, only to packs with levels of detail")),
        _ => Ok(material),
    }
}

/// Parses direction pairs from a CSV with the columns `wi_x,wi_y,wi_z,wo_x,wo_y,wo_z`. Errors begin with `name`.
///
/// # Errors
/// Returns an error with the line if a column is missing or a value is not a number or not part of a unit vector.
pub fn pairs_from_csv(name: &Input, bytes: &[u8]) -> Result<Vec<DirectionPair>, Error> {
    let pairs = directions_from_bytes(bytes).map_err(|error| Error::input(format!("{name}: {error}")))?;
    Ok(pairs.into_iter().map(|(incoming, outgoing)| DirectionPair::new(incoming, outgoing)).collect())
}
