//! Sources parsed by naga.

use naga::Module;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// A parsed and validated source.
pub(crate) struct Parsed {
    pub module: Module,
    pub info: ModuleInfo,
}

impl Parsed {
    pub(crate) fn new(source: &str) -> Result<Self, String> {
        let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
        // Capabilities of WebGPU without optional features.
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator.validate(&module).map_err(|error| error.emit_to_string(source))?;
        Ok(Self { module, info })
    }
}
