//! What is worth knowing about packs.

use crate::format::Describe;
use brdfc_core::words::{bytes, percent};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::table::{Axes, TableSymmetry};
use brdfc_formats::{ErrorSummary, PictureSummary};

/// What is worth knowing of a wavelet pack.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct WaveletPackFacts {
    /// What the two hemispheres are.
    pub parameterisation: Parameterisation,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// Levels of detail.
    pub levels: u32,
    /// Finest level that holds slices.
    pub stored_levels: u32,
    /// Whether coarser levels and slices that are left out keep the light.
    pub lifted: bool,
    /// 1 or 3.
    pub channels: u32,
    /// Bits per component.
    pub bits: u32,
    /// Slices kept, the zero slice not counted.
    pub slices_kept: usize,
    /// `μ`, 1/sr.
    pub mean: f32,
    /// `ε`.
    pub bias: f32,
    /// Directions that it is for, and that its errors are of.
    pub directions: DirectionRange,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
    /// Codec error: decoded samples against the table they were made from.
    pub on_grid: ErrorSummary,
    /// The filtered pack against its source at direction pairs that depend on no grid.
    pub off_grid: ErrorSummary,
}

/// What is worth knowing of a table pack.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct TablePackFacts {
    /// Nodes per axis.
    pub axes: Axes,
    /// Symmetries that its nodes are folded by.
    pub folded: TableSymmetry,
    /// Nodes of the curve over `θ_h` that factored packs have, otherwise 0.
    pub curve_nodes: usize,
    /// Levels of detail besides the finest.
    pub levels: u32,
    /// 1 or 3.
    pub channels: u32,
    /// `μ`, 1/sr.
    pub mean: f32,
    /// `ε`.
    pub bias: f32,
    /// Filtered fetches of a look-up.
    pub fetches: u32,
    /// Directions that it is for, and that its errors are of.
    pub directions: DirectionRange,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
    /// The filtered pack against its source at direction pairs that depend on no grid.
    pub off_grid: ErrorSummary,
    /// Pictures of both: ΔE*ab.
    pub picture: PictureSummary,
}

impl Describe for WaveletPackFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self {
            parameterisation,
            grid,
            levels,
            stored_levels,
            lifted,
            channels,
            bits,
            slices_kept,
            mean,
            bias,
            directions: _,
            gpu_bytes,
            on_grid,
            off_grid,
        } = self;
        vec![
            ("kind", "wavelet pack".to_owned()),
            ("grid", format!("{grid} x {grid} per hemisphere, {}", parameterisation.name())),
            (
                "levels of detail",
                format!(
                    "{levels}, stored up to {stored_levels}{}",
                    if *lifted { ", which keep the light" } else { "" }
                ),
            ),
            ("texels", format!("{channels} channel{}, {bits} bits", if *channels == 1 { "" } else { "s" })),
            ("slices kept", format!("{slices_kept} of {}", grid * grid)),
            ("mean μ, bias ε", format!("{mean} 1/sr, {bias}")),
            ("bytes on a GPU", bytes(*gpu_bytes)),
            ("error on the grid (codec)", errors_in_words(on_grid)),
            ("error off the grid (against the source)", errors_in_words(off_grid)),
        ]
    }

    fn samples(&self) -> u64 {
        (self.grid * self.grid * self.slices_kept) as u64
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }

    fn levels(&self) -> Option<u32> {
        Some(self.levels)
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
            picture,
        } = self;
        vec![
            ("kind", if *curve_nodes > 0 { "factored table pack" } else { "table pack" }.to_owned()),
            ("nodes", nodes_in_words(axes, *curve_nodes)),
            ("symmetry", symmetry_in_words(*folded)),
            ("levels of detail", levels_in_words(*levels)),
            ("texels", if *channels == 1 { "1 channel, halves" } else { "3 channels, 10 bits" }.to_owned()),
            ("mean μ, bias ε", format!("{mean} 1/sr, {bias}")),
            ("bytes on a GPU", bytes(*gpu_bytes)),
            ("filtered fetches", fetches.to_string()),
            ("error off the grid (against the source)", errors_in_words(off_grid)),
            (
                "ΔE of pictures",
                format!("mean {:.2}, 95 %: {:.2}, largest: {:.1}", picture.mean, picture.p95, picture.max),
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

fn nodes_in_words(axes: &Axes, curve_nodes: usize) -> String {
    let Axes { half, difference, azimuth, layers } = axes;
    let layers = if *layers == 1 { String::new() } else { format!(" x {layers} (φ_h)") };
    let curve = if curve_nodes == 0 { String::new() } else { format!(", and {curve_nodes} of a curve over θ_h") };
    format!("{half} (θ_h) x {difference} (θ_d) x {azimuth} (φ_d){layers}{curve}")
}

fn levels_in_words(levels: u32) -> String {
    if levels == 0 { "one".to_owned() } else { format!("0 to {levels}, the finest") }
}

fn symmetry_in_words(symmetry: TableSymmetry) -> String {
    let flags = [
        (symmetry.reciprocal, "reciprocal"),
        (symmetry.mirror, "mirror"),
        (symmetry.half_turn, "half turn"),
        (symmetry.reflected, "reflected at the tangent"),
    ];
    let found: Vec<&str> = flags.into_iter().filter(|(holds, _)| *holds).map(|(_, name)| name).collect();
    if found.is_empty() { "none".to_owned() } else { found.join(", ") }
}

fn errors_in_words(errors: &ErrorSummary) -> String {
    let ratio = |value: f32| percent(f64::from(value));
    format!(
        "ε_r {} (95 %: {}, 99 %: {}, largest: {}), ε {:.3e} 1/sr, reciprocity {}",
        ratio(errors.relative_mean),
        ratio(errors.relative_p95),
        ratio(errors.relative_p99),
        ratio(errors.relative_max),
        errors.rms,
        ratio(errors.reciprocity)
    )
}
