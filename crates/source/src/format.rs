//! What a kind of file that has reflectance is to the one who opens it.

use super::error::InputError;
use super::input::InputFile;
use super::scan::{ScanSummary, StrayRows};
use brdfc_core::Source;
use brdfc_core::words::{bytes, percent};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::table::{Axes, TableSymmetry};
use brdfc_formats::{ErrorSummary, PictureSummary};

/// What kind of input it is, with what is worth knowing about it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Facts {
    /// An analytic model.
    Synth {
        /// The address with all parameters.
        address: String,
    },
    /// A MERL table.
    Merl {
        /// Samples along theta_h, theta_d and phi_d.
        dimensions: [usize; 3],
        /// Cells with a measurement.
        valid_cells: usize,
        /// Cells without.
        invalid_cells: usize,
    },
    /// A scattered scan.
    Scan {
        /// Wavelengths in nm; empty for RGB columns.
        wavelengths: Vec<f64>,
        /// What the header of an ALTA table says; absent for other scans.
        #[serde(skip_serializing_if = "Option::is_none")]
        alta: Option<AltaHeader>,
        /// Counts.
        #[serde(flatten)]
        summary: ScanSummary,
    },
    /// An RGL material.
    Rgl {
        /// What the file says of itself.
        description: String,
        /// Incoming azimuths measured.
        azimuths: usize,
        /// Incoming polar angles measured.
        polar_angles: usize,
        /// Rows and columns of the colour tensor per incoming direction.
        resolution: [usize; 2],
        /// Colour channels or wavelengths in the file.
        channels: usize,
    },
    /// A wavelet pack.
    WaveletPack {
        /// What the two hemispheres are.
        parameterisation: Parameterisation,
        /// Cells per axis and hemisphere.
        grid: usize,
        /// Levels of detail.
        levels: u32,
        /// Finest level that holds slices.
        stored_levels: u32,
        /// Whether coarser levels and slices that are left out keep the light.
        lifted: bool,
        /// 1 or 3.
        channels: u32,
        /// Bits per component.
        bits: u32,
        /// Slices kept, the zero slice not counted.
        slices_kept: usize,
        /// `μ`, 1/sr.
        mean: f32,
        /// `ε`.
        bias: f32,
        /// Directions that it is for, and that its errors are of.
        directions: DirectionRange,
        /// Bytes on a GPU.
        gpu_bytes: u64,
        /// Codec error: decoded samples against the table they were made from.
        on_grid: ErrorSummary,
        /// The filtered pack against its source at direction pairs that depend on no grid.
        off_grid: ErrorSummary,
    },
    /// A table pack.
    TablePack {
        /// Nodes per axis.
        axes: Axes,
        /// Symmetries that its nodes are folded by.
        folded: TableSymmetry,
        /// Nodes of the curve over `θ_h` that factored packs have, otherwise 0.
        curve_nodes: usize,
        /// Levels of detail besides the finest.
        levels: u32,
        /// 1 or 3.
        channels: u32,
        /// `μ`, 1/sr.
        mean: f32,
        /// `ε`.
        bias: f32,
        /// Filtered fetches of a look-up.
        fetches: u32,
        /// Directions that it is for, and that its errors are of.
        directions: DirectionRange,
        /// Bytes on a GPU.
        gpu_bytes: u64,
        /// The filtered pack against its source at direction pairs that depend on no grid.
        off_grid: ErrorSummary,
        /// Pictures of both: ΔE*ab.
        picture: PictureSummary,
    },
}

/// What the header of an ALTA table says, in its words.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct AltaHeader {
    /// How directions are written, `PARAM_IN`.
    pub directions: String,
    /// What values are, `PARAM_OUT`.
    pub values: String,
    /// Values of a row: 1 or 3.
    pub channels: usize,
}

impl Facts {
    /// Directions that a pack is for.
    pub fn directions(&self) -> DirectionRange {
        match self {
            Self::WaveletPack { directions, .. } | Self::TablePack { directions, .. } => *directions,
            _ => DirectionRange::ALL,
        }
    }

    /// Rows with a negative channel, which was raised to 0.
    pub fn rows_raised(&self) -> u64 {
        match self {
            Self::Scan { summary, .. } => summary.negative as u64,
            _ => 0,
        }
    }

    /// Rows of a scan that stray from the azimuth of incidence of the others.
    pub fn stray_rows(&self) -> Option<StrayRows> {
        match self {
            Self::Scan { summary, .. } => summary.strays,
            _ => None,
        }
    }

