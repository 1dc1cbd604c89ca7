//! Values at given directions: `brdfc eval`.
//!
//! Materials and packs have `f_r` at direction pairs ([`values_at`]), flat BTFs and polynomial wavelet trees colours at places
//! ([`Relightable`]).

pub use brdfc_jobs::pwt::Relightable;
pub use brdfc_metrics::values::values_at;
pub use brdfc_readers::scan_csv::{TexelQuery, texels_from_bytes};

use crate::{DirectionPair, Error, Input, Material};
use brdfc_readers::scan_csv::directions_from_bytes;
use brdfc_source::open::open;

/// Opens a material; a pack at a level of detail, 0 (coarsest) to its number of levels (finest, the default).
///
/// # Errors
/// As [`crate::open`].
pub fn open_level(input: impl Into<Input>, level: Option<f32>) -> Result<Material, Error> {
    Ok(Material::new(open(input, level)?))
}

/// Parses direction pairs, a CSV with the columns `wi_x,wi_y,wi_z,wo_x,wo_y,wo_z`. Errors begin with `name`.
///
/// # Errors
/// Columns that are missing, and what is no number or unit vector, with its line.
pub fn pairs_from_csv(name: &Input, bytes: &[u8]) -> Result<Vec<DirectionPair>, Error> {
    let pairs = directions_from_bytes(bytes).map_err(|error| Error::input(format!("{name}: {error}")))?;
    Ok(pairs.into_iter().map(|(incoming, outgoing)| DirectionPair::new(incoming, outgoing)).collect())
}
