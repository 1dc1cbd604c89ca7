//! Static description of a codec. Each codec has one [`Descriptor`] in its own folder.

/// Description of a codec, for engines and for documentation.
#[derive(Debug, Clone, Copy)]
pub struct Descriptor {
    /// Name of its decoder, in files and on the command line.
    pub name: &'static str,
    /// Version of its shader bindings. Packs store it; readers reject packs of another version.
    pub version: u32,
    /// Name of one pack in messages, with article.
    pub summary: &'static str,
    /// Name of such packs in the plural.
    pub plural: &'static str,
    /// Path of the specification page, relative to the repository root.
    pub specification: &'static str,
    /// WGSL source, from which all other shading languages are translated. It has no entry point.
    pub wgsl: fn() -> String,
    /// Functions that engines call, the main one first.
    pub functions: &'static [&'static str],
    /// Evaluation of a query of three groups of four numbers, `a`, `b` and `c`. It is the body of the compute shader
    /// that SPIR-V users get instead of source to include.
    pub answer: Answer,
    /// Evaluation as a BRDF; `None` for codecs of other assets.
    pub brdf: Option<BrdfShader>,
}

/// WGSL expressions that evaluate a pack as a BRDF.
#[derive(Debug, Clone, Copy)]
pub struct BrdfShader {
    /// True if a pack of this codec is bound; otherwise its uniform block is zero.
    pub is_bound: &'static str,
    /// Statements that return `f_r` of `wi`, `wo` and `level`. The sampler filters if `hardware` is true, otherwise the
    /// shader.
    pub either: &'static str,
    /// `f_r` of `wi`, `wo` and `level`, filtered by the sampler.
    pub filtered: &'static str,
    /// `f_r` filtered by the shader: exact, and needed on devices whose samplers cannot filter the texture format.
    pub exact: &'static str,
    /// True if packs may have 16-bit channels, which only some devices filter.
    pub may_be_wide: bool,
    /// Level of detail at `distance` from the viewer.
    pub level_of_detail: &'static str,
}

/// Inputs, outputs and code of a query.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// Description of the query's groups.
    pub takes: &'static str,
    /// Description of the result.
    pub gives: &'static str,
    /// WGSL expression of `a`, `b` and `c` that consists of calls only, so that it is also valid GLSL and HLSL with
    /// `vec4f`, `u32` and `select` defined as macros.
    pub body: &'static str,
    /// Conversion of the result to four numbers if it is a struct.
    pub of_struct: Option<StructAnswer>,
}

/// Struct that a shader returns as the result of a query.
#[derive(Debug, Clone, Copy)]
pub struct StructAnswer {
    /// Name of the struct's type in WGSL.
    pub name: &'static str,
    /// Its numbers: a WGSL expression of `$answer`, `a`, `b` and `c`.
    pub numbers: &'static str,
}

impl StructAnswer {
    /// WGSL expression of the numbers of `value`.
    pub fn numbers_of(&self, value: &str) -> String {
        self.numbers.replace("$answer", value)
    }
}