    /// Measured samples that came in; 0 for models.
    pub fn samples(&self) -> u64 {
        match self {
            Self::Synth { .. } => 0,
            Self::Merl { valid_cells, .. } => *valid_cells as u64,
            Self::Scan { summary, .. } => summary.rows as u64,
            Self::Rgl { azimuths, polar_angles, resolution, .. } => {
                (azimuths * polar_angles * resolution[0] * resolution[1]) as u64
            }
            Self::WaveletPack { grid, slices_kept, .. } => (grid * grid * slices_kept) as u64,
            Self::TablePack { axes, .. } => {
                [axes.half, axes.difference, axes.azimuth, axes.layers].into_iter().map(u64::from).product()
            }
        }
    }

    /// Lines for people: names and values.
    pub fn in_words(&self) -> Vec<(&'static str, String)> {
        let mut lines = self.lines();
        let directions = self.directions();
        if !directions.is_all() {
            lines.push(("directions", format!("{directions}; errors are of these")));
        }
        lines
    }

    fn lines(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Synth { address } => vec![("kind", "analytic model".to_owned()), ("address", address.clone())],
            Self::Merl { dimensions: [h, d, p], valid_cells, invalid_cells } => vec![
                ("kind", "MERL table".to_owned()),
                ("samples (theta_h x theta_d x phi_d)", format!("{h} x {d} x {p}")),
                ("azimuths cover", if *p == 4 * d { "a full turn" } else { "half a turn" }.to_owned()),
                ("valid cells", format!("{valid_cells} of {}", valid_cells + invalid_cells)),
            ],
            Self::Scan { wavelengths, alta, summary } => {
                let s = summary;
                let isotropic = if s.strays.is_some() {
                    "taken as isotropic: one azimuth of incidence, but for a few rows"
                } else if s.isotropic {
                    "taken as isotropic: one azimuth of incidence"
                } else {
                    "anisotropic: several azimuths of incidence"
                };
                let spectrum = match (wavelengths.first(), wavelengths.last(), alta) {
                    (Some(first), Some(last), _) => format!("{} wavelengths, {first} to {last} nm", wavelengths.len()),
                    (.., Some(alta)) if alta.channels == 1 => format!("one column, {}", alta.values),
                    (.., Some(alta)) => format!("RGB columns, {}", alta.values),
                    _ => "RGB columns".to_owned(),
                };
                let mut lines = vec![
                    ("kind", if alta.is_some() { "scattered scan, ALTA table" } else { "scattered scan" }.to_owned()),
                    ("rows", format!("{} ({} distinct direction pairs)", s.rows, s.distinct)),
                    ("material", isotropic.to_owned()),
                    ("values", spectrum),
                    ("repeated or mirrored rows differ up to", percent(s.largest_disagreement)),
                    ("rows with negative channels, raised to 0", s.negative.to_string()),
                    ("rows that are all 0", s.zero.to_string()),
                ];
                if let Some(alta) = alta {
                    lines.insert(2, ("directions", alta.directions.clone()));
                }
                if let Some(strays) = s.strays {
                    lines.push(("rows of another azimuth", strays.in_words()));
                }
                if let Some(left_out) = s.left_out {
                    lines.push(("rows left out, at or below the horizon", left_out.to_string()));
                }
                lines
            }
            Self::Rgl { description, azimuths, polar_angles, resolution: [rows, columns], channels } => vec![
                ("kind", "RGL material".to_owned()),
                ("description", description.clone()),
                ("incoming directions", format!("{azimuths} azimuths x {polar_angles} polar angles")),
                ("outgoing directions of each", format!("{rows} x {columns}")),
                ("channels", if *channels == 3 { "RGB".to_owned() } else { format!("{channels} wavelengths") }),
            ],
            Self::WaveletPack {
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
            } => vec![
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
            ],
            Self::TablePack {
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
            } => vec![
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
            ],
        }
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

/// An input, ready for evaluation.
pub struct Opened {
    /// Evaluates it.
    pub source: Box<dyn Source>,
    /// What it is.
    pub facts: Facts,
}

/// A kind of file that has reflectance.
pub struct Format {
    /// What its files' names end with, in lower case.
    pub extension: &'static str,
    /// What people call it.
    pub name: &'static str,
    /// Reads it.
    pub(crate) open: fn(InputFile<'_>) -> Result<Opened, InputError>,
}
