//! What is known of a codec apart from its packs: each has one [`Descriptor`], in its own folder.

/// A codec, for engines and for people.
#[derive(Debug, Clone, Copy)]
pub struct Descriptor {
    /// The name of its decoder: in files, and on the command line.
    pub name: &'static str,
    /// The version of the bindings of its shader, which packs have as well: of another version they are refused.
    pub version: u32,
    /// What a pack of it is called in messages.
    pub in_words: &'static str,
    /// What packs of it are called.
    pub plural: &'static str,
    /// The page that describes the files, from the root of the repository.
    pub specification: &'static str,
    /// The WGSL that every other language is translated from. It has no entry point.
    pub wgsl: fn() -> String,
    /// What engines call of it, the first one foremost.
    pub functions: &'static [&'static str],
    /// How a query of three groups of four numbers, `a`, `b` and `c`, is answered: the body of the compute shader that SPIR-V has
    /// in place of a piece to paste.
    pub answer: Answer,
    /// How shaders evaluate packs of it as BRDFs, if they are.
    pub brdf: Option<BrdfShader>,
}

/// How a shader evaluates a pack of a BRDF: WGSL expressions.
#[derive(Debug, Clone, Copy)]
pub struct BrdfShader {
    /// Whether a pack of this codec is bound; otherwise its uniform block is zero.
    pub is_bound: &'static str,
    /// Statements that return `f_r` of `wi`, `wo` and `level`; the sampler filters where `hardware` is true, otherwise the shader.
    pub either: &'static str,
    /// `f_r` of `wi`, `wo` and `level`, filtered by the sampler.
    pub filtered: &'static str,
    /// The same, filtered by the shader: exact, and for devices whose samplers do not filter the texture.
    pub exact: &'static str,
    /// Whether packs may have texels of 16 bits a channel, which samplers filter on some devices only.
    pub may_be_wide: bool,
    /// The level of detail at `distance` from the viewer.
    pub level_of_detail: &'static str,
}

/// How a query is answered.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// What the groups of a query hold, in words.
    pub takes: &'static str,
    /// What an answer holds, in words.
    pub gives: &'static str,
    /// A WGSL expression of `a`, `b` and `c`, of calls alone: in GLSL and HLSL it is the same where `vec4f`, `u32` and `select` are
    /// macros.
    pub body: &'static str,
    /// How the expression becomes four numbers, where it is a struct.
    pub of_struct: Option<StructAnswer>,
}

/// An answer that a shader gives as a struct.
#[derive(Debug, Clone, Copy)]
pub struct StructAnswer {
    /// The WGSL type.
    pub name: &'static str,
    /// Its numbers: a WGSL expression of `$answer`.
    pub numbers: &'static str,
}

impl StructAnswer {
    /// The numbers of a value, a WGSL expression.
    pub fn numbers_of(&self, value: &str) -> String {
        self.numbers.replace("$answer", value)
    }
}
