//! Facts about a table pack, for reports.

use brdfc_codec::format_errors;
use brdfc_core::Describe;
use brdfc_core::words::bytes;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::table::{Axes, TablePack, TableSymmetry};
use brdfc_formats::{ErrorSummary, RenderingSummary};

/// Facts about a table pack.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct TablePackFacts {
    /// Number of nodes along each axis.
    pub axes: Axes,
    /// Symmetries that fold its nodes.
    pub folded: TableSymmetry,
    /// Number of nodes of the curve over `θ_h` in factored packs, otherwise 0.
    pub curve_nodes: usize,
    /// Number of levels of detail below the finest.
    pub levels: u32,
    /// Colour channels, 1 or 3.
    pub channels: u32,
    /// `μ` of the logarithm `ln(f / μ + ε)`, 1/sr.
    pub mean: f32,
    /// Bias `ε` of the logarithm.
    pub bias: f32,
    /// Filtered fetches per look-up.
    pub fetches: u32,
    /// Directions of the pack and of its errors.
    pub directions: DirectionRange,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
    /// Errors of the filtered pack against its source at independent test directions.
    pub off_grid: ErrorSummary,
    /// ΔE (CIE76) between renderings of the pack and of its source.
    pub rendering: RenderingSummary,
}

impl From<&TablePack> for TablePackFacts {
    fn from(pack: &TablePack) -> Self {
        let header = pack.header();
        Self {
            axes: header.axes,
            folded: header.symmetry,
            channels: header.channels,
            mean: header.mean,
            bias: header.bias,
            curve_nodes: pack.curve().map_or(0, |curve| curve.nodes()),
            levels: pack.levels(),
            fetches: pack.fetches(),
            directions: pack.directions(),
            gpu_bytes: pack.gpu_bytes(),
            off_grid: pack.off_grid,
            rendering: pack.rendering,
        }
    }
}

impl Describe for TablePackFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self {
            axes,
            folded,
            curve_nodes,
            levels,
            channels,
            mean,
            bias,
            fetches,
            directions: _,
            gpu_bytes,
            off_grid,
            rendering,
        } = self;
        vec![
            ("kind", if *curve_nodes > 0 { "factored table pack" } else { "table pack" }.to_owned()),
            ("nodes", format_nodes(axes, *curve_nodes)),
            ("symmetry", format_symmetry(*folded)),
            ("levels of detail", format_levels(*levels)),
            ("texels", if *channels == 1 { "1 channel, halves" } else { "3 channels, 10 bits" }.to_owned()),
            ("mean μ, bias ε", format!("{mean} 1/sr, {bias}")),
            ("bytes on a GPU", bytes(*gpu_bytes)),
            ("filtered fetches", fetches.to_string()),
            ("error at test directions (against source)", format_errors(off_grid)),
            (
                "ΔE of renderings",
                format!("mean {:.2}, 95 %: {:.2}, largest: {:.1}", rendering.mean, rendering.p95, rendering.max),
            ),
        ]
    }

    fn samples(&self) -> u64 {
        let Axes { half, difference, azimuth, layers } = self.axes;
        [half, difference, azimuth, layers].into_iter().map(u64::from).product()
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }

    fn levels(&self) -> Option<u32> {
        Some(self.levels)
    }
}

fn format_nodes(axes: &Axes, curve_nodes: usize) -> String {
    let Axes { half, difference, azimuth, layers } = axes;
    let layers = if *layers == 1 { String::new() } else { format!(" x {layers} (φ_h)") };
    let curve = if curve_nodes == 0 { String::new() } else { format!(", and {curve_nodes} of a curve over θ_h") };
    format!("{half} (θ_h) x {difference} (θ_d) x {azimuth} (φ_d){layers}{curve}")
}

fn format_levels(levels: u32) -> String {
    if levels == 0 { "one".to_owned() } else { format!("0 to {levels}, the finest") }
}

fn format_symmetry(symmetry: TableSymmetry) -> String {
    let flags = [
        (symmetry.reciprocal, "reciprocal"),
        (symmetry.mirror, "mirror"),
        (symmetry.half_turn, "half turn"),
        (symmetry.reflected, "reflected at the tangent"),
    ];
    let found: Vec<&str> = flags.into_iter().filter(|(holds, _)| *holds).map(|(_, name)| name).collect();
    if found.is_empty() { "none".to_owned() } else { found.join(", ") }
}
