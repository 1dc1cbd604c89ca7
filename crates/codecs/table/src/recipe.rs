//! What decides the bytes of a table pack.

use brdfc_formats::crop::DirectionRange;
use brdfc_formats::table::Axes;

/// How large a table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// At most so many bytes on a GPU, of what is left where directions are cropped; how they are shared among the axes is chosen from the data.
    Bytes(u64),
    /// These nodes; a curve has as many as go with their number.
    Nodes(Axes),
}

/// What a table is to be close in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Aim {
    /// What is seen: ΔE of renderings.
    #[default]
    Renderings,
    /// Ratios, wherever they are: `ε_r`.
    Ratios,
}

/// Everything that decides the bytes of a table, besides the source.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TableRecipe {
    /// How large.
    pub size: Size,
    /// Whether a curve over `θ_h` stands beside the table: one fetch more.
    pub factored: bool,
    /// Levels of detail besides the finest, for surfaces whose bumps are smaller than a pixel: rows of the curve, which a
    /// pack with levels has in any case. 0 to [`MAX_LEVELS`](super::levels::MAX_LEVELS).
    pub levels: u32,
    /// What it is to be close in.
    pub aim: Aim,
    /// Whether values are the mean of both ways between light and viewer, as path tracers need it.
    pub reciprocal: bool,
    /// `ε` of the logarithm `ln(f / μ + ε)`.
    pub bias: f64,
    /// Directions that are needed: what no look-up within them touches is cropped, and errors are those within.
    pub directions: DirectionRange,
    /// Whether the error is measured. Without, what the pack says of it is 0.
    pub measure: bool,
    /// Whether texels are compressed in the file.
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
    /// Whether a curve stands beside the table.
    pub fn has_curve(&self) -> bool {
        self.factored || self.levels > 0
    }
}
