//! Translates the decoders of packs, and pages that draw them, with naga. Tests and `./scripts/bless` use it; the
//! program contains the results.

mod glsl;
mod hlsl;
mod interface;
mod msl;
mod parsed;
mod program;
mod spirv;

pub use program::program;

use brdfc_formats::PackKind;
use brdfc_shaders::{Generated, Language};
use parsed::Parsed;
use std::collections::BTreeMap;

/// Translates a decoder into every language.
///
/// # Errors
/// Returns an error if a language cannot express the decoder.
pub fn translate(decoder: PackKind) -> Result<Generated, String> {
    let source = (decoder.descriptor().wgsl)();
    let parsed = Parsed::new(&source)?;
    let interface = interface::interface(&source, &parsed, decoder.descriptor().functions);
    let mut texts = BTreeMap::new();
    for language in [Language::Glsl, Language::Essl300, Language::Hlsl, Language::Msl] {
        let text = match language {
            Language::Hlsl => hlsl::piece(&parsed, &interface)?,
            Language::Msl => msl::piece(&parsed)?,
            _ => glsl::piece(&source, &interface, language)?,
        };
        texts.insert(language.name().to_owned(), text.lines().map(str::to_owned).collect());
    }
    let spirv = spirv::module(decoder, &source)?;
    Ok(Generated { interface, texts, spirv })
}
