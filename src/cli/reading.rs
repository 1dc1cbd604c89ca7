//! Settings of reading inputs on the command line.

use super::Error;
use brdfc::inspect::{is_scan, is_table};
use brdfc::{Input, Material, Reading, Smooth, open_with};
use std::ffi::OsString;

/// Opens a material with the settings.
pub fn open_read(input: &Input, reading: Reading) -> Result<Material, Error> {
    Ok(open_with(input, checked(reading, &[input])?)?)
}

/// Checks the settings. Rejects flags that apply to none of the inputs.
pub fn checked(reading: Reading, inputs: &[&Input]) -> Result<Reading, Error> {
    reading.check().map_err(|error| Error::wrong_usage(&format!("--{}", error.field), error.found, error.allowed))?;
    let (smooth, radius) = (reading.smooth.is_some(), matches!(reading.smooth, Some(Smooth::Radius(_))));
    let flags = [
        ("--neighbours", reading.neighbours.is_some(), [true, false], "scans"),
        ("--smooth with a radius", radius, [false, true], "MERL and RGL tables; use --neighbours for scans"),
        ("--smooth", smooth && !radius, [true, true], "scans, and MERL and RGL tables"),
    ];
    for (flag, _, [scans, tables], allowed) in flags.into_iter().filter(|(_, is_given, ..)| *is_given) {
        let mut applies = false;
        for input in inputs {
            applies |= scans && is_scan(input)? || tables && is_table(input)?;
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
pub fn first_flag(reading: Reading) -> Option<&'static str> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_no_values() {
        let of = |text: &str| {
            let arguments = with_values(text.split(' ').map(OsString::from));
            arguments.iter().map(|argument| argument.to_str().unwrap()).collect::<Vec<_>>().join(" ")
        };
        for same in
            ["--smooth 3 a", "--smooth 2.5 a", "--smooth -1 a", "--smooth false a", "-- --smooth a", "a --smooth=4"]
        {
            assert_eq!(of(same), same);
        }
        assert_eq!(of("info --smooth a.binary"), "info --smooth=true a.binary");
        assert_eq!(of("info a.binary --smooth"), "info a.binary --smooth=true");
        assert_eq!(of("info --smooth -- a"), "info --smooth=true -- a");
    }
}
