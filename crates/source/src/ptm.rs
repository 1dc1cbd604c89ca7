//! Polynomial texture maps as inputs.

use crate::input::InputFile;
use crate::{Input, InputError};
use brdfc_readers::ptm::{Ptm, TERMS};

/// Extension of the files.
pub const EXTENSION: &str = "ptm";

/// Reads a polynomial texture map.
///
/// # Errors
/// What cannot be read; what [`Ptm::from_bytes`] refuses.
pub fn open_ptm(input: &Input) -> Result<Ptm, InputError> {
    InputFile::of(input, &mut ())?.parse(Ptm::from_bytes)
}

/// What is worth knowing of a polynomial texture map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PtmFacts {
    /// As the file names it: `PTM_FORMAT_RGB` or `PTM_FORMAT_LRGB`.
    pub format: String,
    /// Pixels per row, and rows.
    pub size: [u32; 2],
    /// What a step of the coefficients of u², v², uv, u, v and 1 is worth, in codes of 0 to 255.
    pub scale: [f32; TERMS],
    /// Bytes that mean 0.
    pub bias: [i32; TERMS],
}

impl PtmFacts {
    /// Those of a map.
    pub fn new(ptm: &Ptm) -> Self {
        Self { format: ptm.model().name().to_owned(), size: ptm.size(), scale: ptm.scale(), bias: ptm.bias() }
    }

    /// Lines for people: names and values.
    pub fn in_words(&self) -> Vec<(&'static str, String)> {
        let Self { format, size: [width, height], scale, bias } = self;
        vec![
            ("kind", "polynomial texture map".to_owned()),
            ("format", format.clone()),
            ("pixels", format!("{width} x {height}")),
            ("scale of u², v², uv, u, v, 1", scale.map(|number| number.to_string()).join(" ")),
            ("bias", bias.map(|number| number.to_string()).join(" ")),
        ]
    }
}
