//! What is known of a codec apart from its packs: each has one [`Descriptor`], in its own folder.

/// A codec, for engines and for people.
#[derive(Debug, Clone, Copy)]
pub struct Descriptor {
    /// The name of its decoder: in files, and on the command line.
    pub name: &'static str,
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
}

/// How a query is answered.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// What the groups of a query hold, in words.
    pub takes: &'static str,
    /// What an answer holds, in words.
    pub gives: &'static str,
    /// A WGSL expression.
    pub body: &'static str,
}
