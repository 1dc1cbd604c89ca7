//! Opens any input: a path or a `synth:` address.

use super::address::{self, AddressError};
use super::flat_part::is_part;
use super::scan::{ScanSource, ScanSummary};
use super::{MerlSource, PackSource, RglSource, Source};
use brdfc_formats::FormatError;
use brdfc_formats::colour::rgb_weights;
use brdfc_formats::measured::merl::{Merl, MerlError};
use brdfc_formats::measured::rgl::Rgl;
use brdfc_formats::measured::scan::Scan;
use brdfc_formats::measured::scan_csv;
use brdfc_formats::wavelet::{ErrorSummary, WaveletPack};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest file that is read as a whole (everything but MERL tables, whose header is checked first).
pub const MAX_FILE_BYTES: u64 = 2 << 30;
/// Largest file of text that people write: manifests, lists of directions.
pub const MAX_TEXT_BYTES: u64 = 16 << 20;

/// An input that cannot be used, and whose fault that is.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// What stands in the file breaks its layout.
    #[error("{name}: {error}")]
    Format {
        /// The input as it was named.
        name: String,
        /// What is wrong.
        error: FormatError,
    },
    /// The file cannot be read.
    #[error("{name}: cannot read: {error}")]
    Io {
        /// The input as it was named.
        name: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// The `synth:` address is wrong.
    #[error("{name}: {error}")]
    Address {
        /// The input as it was named.
        name: String,
        /// What is wrong.
        error: AddressError,
    },
}

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
        /// The parameterisation's name.
        parameterisation: String,
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
        on_grid: StoredErrors,
        /// The filtered pack against its source at random direction pairs.
        off_grid: StoredErrors,
    },
}

/// Errors as a pack holds them; ratios are fractions. See [`ErrorSummary`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct StoredErrors {
    /// Samples compared.
    pub samples: u32,
    /// `ε`, RMS, 1/sr.
    pub rms: f32,
    /// `ε_r`, mean relative difference.
    pub relative_mean: f32,
    /// Its 95th percentile.
    pub relative_p95: f32,
    /// Its 99th percentile.
    pub relative_p99: f32,
    /// Its maximum.
    pub relative_max: f32,
    /// RMS of log difference.
    pub log_rms: f32,
    /// RMS of `ln(1 + f cos θi)` difference.
    pub cosine_log_rms: f32,
    /// Largest difference of directional albedo.
    pub albedo_max_difference: f32,
    /// Mean relative difference between the pack and itself with directions exchanged.
    pub reciprocity: f32,
}

