//! Facts about a wavelet pack, for reports.

use brdfc_codec::format_errors;
use brdfc_core::Describe;
use brdfc_core::words::bytes;
use brdfc_formats::ErrorSummary;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::WaveletPack;

/// Facts about a wavelet pack.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct WaveletPackFacts {
    /// Parameterisation of the two hemispheres.
    pub parameterisation: Parameterisation,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// Number of levels of detail.
    pub levels: u32,
    /// Finest level that holds slices.
    pub stored_levels: u32,
    /// True if each level of detail has a tree of its own, which preserves energy.
    pub energy_preserving: bool,
    /// Colour channels, 1 or 3.
    pub channels: u32,
    /// Bits per component.
    pub bits: u32,
    /// Number of retained slices, without the zero slice.
    pub slices_retained: usize,
    /// `μ` of the logarithm `ln(f / μ + ε)`, 1/sr.
    pub mean: f32,
    /// Bias `ε` of the logarithm.
    pub bias: f32,
    /// Directions of the pack and of its errors.
    pub directions: DirectionRange,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
    /// Codec error: decoded samples against the table that they were made from.
    pub on_grid: ErrorSummary,
    /// Errors of the filtered pack against its source at independent test directions.
    pub off_grid: ErrorSummary,
}

impl From<&WaveletPack> for WaveletPackFacts {
    fn from(pack: &WaveletPack) -> Self {
        let header = &pack.header;
        Self {
            parameterisation: header.parameterisation,
            grid: header.grid(),
            levels: header.levels,
            stored_levels: header.stored_levels,
            energy_preserving: header.energy_preserving,
            channels: header.channels,
            bits: header.bits,
            slices_retained: pack.retained(),
            mean: header.mean,
            bias: header.bias,
            directions: pack.directions(),
            gpu_bytes: pack.gpu_bytes(),
            on_grid: pack.on_grid,
            off_grid: pack.off_grid,
        }
    }
}

impl Describe for WaveletPackFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        let Self {
            parameterisation,
            grid,
            levels,
            stored_levels,
            energy_preserving,
            channels,
            bits,
            slices_retained,
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
                    if *energy_preserving { ", energy-preserving" } else { "" }
                ),
            ),
            ("texels", format!("{channels} channel{}, {bits} bits", if *channels == 1 { "" } else { "s" })),
            ("slices", format!("{slices_retained} of {}", grid * grid)),
            ("mean μ, bias ε", format!("{mean} 1/sr, {bias}")),
            ("bytes on a GPU", bytes(*gpu_bytes)),
            ("error on the grid (codec)", format_errors(on_grid)),
            ("error at test directions (against source)", format_errors(off_grid)),
        ]
    }

    fn samples(&self) -> u64 {
        (self.grid * self.grid * self.slices_retained) as u64
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }

    fn levels(&self) -> Option<u32> {
        Some(self.levels)
    }
}
