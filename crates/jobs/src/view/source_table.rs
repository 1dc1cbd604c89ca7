//! What packs are held against: a source as a table that is larger than packs are.

use crate::encode::EncodeError;
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_formats::table::TablePack;
use brdfc_table::encode::encode;
use brdfc_table::recipe::{Size, TableRecipe};

/// Bytes of the table. Four times as many bring pictures of measured materials nearer to them by 0.03 ΔE at most.
const BYTES: u64 = 128 << 10;

/// The table, which notes its own error.
pub(super) fn source_table(source: &dyn Source, progress: &dyn Progress) -> Result<TablePack, EncodeError> {
    let recipe = TableRecipe { size: Size::Bytes(BYTES), ..TableRecipe::default() };
    Ok(encode(source, &recipe, progress)?.pack)
}
