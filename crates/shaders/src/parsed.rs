//! Sources as naga reads them, and what is found in texts that it writes.

use crate::interface::Interface;
use naga::Module;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// A source that has been parsed and checked.
pub(crate) struct Parsed {
    pub module: Module,
    pub info: ModuleInfo,
}

impl Parsed {
    pub(crate) fn new(source: &str) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
        // What WebGPU has without features.
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
        Ok(Self { module, info })
    }
}

/// The signatures of an interface's functions in a translated text.
///
/// # Errors
/// A function that is not in it.
pub(crate) fn signatures(text: &str, interface: &Interface) -> Result<Vec<String>, String> {
    interface.functions.iter().map(|function| signature(text, &function.name, function.parameters())).collect()
}

/// From the line of the name to the brace, with the names of parameters as they are in WGSL: the writers number them.
fn signature<'a>(text: &str, name: &str, parameters: impl Iterator<Item = [&'a str; 2]>) -> Result<String, String> {
    let call = format!(" {name}(");
    let is_it = |line: &&str| line.contains(&call) && !line.starts_with([' ', '\t', '}', '/']);
    let line = text.lines().find(is_it).ok_or_else(|| format!("no function {name} in it"))?;
    let from = text.find(line).unwrap_or(0);
    let whole = text[from..].split('{').next().unwrap_or(line).split_whitespace().collect::<Vec<_>>().join(" ");
    let (result, rest) = whole.split_once('(').unwrap_or((&whole, ""));
    let mut written: Vec<String> =
        rest.trim_end().trim_end_matches(')').split(',').map(|parameter| parameter.trim().to_owned()).collect();
    for (parameter, [own, _]) in written.iter_mut().zip(parameters) {
        if let Some((ty, _)) = parameter.rsplit_once(' ') {
            *parameter = format!("{ty} {own}");
        }
    }
    Ok(format!("{result}({})", written.join(", ")))
}
