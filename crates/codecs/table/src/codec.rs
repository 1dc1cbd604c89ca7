//! Table packs among the codecs of BRDFs.

use super::encode::{self, encode};
use super::levels::MOST_LEVELS;
use super::recipe::{Size, TableRecipe};
use super::symmetry::Asymmetry;
use brdfc_codec::{
    AveragingCost, BrdfRecipe, BrdfReport, Encode, EncodeError, EncodeOptions, Encoded, GridCache, OptionError,
    Predicted, Variant,
};
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_core::words::bytes;
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::table::{Axes, TableSymmetry};
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use serde::{Deserialize, Serialize};

/// The variant without a curve; the name of the codec, too.
const TABLE: &str = "table";
/// The variant with a curve.
const FACTORED: &str = "factored";

/// Memory of an encoding without its source, bytes; measured with a scan.
const MEMORY: u64 = 40 << 20;

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

impl BrdfRecipe for TableRecipe {
    fn codec(&self) -> &'static str {
        TABLE
    }

    fn target(&self) -> String {
        match self.size {
            Size::Bytes(most) => format!("at most {}", bytes(most)),
            Size::Nodes(axes) => format!("{} x {} x {} x {}", axes.half, axes.difference, axes.azimuth, axes.layers),
        }
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }

    fn limit_directions(&mut self, directions: DirectionRange) {
        self.directions = directions;
    }

    fn has_fixed_size(&self) -> bool {
        matches!(self.size, Size::Nodes(_))
    }

    fn limits_error(&self) -> bool {
        false
    }

    fn skip_measuring(&mut self) {
        self.measure = false;
    }

    fn set_supercompress(&mut self, supercompress: bool) {
        self.supercompress = supercompress;
    }

    fn coarser_levels(&self) -> u32 {
        self.levels
    }

    fn limit_coarser_levels(&mut self, most: u32) {
        self.levels = self.levels.min(most);
    }

    fn memory(&self) -> u64 {
        MEMORY
    }

    fn predict(&self) -> Predicted {
        match self.size {
            Size::Bytes(most) => Predicted { least: 0, most },
            Size::Nodes(axes) => {
                // Where a table does not start again, it has one slice less; grey texels have half the bytes.
                let texels = |azimuth: u32| u64::from(axes.half * axes.difference * azimuth * axes.layers);
                Predicted { least: 2 * texels(axes.azimuth), most: 4 * texels(axes.azimuth + 1) }
            }
        }
    }
}

/// Options of plain tables.
const OPTIONS: [&str; 6] = ["max_delta_e", "max_error", "max_bytes", "max_fetches", "reciprocal", "bias"];
/// Those of tables with a curve, and of a search.
const FACTORED_OPTIONS: [&str; 7] =
    ["max_delta_e", "max_error", "max_bytes", "max_fetches", "reciprocal", "bias", "levels"];

impl TableRecipe {
    /// The variant that a search chooses.
    pub const AUTO: &str = "auto";
}

impl Encode for TableRecipe {
    type Report = TableReport;

    const VARIANTS: &'static [Variant] = &[
        Variant { name: Self::AUTO, options: &FACTORED_OPTIONS },
        Variant { name: TABLE, options: &OPTIONS },
        Variant { name: FACTORED, options: &FACTORED_OPTIONS },
    ];

    fn from_options(variant: &str, options: &EncodeOptions) -> Result<Self, OptionError> {
        let default = Self::default();
        let levels = options.levels.unwrap_or(0);
        if levels > MOST_LEVELS {
            return Err(EncodeOptions::out_of_range("levels", levels.to_string()));
        }
        Ok(Self {
            size: options.max_bytes.map_or(default.size, Size::Bytes),
            factored: variant == FACTORED,
            levels,
            reciprocal: options.reciprocal == Some(true),
            bias: options.bias()?.unwrap_or(default.bias),
            ..default
        })
    }

    fn encode(
        &self,
        source: &dyn Source,
        _: &dyn GridCache,
        progress: &dyn Progress,
    ) -> Result<Encoded<TableReport>, EncodeError> {
        let mut made: Encoded<TableReport> = encode(source, self, progress)?.into();
        if self.reciprocal && self.measure {
            let reference = Reference::new(source, PairSet::within(self.directions));
            made.averaging = Some(AveragingCost::of(source, &reference));
        }
        Ok(made)
    }
}
