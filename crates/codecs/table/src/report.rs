//! Report of a table pack.

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
    /// Number of nodes along each axis.
    pub axes: Axes,
    /// Number of nodes of the curve over `θ_h` in a factored pack, otherwise 0.
    pub curve_nodes: usize,
    /// Symmetries that fold the nodes.
    pub symmetry: TableSymmetry,
    /// Deviation of the source from each symmetry.
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
