//! Polynomial texture maps as inputs.

use crate::input::InputFile;
use crate::{Input, InputError};
use brdfc_readers::ptm::{Ptm, TERMS};

/// Extension of the files.
pub const EXTENSION: &str = "ptm";

/// Reads a polynomial texture map.
///
/// # Errors
/// Returns an error for files that cannot be read or that [`Ptm::from_bytes`] rejects.
pub fn open_ptm(input: &Input) -> Result<Ptm, InputError> {
    InputFile::of(input, &mut ())?.parse(Ptm::from_bytes)
}

/// Facts about a polynomial texture map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct PtmFacts {
    /// Format in the file: `PTM_FORMAT_RGB` or `PTM_FORMAT_LRGB`.
    pub format: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Scales of the coefficients of u², v², uv, u, v and 1, in 8-bit levels.
    pub scale: [f32; TERMS],
    /// Stored bytes that mean 0.
    pub bias: [i32; TERMS],
}

impl PtmFacts {
    /// Facts about a map.
    pub fn new(ptm: &Ptm) -> Self {
        Self { format: ptm.model().name().to_owned(), size: ptm.size(), scale: ptm.scale(), bias: ptm.bias() }
    }

    /// Lines for people: names and values.
    pub fn summary(&self) -> Vec<(&'static str, String)> {
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