impl From<ErrorSummary> for StoredErrors {
    fn from(e: ErrorSummary) -> Self {
        Self {
            samples: e.samples,
            rms: e.rms,
            relative_mean: e.relative_mean,
            relative_p95: e.relative_p95,
            relative_p99: e.relative_p99,
            relative_max: e.relative_max,
            log_rms: e.log_rms,
            cosine_log_rms: e.cosine_log_rms,
            albedo_max_difference: e.albedo_max,
            reciprocity: e.reciprocity,
        }
    }
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

/// Opens `input`. `level` is the level of detail that packs are decoded at; other inputs have none.
///
/// # Errors
/// Files that cannot be read or do not follow their layout, unknown kinds, wrong addresses.
pub fn open(input: &str, level: Option<f32>) -> Result<Opened, InputError> {
    if address::is_synth(input) {
        let model = address::parse_model(&input[address::SYNTH_PREFIX.len()..])
            .map_err(|error| InputError::Address { name: input.to_owned(), error })?;
        let facts = Facts::Synth { address: address::canonical(model.as_ref()) };
        return Ok(Opened { source: model, facts });
    }
    open_file(Path::new(input), level)
}

/// Opens a file.
///
/// # Errors
/// As [`open`].
pub fn open_file(path: &Path, level: Option<f32>) -> Result<Opened, InputError> {
    let name = path.display().to_string();
    let format = |error| InputError::Format { name: name.clone(), error };
    let (file, length) = open_path(path)?;
    let extension = extension_of(path);
    // Before anything is read.
    if !EXTENSIONS.contains(&extension.as_str()) {
        return Err(format(FormatError::whole(
            "file name",
            found_extension(&extension),
            ".binary (MERL), .brdf or .csv (scan), .bsdf (RGL), .ktx2 (pack), or synth:MODEL",
        )));
    }
    if extension == "binary" {
        let table = Merl::read(file, length).map_err(|error| match error {
            MerlError::Format(error) => format(error),
            MerlError::Io(error) => InputError::Io { name: name.clone(), error },
        })?;
        return Ok(opened_merl(table));
    }
    let bytes = read_all(path, file, length)?;
    let opened = match extension.as_str() {
        "brdf" => Scan::from_bytes(&bytes).and_then(|scan| opened_scan(&scan)),
        "csv" => scan_csv::from_bytes(&bytes).and_then(|scan| opened_scan(&scan)),
        "bsdf" => Rgl::from_bytes(&bytes).and_then(opened_rgl),
        _ => wavelet_pack(path, &bytes).map(|pack| opened_pack(&pack, level)),
    };
    opened.map_err(format)
}

/// Extensions of what [`open_file`] reads.
const EXTENSIONS: [&str; 5] = ["binary", "brdf", "csv", "bsdf", "ktx2"];

/// Reads a wavelet pack.
///
/// # Errors
/// As [`open`]; a part of a flat BTF, which says so.
pub fn open_pack(path: &Path) -> Result<WaveletPack, InputError> {
    wavelet_pack(path, &read_file(path, MAX_FILE_BYTES)?)
        .map_err(|error| InputError::Format { name: path.display().to_string(), error })
}

fn wavelet_pack(path: &Path, bytes: &[u8]) -> Result<WaveletPack, FormatError> {
    WaveletPack::from_bytes(bytes).map_err(|error| {
        if !is_part(path, bytes) {
            return error;
        }
        let allowed = "a wavelet pack; of a flat BTF, its folder or the NAME.json beside its parts";
        FormatError::whole("pack", "a part of a flat BTF", allowed)
    })
}

/// Opens what is no folder and no device; its length too, which is 0 for pipes.
pub(super) fn open_path(path: &Path) -> Result<(File, u64), InputError> {
    let io = |error| InputError::Io { name: path.display().to_string(), error };
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(io(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_char_device() || kind.is_block_device() {
            let error = FormatError::whole("file", "a device", "a file or a pipe");
            return Err(InputError::Format { name: path.display().to_string(), error });
        }
    }
    Ok((file, metadata.len()))
}

/// Reads a file or a pipe to its end if it has at most `limit` bytes.
///
/// # Errors
/// What cannot be read; folders and devices; more bytes.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    let (file, length) = open_path(path)?;
    read_within(path, file, length, limit)
}

/// Reads a file to its end if it is not too large.
pub(super) fn read_all(path: &Path, file: File, length: u64) -> Result<Vec<u8>, InputError> {
    read_within(path, file, length, MAX_FILE_BYTES)
}

fn read_within(path: &Path, file: File, length: u64, limit: u64) -> Result<Vec<u8>, InputError> {
    let name = path.display().to_string();
    let too_long = |found: String| {
        let error = FormatError::whole("file length", found, format!("at most {limit} bytes"));
        InputError::Format { name: path.display().to_string(), error }
    };
    if length > limit {
        return Err(too_long(format!("{length} bytes")));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // A pipe has no length, and a file may grow meanwhile.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(|error| InputError::Io { name, error })?;
    if bytes.len() as u64 > limit {
        return Err(too_long(format!("more than {limit} bytes")));
    }
    Ok(bytes)
}

/// The extension of a file's name in lower case, or nothing.
pub(super) fn extension_of(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// An extension as an error says that it was found.
pub(super) fn found_extension(extension: &str) -> String {
    if extension.is_empty() { "no extension".to_owned() } else { format!("extension .{extension}") }
}

fn opened_merl(table: Merl) -> Opened {
    let source = MerlSource::new(table);
    let (n, valid_cells) = (source.table().dimensions, source.table().valid_cells);
    let facts = Facts::Merl {
        dimensions: [n.theta_half, n.theta_difference, n.phi_difference],
        valid_cells,
        invalid_cells: n.cells() - valid_cells,
    };
    Opened { source: Box::new(source), facts }
}

fn opened_scan(scan: &Scan) -> Result<Opened, FormatError> {
    let source = ScanSource::new(scan)?;
    let facts = Facts::Scan { wavelengths: scan.wavelengths.clone(), summary: source.summary() };
    Ok(Opened { source: Box::new(source), facts })
}

fn opened_rgl(rgl: Rgl) -> Result<Opened, FormatError> {
    let facts = Facts::Rgl {
        description: rgl.description.clone(),
        azimuths: rgl.phi_i.len(),
        polar_angles: rgl.theta_i.len(),
        resolution: [rgl.colour_rows, rgl.colour_columns],
        channels: rgl.channels(),
    };
    Ok(Opened { source: Box::new(RglSource::new(rgl, rgb_weights)?), facts })
}

fn opened_pack(pack: &WaveletPack, level: Option<f32>) -> Opened {
    let h = &pack.header;
    let facts = Facts::WaveletPack {
        parameterisation: h.parameterisation.name().to_owned(),
        grid: h.grid(),
        levels: h.levels,
        stored_levels: h.stored_levels,
        channels: h.channels,
        bits: h.bits,
        slices_kept: pack.slices() - 1,
        mean: h.mean,
        bias: h.bias,
        gpu_bytes: pack.gpu_bytes(),
        on_grid: pack.on_grid.into(),
        off_grid: pack.off_grid.into(),
    };
    Opened { source: Box::new(PackSource::new(pack, level)), facts }
}
