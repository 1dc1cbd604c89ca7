//! A pack of either codec, with what was measured.

use super::averaged::AveragingCost;
use super::trial::Trial;
use brdfc_core::Tally;
use brdfc_formats::BrdfPack;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::table::{Axes, TableSymmetry};
use brdfc_metrics::compare::Comparison;
use brdfc_table::symmetry::Asymmetry;
use brdfc_wavelet::measure::GridError;
use brdfc_wavelet::recipe::Recipe;
use serde::{Deserialize, Serialize};

/// A pack with what was measured while making it.
#[derive(Debug, Clone)]
pub struct EncodedPack {
    /// The pack.
    pub pack: BrdfPack,
    /// Bytes on a GPU that it has less than one for all directions.
    pub cropped_bytes: u64,
    /// The file.
    pub bytes: Vec<u8>,
    /// What its codec says.
    pub codec: CodecReport,
    /// Error against the source, at pairs and in pictures that depend on no codec.
    pub off_grid: Comparison,
    /// Values of the source that it was made from.
    pub evaluated: u64,
    /// What had to be mended in them.
    pub tally: Tally,
    /// What it costs that values are the same from both sides, where that was asked for.
    pub averaging: Option<AveragingCost>,
    /// What was tried, from coarse to fine; empty where the recipe says what to make.
    pub tried: Vec<Trial>,
    /// What nothing that was tried meets: then this is the best of them.
    pub missed: Option<String>,
    /// Where a search was within a range of directions: bytes on a GPU of what meets the same limits over all directions, if
    /// that was looked for and found.
    pub of_all_directions: Option<u64>,
}

impl EncodedPack {
    /// What is told of it where it was tried.
    pub(super) fn trial(&self, meets: bool) -> Trial {
        let picture = &self.off_grid.picture.delta_e;
        Trial {
            codec: self.codec.name().to_owned(),
            size: self.codec.size(),
            bytes_on_gpu: self.pack.gpu_bytes(),
            fetches: self.pack.fetches(),
            delta_e: picture.mean,
            delta_e_p95: picture.p95,
            relative_error: self.off_grid.norms.relative_mean,
            meets,
        }
    }
}

/// What is worth knowing of a pack, by its codec.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CodecReport {
    /// A table pack, plain or factored.
    Table(TableReport),
    /// A wavelet pack.
    Wavelet(WaveletReport),
}

/// Of a table pack.
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

/// Of a wavelet pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct WaveletReport {
    /// What the two hemispheres of the table are.
    pub parameterisation: Parameterisation,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// Finest level of detail that is stored.
    pub stored_levels: u32,
    /// Bits per component.
    pub bits: u32,
    /// Whether coarser levels and slices that are left out keep the light.
    pub lifted: bool,
    /// Whether the table was smoothed.
    pub smoothed: bool,
    /// Slices kept, the zero slice not counted.
    pub slices_kept: usize,
    /// Wavelet coefficients, of which a slice each would be kept at 1:1.
    pub slices_in_all: usize,
    /// `slices_in_all / slices_kept`.
    pub ratio: f64,
    /// Codec error: decoded table against table.
    pub on_grid: GridError,
}

impl CodecReport {
    /// What the codec is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Table(table) if table.curve_nodes > 0 => "factored",
            Self::Table(_) => "table",
            Self::Wavelet(_) => "wavelet",
        }
    }

    /// How large the pack is, in the codec's own units.
    pub fn size(&self) -> String {
        match self {
            Self::Table(table) => {
                let curve = if table.curve_nodes == 0 { String::new() } else { format!(" + {}", table.curve_nodes) };
                format!("{}{curve}", table.axes)
            }
            Self::Wavelet(wavelet) => format!("{}/{} slices", wavelet.slices_kept, wavelet.slices_in_all),
        }
    }
}

pub(super) fn of_table(encoded: brdfc_table::encode::Encoded) -> EncodedPack {
    let header = encoded.pack.header();
    let curve_nodes = encoded.pack.curve().map_or(0, |curve| curve.nodes());
    let codec = TableReport { axes: header.axes, curve_nodes, symmetry: header.symmetry, asymmetry: encoded.asymmetry };
    EncodedPack {
        codec: CodecReport::Table(codec),
        cropped_bytes: encoded.pack.cropped_bytes(),
        pack: BrdfPack::Table(encoded.pack),
        bytes: encoded.bytes,
        off_grid: encoded.off_grid,
        evaluated: encoded.tally.evaluations,
        tally: encoded.tally,
        averaging: None,
        tried: Vec::new(),
        missed: None,
        of_all_directions: None,
    }
}

pub(super) fn of_wavelet(encoded: brdfc_wavelet::encode::Encoded, recipe: &Recipe) -> EncodedPack {
    let header = &encoded.pack.header;
    let slices_kept = encoded.pack.slices() - 1;
    let codec = WaveletReport {
        parameterisation: header.parameterisation,
        grid: header.grid(),
        stored_levels: header.stored_levels,
        bits: header.bits,
        lifted: header.lifted,
        smoothed: recipe.smooth,
        slices_kept,
        slices_in_all: header.cells(),
        ratio: header.cells() as f64 / slices_kept as f64,
        on_grid: encoded.on_grid,
    };
    EncodedPack {
        codec: CodecReport::Wavelet(codec),
        cropped_bytes: encoded.cropped_bytes,
        pack: BrdfPack::Wavelet(encoded.pack),
        bytes: encoded.bytes,
        off_grid: encoded.off_grid,
        evaluated: encoded.evaluated,
        tally: encoded.tally,
        averaging: None,
        tried: Vec::new(),
        missed: None,
        of_all_directions: None,
    }
}
