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

/// Opens a material; a pack at a level of detail, 0 (coarsest) to its number of levels (finest, the default).
///
/// # Errors
/// As [`crate::open`]; a level that the pack does not have, or one of what is no pack.
pub fn open_level(input: impl Into<Input>, level: Option<f32>) -> Result<Material, Error> {
    let wrong =
        |found: f32, allowed: String| Error::usage(format!("lod: found {}; allowed {allowed}", format_number(found)));
    if let Some(level) = level.filter(|level| !(*level >= 0.0)) {
        return Err(wrong(level, "0 to the pack's number of levels".to_owned()));
    }
    let material = Material::new(open(input, level)?);
    match (level, material.facts().levels()) {
        (Some(level), Some(levels)) if level > levels as f32 => {
            Err(wrong(level, format!("0 to {levels}, the pack's levels")))
        }
        (Some(level), None) => Err(wrong(level, "none: only packs have levels of detail".to_owned())),
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
