//! What is reported of a table pack.

use super::encode;
use super::symmetry::Asymmetry;
use brdfc_codec::{BrdfReport, Encoded};
use brdfc_formats::BrdfPack;
use brdfc_formats::table::{Axes, TableSymmetry};
use serde::{Deserialize, Serialize};

/// The variant without a curve.
pub(super) const TABLE: &str = "table";
/// The variant with a curve.
pub(super) const FACTORED: &str = "factored";

/// The report of a table pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct TableReport {
    /// Nodes per axis.
    pub axes: Axes,
    /// Nodes of the curve over `θ_h` of a factored pack, otherwise 0.
    pub curve_nodes: usize,
    /// What was folded.
    pub symmetry: TableSymmetry,
    /// How far the source is from each symmetry.
    pub asymmetry: Asymmetry,
}

impl BrdfReport for TableReport {
    fn variant(&self) -> &'static str {
        if self.curve_nodes > 0 { FACTORED } else { TABLE }
    }

    fn size(&self) -> String {
        let curve = if self.curve_nodes == 0 { String::new() } else { format!(" + {}", self.curve_nodes) };
        format!("{}{curve}", self.axes)
    }
}

impl From<encode::Encoded> for Encoded<TableReport> {
    fn from(encoded: encode::Encoded) -> Self {
        let encode::Encoded { pack, bytes, asymmetry, off_grid, tally } = encoded;
        let (axes, symmetry) = (pack.header().axes, pack.header().symmetry);
        let curve_nodes = pack.curve().map_or(0, |curve| curve.nodes());
        let cropped_bytes = pack.cropped_bytes();
        let report = TableReport { axes, curve_nodes, symmetry, asymmetry };
        Self { cropped_bytes, ..Self::new(BrdfPack::Table(pack), bytes, report, off_grid, tally) }
    }
}
