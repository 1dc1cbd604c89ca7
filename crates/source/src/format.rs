//! What a kind of file that has reflectance is to the one who opens it.

use super::Source;
use super::error::InputError;
use super::read::read_all;
use super::scan::ScanSummary;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::ErrorSummary;
use std::fs::File;
use std::path::Path;

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
        /// Bytes on a GPU.
        gpu_bytes: u64,
        /// Codec error: decoded samples against the table they were made from.
        on_grid: ErrorSummary,
        /// The filtered pack against its source at random direction pairs.
        off_grid: ErrorSummary,
    },
}

impl Facts {
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
        }
    }
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

/// A file that is open, and not read yet.
pub(crate) struct InputFile<'a> {
    pub(crate) path: &'a Path,
    pub(crate) file: File,
    /// 0 for pipes.
    pub(crate) length: u64,
    /// The level of detail that is asked for.
    pub(crate) level: Option<f32>,
}

impl InputFile<'_> {
    /// Reads the whole file, and what is in it.
    pub(crate) fn parse<T>(self, parse: impl FnOnce(&[u8]) -> Result<T, FormatError>) -> Result<T, InputError> {
        let bytes = read_all(self.path, self.file, self.length)?;
        parse(&bytes).map_err(|error| InputError::format(self.path, error))
    }
}
