//! What decides the bytes of a table pack.

use brdfc_formats::table::Axes;

/// How large a table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// At most so many bytes on a GPU; how they are shared among the axes is chosen from the data.
    Bytes(u64),
    /// These nodes; a curve has as many as go with their number.
    Nodes(Axes),
}

/// Everything that decides the bytes of a table pack, besides the source.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TableRecipe {
    /// How large.
    pub size: Size,
    /// Whether a curve over `θ_h` stands beside the table: one fetch more.
    pub factored: bool,
    /// Whether values are the mean of both ways between light and viewer, as path tracers need it.
    pub reciprocal: bool,
    /// `ε` of the logarithm `ln(f / μ + ε)`.
    pub bias: f64,
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
            reciprocal: false,
            bias: 1e-4,
            measure: true,
            supercompress: true,
        }
    }
}
