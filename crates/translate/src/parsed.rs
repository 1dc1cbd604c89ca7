//! Sources as naga reads them.

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
