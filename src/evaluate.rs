//! Values at given directions: `brdfc eval`.
//!
//! Materials and packs have `f_r` at direction pairs ([`values_at`]), flat BTFs and polynomial wavelet trees colours at places
//! ([`Relightable`]).

pub use brdfc_jobs::pwt::Relightable;
pub use brdfc_metrics::values::values_at;
pub use brdfc_readers::scan_csv::{TexelQuery, texels_from_bytes};

use crate::{DirectionPair, Error, Input, Material};
use brdfc_core::words::format_number;
use brdfc_readers::scan_csv::directions_from_bytes;
use brdfc_source::open::open;

/// Checks a level of detail before a pack says how many it has.
///
/// # Errors
/// One that no pack has.
pub fn check_level(level: Option<f32>) -> Result<(), Error> {
    match level {
        Some(level) if !(0.0..=64.0).contains(&level) => Err(wrong_level(level, "0 to the pack's number of levels")),
        _ => Ok(()),
    }
}

fn wrong_level(found: f32, allowed: &str) -> Error {
    Error::wrong_usage("lod", format_number(found), allowed)
}

/// Opens a material; a pack at a level of detail, 0 (coarsest) to its number of levels (finest, the default).
///
/// # Errors
/// As [`crate::open`]; a level that the pack does not have, or one of what is no pack.
pub fn open_level(input: impl Into<Input>, level: Option<f32>) -> Result<Material, Error> {
    check_level(level)?;
    let material = Material::new(open(input, level)?);
    match (level, material.facts().levels()) {
        (Some(level), Some(levels)) if level > levels as f32 => {
            Err(wrong_level(level, &format!("0 to {levels}, the pack's levels")))
        }
        (Some(level), None) => Err(wrong_level(level, "none: only packs have levels of detail")),
        _ => Ok(material),
    }
}

/// Parses direction pairs, a CSV with the columns `wi_x,wi_y,wi_z,wo_x,wo_y,wo_z`. Errors begin with `name`.
///
/// # Errors
/// Columns that are missing, and what is no number or unit vector, with its line.
pub fn pairs_from_csv(name: &Input, bytes: &[u8]) -> Result<Vec<DirectionPair>, Error> {
    let pairs = directions_from_bytes(bytes).map_err(|error| Error::input(format!("{name}: {error}")))?;
    Ok(pairs.into_iter().map(|(incoming, outgoing)| DirectionPair::new(incoming, outgoing)).collect())
}
