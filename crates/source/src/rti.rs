//! RTI files of hemispherical harmonics as inputs.

use crate::input::InputFile;
use crate::{Input, InputError};
use brdfc_readers::rti::Rti;
use brdfc_readers::viewer_file::ViewerFile;

/// Extension of the files.
pub const EXTENSION: &str = "rti";

/// Reads an RTI file.
///
/// # Errors
/// Returns an error for files that cannot be read or that [`Rti::from_bytes`] rejects.
pub fn open_rti(input: &Input) -> Result<Rti, InputError> {
    InputFile::of(input, &mut ())?.parse(Rti::from_bytes)
}

/// Facts about an RTI file.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct RtiFacts {
    /// Highest degree of the hemispherical harmonics.
    pub degree: u32,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Range of each coefficient, in units of white.
    pub scale: Vec<f32>,
    /// Lowest value of each coefficient, in units of white.
    pub bias: Vec<f32>,
}

impl RtiFacts {
    /// Facts about a file.
    pub fn new(rti: &Rti) -> Self {
        let [scale, bias] = [rti.scale(), rti.bias()].map(<[f32]>::to_vec);
        Self { degree: rti.degree(), size: rti.size(), scale, bias }
    }

    /// Lines for people: names and values.
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let Self { degree, size: [width, height], scale, bias } = self;
        let numbers = |numbers: &[f32]| numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(" ");
        vec![
            ("kind", "RTI file of hemispherical harmonics".to_owned()),
            ("terms", format!("{} for each channel, degree {degree}", scale.len())),
            ("pixels", format!("{width} x {height}")),
            ("scale", numbers(scale)),
            ("bias", numbers(bias)),
        ]
    }
}
