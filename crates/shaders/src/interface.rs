//! Interface of a decoder's shader: bindings, the fields of its uniform blocks, the functions to call.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything that a user of a shader has to know about it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Interface {
    /// Bindings, by their numbers.
    pub bindings: Vec<Binding>,
    /// Functions to call, the main one first.
    pub functions: Vec<Function>,
}

impl Interface {
    /// Name of the block of a binding in GLSL: the name of its struct, with the slot appended if several blocks share
    /// one struct.
    pub fn block_name(&self, binding: &Binding) -> Option<String> {
        let of = |binding: &Binding| match &binding.kind {
            BindingKind::Uniform { block, .. } => Some(block.clone()),
            _ => None,
        };
        let block = of(binding)?;
        let is_alone = self.bindings.iter().filter(|other| of(other).as_ref() == Some(&block)).count() == 1;
        Some(if is_alone { format!("{block}Block") } else { format!("{block}Block{}", binding.binding) })
    }
}

/// A uniform block, a texture or a sampler.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Binding {
    /// Number within group 1 of the WGSL.
    pub binding: u32,
    /// Its name in every language.
    pub name: String,
    /// Type of the binding.
    #[serde(flatten)]
    pub kind: BindingKind,
    /// Contents.
    pub about: String,
}

/// Type of a binding.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum BindingKind {
    /// A uniform block: its struct, with the same layout in std140 and in WGSL.
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
        /// `2d`, `2d-array`, `3d` or `cube`.
        dimension: String,
        /// `float`, also of normalised integers, or `uint`.
        samples: String,
        /// True if a sampler filters it. Otherwise the shader only loads texels.
        filtered: bool,
    },
    /// A sampler. GLSL has none of its own: it belongs to each texture.
    Sampler,
}

/// A field of a uniform block.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type in WGSL.
    #[serde(rename = "type")]
    pub ty: String,
    /// Offset in bytes.
    pub offset: u32,
    /// Contents.
    pub about: String,
}

/// A function to call.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Function {
    /// Its name in every language.
    pub name: String,
    /// Its parameters and its result, in WGSL.
    pub signature: String,
    /// Purpose of the function.
    pub about: String,
}

impl Function {
    /// Names and types of the parameters, in WGSL.
    pub fn parameters(&self) -> impl Iterator<Item = [&str; 2]> {
        let inside =
            self.signature.split_once('(').and_then(|(_, rest)| rest.split_once(')')).map_or("", |(inside, _)| inside);
        inside.split(", ").filter_map(|parameter| parameter.split_once(": ")).map(|(name, ty)| [name, ty])
    }
}
