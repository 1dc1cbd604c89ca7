//! GLSL for desktops and for WebGL 2.

use crate::parsed::Parsed;
use brdfc_shaders::{BindingKind, Interface, Language};
use naga::ShaderStage;
use naga::back::glsl::{Options, PipelineOptions, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use std::fmt::Write as _;

/// The entry point that the writer requires. It calls the functions to retain, and is removed afterwards.
const ENTRY: &str = "brdfc_entry";

/// Translates the declarations and functions.
///
/// # Errors
/// Returns the writer's error.
pub(crate) fn piece(source: &str, interface: &Interface, language: Language) -> Result<String, String> {
    let mut calls = String::new();
    for function in &interface.functions {
        let zeros: Vec<String> = function.parameters().map(|[_, ty]| format!("{ty}()")).collect();
        let _ = writeln!(calls, "_ = {}({});", function.name, zeros.join(", "));
    }
    let whole =
        format!("{source}\n@fragment fn {ENTRY}() -> @location(0) vec4<f32> {{ {calls} return vec4<f32>(); }}\n");
    let parsed = Parsed::new(&whole)?;
    let version = match language {
        Language::Essl300 => Version::Embedded { version: 300, is_webgl: true },
        _ => Version::Desktop(330),
    };
    let options = Options { version, writer_flags: WriterFlags::empty(), ..Options::default() };
    let pipeline =
        PipelineOptions { shader_stage: ShaderStage::Fragment, entry_point: ENTRY.to_owned(), multiview: None };
    let mut text = String::new();
    let policies = BoundsCheckPolicies::default();
    let mut writer = Writer::new(&mut text, &parsed.module, &parsed.info, &options, &pipeline, policies)
        .map_err(|error| error.to_string())?;
    let reflection = writer.write().map_err(|error| error.to_string())?;
    for (handle, block) in &reflection.uniforms {
        let variable = &parsed.module.global_variables[*handle];
        let name = variable.name.as_deref().unwrap_or_default();
        let binding = interface.bindings.iter().find(|binding| binding.name == name);
        let named = binding.and_then(|binding| interface.block_name(binding)).unwrap_or_default();
        text = text.replace(block.as_str(), &named);
    }
    for binding in &interface.bindings {
        if binding.kind != BindingKind::Sampler {
            text = replaced(&text, &format!("_group_1_binding_{}_fs", binding.binding), &binding.name);
        }
    }
    Ok(without_entry(&text).ok_or("the writer puts the entry point elsewhere")?)
}

/// Replaces a name wherever it is a whole word.
fn replaced(text: &str, from: &str, to: &str) -> String {
    let mut pieces = text.split(from);
    let mut whole = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let is_word = !piece.starts_with(|letter: char| letter.is_ascii_alphanumeric() || letter == '_');
        whole += if is_word { to } else { from };
        whole += piece;
    }
    whole
}

/// Removes the version, the entry point and its output.
fn without_entry(text: &str) -> Option<String> {
    let (pieces, _) = text.split_once("\nvoid main() {")?;
    let is_retained = |line: &&str| !line.starts_with("#version") && !line.starts_with("layout(location");
    let mut lines: Vec<&str> = pieces.lines().filter(is_retained).collect();
    // No two empty lines in a row.
    lines.dedup_by(|a, b| a.trim().is_empty() && b.trim().is_empty());
    Some(lines.join("\n").trim().to_owned() + "\n")
}
