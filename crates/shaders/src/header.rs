//! The header of a translated shader, as comments: description, functions, bindings.

use crate::interface::{Binding, BindingKind, Interface};
use crate::language::Language;
use crate::words::{ascii, wrapped};
use brdfc_formats::PackKind;

const WIDTH: usize = 120;

/// The comment, in ASCII. `signatures` declare the functions in the language, in the order of the interface.
pub(crate) fn header(decoder: PackKind, language: Language, interface: &Interface, signatures: &[String]) -> String {
    let mut text = String::new();
    let mut say = |indent: usize, words: &str| {
        text += &wrapped(&ascii(words), &format!("// {}", " ".repeat(indent)), WIDTH);
    };
    let (packs, version) = (decoder.descriptor().plural, env!("CARGO_PKG_VERSION"));
    say(0, &format!("Decoder of {packs} of brdfc {version}, {}.", language.title()));
    say(0, "");
    say(
        0,
        &format!(
            "Made by 'brdfc shader {} --language {}'. The files: {}. License: MIT OR Apache-2.0.",
            decoder.name(),
            language.name(),
            decoder.descriptor().specification
        ),
    );
    say(0, "");
    say(0, paste(language));
    say(
        0,
        "Directions are unit vectors in the frame x = tangent, y = bitangent, z = normal: wi, or light, to the light, wo, or view, to the viewer. Colours are linear RGB, Rec. 709.",
    );
    say(0, "");
    say(0, "Functions");
    for (function, signature) in interface.functions.iter().zip(signatures) {
        say(4, signature);
        say(8, &function.about);
    }
    say(0, "");
    say(0, "Bindings");
    for binding in &interface.bindings {
        let Some(declared) = declared(language, interface, binding) else { continue };
        say(4, &declared);
        if !binding.about.is_empty() {
            say(8, &binding.about);
        }
        if let BindingKind::Uniform { fields, .. } = &binding.kind {
            for field in fields {
                let about = if field.about.is_empty() { String::new() } else { format!(": {}", field.about) };
                say(8, &format!("byte {}, {} {}{about}", field.offset, field.ty, field.name));
            }
        }
    }
    text + "\n"
}

fn paste(language: Language) -> &'static str {
    match language {
        Language::Wgsl => {
            "Paste it before your own shader. Change binding numbers only if your code does not take them from the pack."
        }
        Language::Glsl => "Paste it after the #version line of your shader, 330 or higher.",
        Language::Essl300 => "Paste it after the line '#version 300 es' of your shader.",
        Language::Hlsl => "Paste it before your own shader, and change the registers as required.",
        Language::Msl => {
            "Paste it before your own shader. The bindings are parameters of each function, in the order in which it uses them."
        }
        Language::Spirv => "",
    }
}

/// A binding as the language declares it; `None` if the language has no declaration for it.
fn declared(language: Language, interface: &Interface, binding: &Binding) -> Option<String> {
    let Binding { binding: number, name, kind, .. } = binding;
    let place = match language {
        Language::Wgsl | Language::Spirv => format!("group 1, binding {number}: "),
        Language::Hlsl => match kind {
            BindingKind::Uniform { .. } => format!("register b{number}: "),
            BindingKind::Texture { .. } => format!("register t{number}: "),
            BindingKind::Sampler => format!("register s{number}: "),
        },
        Language::Glsl | Language::Essl300 if *kind == BindingKind::Sampler => return None,
        Language::Glsl | Language::Essl300 | Language::Msl => String::new(),
    };
    Some(
        place
            + &match kind {
                BindingKind::Uniform { block, bytes, .. } => match language {
                    Language::Glsl | Language::Essl300 => format!(
                        "uniform block {} (std140), {bytes} bytes",
                        interface.block_name(binding).unwrap_or_default()
                    ),
                    _ => format!("uniform block {name} of the type {block}, {bytes} bytes"),
                },
                BindingKind::Texture { dimension, samples, .. } => {
                    format!("{} texture of {samples} {name}", dimension.replace('d', "D").replace('-', " "))
                }
                BindingKind::Sampler => format!("sampler {name}"),
            },
    )
}
