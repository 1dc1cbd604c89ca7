//! Structures as inputs of studies.

use super::arguments::Arguments;
use brdfc_core::address::SYNTH_PREFIX;
use brdfc_flat_btf::structures::STRUCTURES;
use brdfc_source::Input;
use brdfc_terminal::Error;

/// The given structures, or all, each with its address without prefix.
///
/// # Errors
/// Returns an error if an input is not the address of a structure, before any work.
pub(super) fn structures(arguments: &Arguments) -> Result<Vec<(Input, String)>, Error> {
    let all: Vec<Input> =
        STRUCTURES.iter().map(|info| Input::Address(format!("{SYNTH_PREFIX}{}", info.name))).collect();
    let inputs = if arguments.inputs.is_empty() { &all } else { &arguments.inputs };
    let address = |input: &Input| {
        let address = input.address().and_then(|address| address.strip_prefix(SYNTH_PREFIX)).ok_or_else(|| {
            let names: Vec<&str> = STRUCTURES.iter().map(|info| info.name).collect();
            Error::usage(format!("INPUT: found {input}, expected synth: with one of {}", names.join(", ")))
        })?;
        Ok((input.clone(), address.to_owned()))
    };
    inputs.iter().map(address).collect()
}

/// Name of a structure without its parameters.
pub(super) fn short_name(address: &str) -> String {
    address.strip_prefix(SYNTH_PREFIX).unwrap_or(address).split('?').next().unwrap_or_default().to_owned()
}

/// Part of the name of files about a structure: `knit-seed-3` for the address `knit?seed=3`.
pub(super) fn file_stem(address: &str) -> String {
    address.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect()
}
