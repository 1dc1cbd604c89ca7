//! Settings of reading inputs on the command line.

use super::Error;
use super::output::refuse_flags;
use brdfc::inspect::Kind;
use brdfc::relight::CodeValues;
use brdfc::{Input, Material, Reading, Smooth, open_with};
use brdfc_terminal::values::{any_whole_number, one_of};
use clap::Args;
use std::ffi::OsString;

/// Settings of reading scans and tables.
#[derive(Debug, Clone, Copy, Args)]
pub struct ReadingOptions {
    /// Scans: number of neighbours of a fit, 1 to the number of distinct direction pairs (default: chosen by left-out
    /// rows, which 'brdfc info' prints).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>(Reading::NEIGHBOURS))]
    neighbours: Option<usize>,
    /// Tables and scans with noise: smooth the values by moving least squares. Without RADIUS, left-out values choose
    /// the strength, and 'brdfc info' prints it with the estimated noise. RADIUS is 2 to 16 cells of a table on each
    /// side of a fit; scans have --neighbours instead. Scans of 5 % noise or more are smoothed anyway, unless RADIUS is
    /// false.
    #[arg(
        long,
        value_name = "RADIUS",
        num_args = 0..=1,
        default_missing_value = "true",
        allow_negative_numbers = true
    )]
    smooth: Option<Smooth>,
}

/// Setting of reading photographs and images of BTFs.
#[derive(Debug, Clone, Copy, Args)]
pub struct PhotographOptions {
    /// Photographs and BTF images: read the code values as linear or as sRGB, in spite of what the files state (default: as
    /// stated, or else sRGB for integers and linear for floats).
    #[arg(long = "photographs", value_name = "ENCODING", value_parser = one_of(&CODE_VALUES))]
    pub codes: Option<CodeValues>,
}

/// Meanings of code values.
const CODE_VALUES: [(&str, CodeValues, &str); 2] =
    [("linear", CodeValues::Linear, "Proportional to light"), ("srgb", CodeValues::Srgb, "sRGB")];

impl PhotographOptions {
    /// Rejects the flag for inputs of other kinds.
    pub fn refuse(self, what: &str) -> Result<(), Error> {
        refuse_flags(what, &[(self.codes.is_some(), "--photographs", "RTI captures and folders of BTF images")])
    }
}

impl From<ReadingOptions> for Reading {
    fn from(ReadingOptions { neighbours, smooth }: ReadingOptions) -> Self {
        Self { level: None, neighbours, smooth }
    }
}

/// Opens a material with the settings.
pub fn open_read(input: &Input, reading: ReadingOptions) -> Result<Material, Error> {
    open_with(input, checked(reading, &[input])?)
}

/// Checks the settings, for inputs of any kind.
pub fn in_range(reading: impl Into<Reading>) -> Result<Reading, Error> {
    let reading = reading.into();
    reading.check().map_err(|error| Error::wrong_usage(format!("--{}", error.field), error.found, error.allowed))?;
    Ok(reading)
}

/// Checks the settings. Rejects flags that apply to none of the inputs.
pub fn checked(reading: impl Into<Reading>, inputs: &[&Input]) -> Result<Reading, Error> {
    let reading = in_range(reading)?;
    let (smooth, radius) = (reading.smooth.is_some(), matches!(reading.smooth, Some(Smooth::Radius(_))));
    let flags = [
        ("--neighbours", reading.neighbours.is_some(), [true, false], "scans"),
        ("--smooth with a radius", radius, [false, true], "MERL and RGL tables; use --neighbours for scans"),
        ("--smooth", smooth && !radius, [true, true], "scans, and MERL and RGL tables"),
    ];
    for (flag, _, [scans, tables], allowed) in flags.into_iter().filter(|(_, is_given, ..)| *is_given) {
        let mut applies = false;
        for input in inputs {
            applies |= match Kind::of(input)? {
                Kind::Scan => scans,
                Kind::Table => tables,
                _ => false,
            };
        }
        if !applies {
            let names: Vec<String> = inputs.iter().map(|input| input.short_name()).collect();
            return Err(Error::usage(format!("{flag} does not apply to {}, only to {allowed}", names.join(" and "))));
        }
    }
    Ok(reading)
}

/// Flag of the first setting that is given.
#[cfg(feature = "render")]
pub fn first_flag(reading: ReadingOptions) -> Option<&'static str> {
    let smooth = reading.smooth.map(|_| "--smooth");
    reading.neighbours.map(|_| "--neighbours").or(smooth)
}

/// Arguments with `--smooth=true` for a `--smooth` that no value follows: the next argument may be an input.
pub fn with_values(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = arguments.collect();
    let is_value =
        |text: &OsString| text.to_str().is_some_and(|t| t.parse::<f64>().is_ok() || t.parse::<bool>().is_ok());
    let end = arguments.iter().position(|argument| argument == "--").unwrap_or(arguments.len());
    for at in 0..end {
        if arguments[at] == "--smooth" && !arguments.get(at + 1).is_some_and(is_value) {
            arguments[at] = "--smooth=true".into();
        }
    }
    arguments
}
