//! What a decoder's shader asks for and offers: bindings, the fields of its uniform blocks, the functions to call. Found by naga
//! in the WGSL, with the words of its comments.

use naga::{AddressSpace, Handle, ImageDimension, Module, ScalarKind, Type, TypeInner};
use schemars::JsonSchema;
use serde::Serialize;

/// Everything outside of a shader that its user has to know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Interface {
    /// Bindings, by their numbers.
    pub bindings: Vec<Binding>,
    /// Functions to call, the foremost first.
    pub functions: Vec<Function>,
}

/// A uniform block, a texture or a sampler.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Binding {
    /// Number within group 1 of the WGSL.
    pub binding: u32,
    /// Its name in every language.
    pub name: String,
    /// What it is.
    #[serde(flatten)]
    pub kind: BindingKind,
    /// What it holds.
    pub about: String,
}

/// What is bound.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BindingKind {
    /// A uniform block: its struct, as laid out by std140 and by WGSL alike.
    Uniform {
        /// The name of the struct.
        block: String,
        /// Bytes of the block.
        bytes: u32,
        /// Its fields, in order.
        fields: Vec<Field>,
    },
    /// A sampled texture.
    Texture {
        /// `2d`, `2d-array` or `3d`.
        dimension: &'static str,
        /// `float`, also of normalised integers, or `uint`.
        samples: &'static str,
    },
    /// A sampler. GLSL has none of its own: it belongs to each texture.
    Sampler,
}

/// A field of a uniform block.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type in WGSL.
    #[serde(rename = "type")]
    pub ty: String,
    /// Where it begins, in bytes.
    pub offset: u32,
    /// What it holds.
    pub about: String,
}

/// A function to call.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Function {
    /// Its name in every language.
    pub name: String,
    /// Its parameters and its result, in WGSL.
    pub signature: String,
    /// What it does.
    pub about: String,
}

impl Interface {
    /// That of a WGSL source and the module that naga makes of it.
    ///
    /// # Panics
    /// Where a function is not in the source.
    pub(crate) fn of(source: &str, module: &Module, functions: &[&str]) -> Self {
        let mut bindings: Vec<Binding> = module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| {
                let (name, place) = (variable.name.clone()?, variable.binding?);
                let kind = kind(source, module, variable.ty, variable.space)?;
                let about = words_above(source, |line| {
                    line.contains(&format!("> {name}:")) || line.contains(&format!("var {name}:"))
                });
                Some(Binding { binding: place.binding, name, kind, about })
            })
            .collect();
        bindings.sort_by_key(|binding| binding.binding);
        let functions = functions.iter().map(|name| function(source, name)).collect();
        Self { bindings, functions }
    }
}

fn kind(source: &str, module: &Module, ty: Handle<Type>, space: AddressSpace) -> Option<BindingKind> {
    let ty = &module.types[ty];
    match &ty.inner {
        TypeInner::Struct { members, span } if space == AddressSpace::Uniform => {
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
                (_, true) => "2d-array",
                _ => "2d",
            };
            let uint = matches!(class, naga::ImageClass::Sampled { kind: ScalarKind::Uint, .. });
            Some(BindingKind::Texture { dimension, samples: if uint { "uint" } else { "float" } })
        }
        TypeInner::Sampler { .. } => Some(BindingKind::Sampler),
        _ => None,
    }
}

/// What stands behind the code of the first line of that kind, or the comment above it, which may be one for several bindings.
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

impl Function {
    /// Names and types of the parameters, in WGSL.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = [&str; 2]> {
        let inside =
            self.signature.split_once('(').and_then(|(_, rest)| rest.split_once(')')).map_or("", |(inside, _)| inside);
        inside.split(", ").filter_map(|parameter| parameter.split_once(": ")).map(|(name, ty)| [name, ty])
    }
}
