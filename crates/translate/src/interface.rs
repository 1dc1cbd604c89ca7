//! Extraction of a decoder's interface from the WGSL by naga, with descriptions from its comments.

use super::parsed::Parsed;
use brdfc_shaders::{Binding, BindingKind, Field, Function, Interface};
use naga::{AddressSpace, GlobalVariable, Handle, ImageDimension, Module, ScalarKind, TypeInner};

/// Returns the interface of a WGSL source and its naga module.
///
/// # Panics
/// Panics if the source lacks a function.
pub(crate) fn interface(source: &str, Parsed { module, info }: &Parsed, functions: &[&str]) -> Interface {
    let sampled: Vec<Handle<GlobalVariable>> = module
        .functions
        .iter()
        .flat_map(|(function, _)| info[function].sampling_set.iter().map(|sampling| sampling.image))
        .collect();
    let mut bindings: Vec<Binding> = module
        .global_variables
        .iter()
        .filter_map(|(handle, variable)| {
            let (name, place) = (variable.name.clone()?, variable.binding?);
            let kind = kind(source, module, variable, sampled.contains(&handle))?;
            let about = words_above(source, |line| {
                line.contains(&format!("> {name}:")) || line.contains(&format!("var {name}:"))
            });
            Some(Binding { binding: place.binding, name, kind, about })
        })
        .collect();
    bindings.sort_by_key(|binding| binding.binding);
    let functions = functions.iter().map(|name| function(source, name)).collect();
    Interface { bindings, functions }
}

fn kind(source: &str, module: &Module, variable: &GlobalVariable, filtered: bool) -> Option<BindingKind> {
    let ty = &module.types[variable.ty];
    match &ty.inner {
        TypeInner::Struct { members, span } if variable.space == AddressSpace::Uniform => {
            let block = ty.name.clone()?;
            let from = source.find(&format!("struct {block} {{"))?;
            let body = &source[from..][..source[from..].find("\n}")?];
            let field = |member: &naga::StructMember| {
                let name = member.name.clone()?;
                let line = body.lines().find(|line| line.trim_start().starts_with(&format!("{name}:")))?;
                let (code, about) = line.split_once("//").unwrap_or((line, ""));
                let ty = code.trim().strip_prefix(&name)?.strip_prefix(':')?.trim().trim_end_matches(',');
                Some(Field { ty: ty.to_owned(), offset: member.offset, about: about.trim().to_owned(), name })
            };
            let fields = members.iter().filter_map(field).collect();
            Some(BindingKind::Uniform { block, bytes: *span, fields })
        }
        TypeInner::Image { dim, arrayed, class } => {
            let dimension = match (dim, arrayed) {
                (ImageDimension::D3, _) => "3d",
                (ImageDimension::Cube, _) => "cube",
                (_, true) => "2d-array",
                _ => "2d",
            };
            let uint = matches!(class, naga::ImageClass::Sampled { kind: ScalarKind::Uint, .. });
            let samples = if uint { "uint" } else { "float" };
            Some(BindingKind::Texture { dimension: dimension.to_owned(), samples: samples.to_owned(), filtered })
        }
        TypeInner::Sampler { .. } => Some(BindingKind::Sampler),
        _ => None,
    }
}

/// The comment after the code of the first line of that kind, or above it. One comment may be for several bindings.
fn words_above(source: &str, is_it: impl Fn(&str) -> bool) -> String {
    let lines: Vec<&str> = source.lines().collect();
    let Some(at) = lines.iter().position(|line| is_it(line)) else { return String::new() };
    if let Some((_, behind)) = lines[at].split_once("//") {
        return behind.trim().to_owned();
    }
    let above = lines[..at].iter().rev().skip_while(|line| line.starts_with("@group"));
    let mut words: Vec<&str> = above.map_while(|line| line.trim().strip_prefix("//")).map(str::trim).collect();
    words.reverse();
    words.join(" ")
}

fn function(source: &str, name: &str) -> Function {
    let from = source.find(&format!("fn {name}(")).unwrap_or_else(|| panic!("no function {name}"));
    let signature = source[from..].split(" {\n").next().unwrap_or_default();
    let signature = signature.split_whitespace().collect::<Vec<_>>().join(" ").replace("( ", "(").replace(", )", ")");
    let about = words_above(source, |line| line.starts_with(&format!("fn {name}(")));
    Function { name: name.to_owned(), signature, about }
}
