//! HLSL.

use crate::parsed::Parsed;
use brdfc_shaders::{BindingKind, Interface};
use naga::back::hlsl::{Options, PipelineOptions, Writer};

/// Translates the declarations and functions.
///
/// # Errors
/// Returns the writer's error.
pub(crate) fn piece(parsed: &Parsed, interface: &Interface) -> Result<String, String> {
    let options = Options { fake_missing_bindings: true, ..Options::default() };
    let mut text = String::new();
    let pipeline = PipelineOptions::default();
    let mut writer = Writer::new(&mut text, &options, &pipeline);
    writer.write(&parsed.module, &parsed.info, None).map_err(|error| error.to_string())?;
    Ok(with_listed_zeros(&with_plain_samplers(&text, interface)))
}

/// Lists the zeros of arrays that the writer casts from one zero, since not every compiler accepts the cast.
fn with_listed_zeros(text: &str) -> String {
    let line = |line: &str| {
        let listed = || {
            let (declared, cast) = line.strip_suffix("])0;")?.split_once(" = (")?;
            let (ty, count) = cast.split_once('[')?;
            let zeros = vec![format!("({ty})0"); count.parse().ok()?];
            Some(format!("{declared} = {{{}}};", zeros.join(", ")))
        };
        listed().unwrap_or_else(|| line.to_owned()) + "\n"
    };
    text.lines().map(line).collect()
}

/// Replaces the sampler heap, which the writer uses like wgpu, by one register per sampler, as engines bind them. Also
/// removes register spaces, which engines do not use.
fn with_plain_samplers(text: &str, interface: &Interface) -> String {
    let declaration = |line: &str| {
        let sampler = interface.bindings.iter().find(|binding| {
            binding.kind == BindingKind::Sampler
                && line.starts_with(&format!("static const SamplerState {} =", binding.name))
        });
        match sampler {
            Some(sampler) => format!("SamplerState {} : register(s{});", sampler.name, sampler.binding),
            None => line.replace(", space1)", ")"),
        }
    };
    let is_heap = |line: &&str| {
        ["SamplerState nagaSamplerHeap", "SamplerComparisonState nagaComparison", "StructuredBuffer<uint> nagaGroup"]
            .iter()
            .any(|heap| line.starts_with(heap))
    };
    let mut lines: Vec<String> = text.lines().filter(|line| !is_heap(line)).map(declaration).collect();
    lines.dedup_by(|a, b| a.trim().is_empty() && b.trim().is_empty());
    lines.join("\n").trim().to_owned() + "\n"
}
