//! Recipe of a table pack.

use brdfc_formats::crop::DirectionRange;
use brdfc_formats::table::Axes;

/// Size of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// Maximum number of bytes on a GPU, after cropping; the data decide the sizes of the axes.
    Bytes(u64),
    /// These nodes; a curve gets a number of nodes in proportion.
    Nodes(Axes),
}

/// Error measure that a table minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Aim {
    /// Visible error: ΔE of renderings.
    #[default]
    Renderings,
    /// Relative error, `ε_r`.
    Ratios,
}

/// Everything besides the source that decides the bytes of a table.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TableRecipe {
    /// Size of the table.
    pub size: Size,
    /// True if the pack has a curve over `θ_h` as well as the table, with one more fetch.
    pub factored: bool,
    /// Number of levels of detail below the finest, for surfaces with bumps smaller than a pixel: rows of the curve,
    /// which packs with levels always have. 0 to [`MAX_LEVELS`](super::levels::MAX_LEVELS).
    pub levels: u32,
    /// Error measure to minimise.
    pub aim: Aim,
    /// True if values are symmetrised (the mean over both orders of light and viewer), as path tracers need them.
    pub reciprocal: bool,
    /// `ε` of the logarithm `ln(f / μ + ε)`.
    pub bias: f64,
    /// Directions that the pack covers. Texels that no look-up within this range reads are cropped, and errors are
    /// measured within the range.
    pub directions: DirectionRange,
    /// True if the error is measured. Otherwise the pack stores an error of 0.
    pub measure: bool,
    /// True if texels are compressed in the file.
    pub supercompress: bool,
}

impl Default for TableRecipe {
    /// 16 KiB.
    fn default() -> Self {
        Self {
            size: Size::Bytes(16 << 10),
            factored: false,
            levels: 0,
            aim: Aim::Renderings,
            reciprocal: false,
            bias: 1e-4,
            directions: DirectionRange::ALL,
            measure: true,
            supercompress: true,
        }
    }
}

impl TableRecipe {
    /// Returns true if the pack has a curve.
    pub fn has_curve(&self) -> bool {
        self.factored || self.levels > 0
    }
}
