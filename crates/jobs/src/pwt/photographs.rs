//! Photographs of an RTI capture, as a pack shows them.

use super::input::{near_note, samples_of_capture};
use crate::error::Error;
use brdfc_pwt::LightSamples;
use brdfc_source::InputError;
use brdfc_source::photograph::{CodeValues, Image};
use brdfc_source::rti_capture::RtiCapture;
use std::path::Path;

/// Photographs of an RTI capture under distant lights.
pub struct DistantPhotographs {
    capture: RtiCapture,
    /// All photographs, if their lights are near.
    converted: Option<LightSamples>,
    notes: Vec<String>,
}

impl DistantPhotographs {
    /// Opens an `.lp` file, or a folder that has exactly one. Reads no pixels, unless lights are near. `codes` is the meaning of code
    /// values in spite of what the files state.
    ///
    /// # Errors
    /// Returns the errors of [`RtiCapture::open_as`], and for near lights those of the photographs and of their conversion.
    pub fn open(path: &Path, codes: Option<CodeValues>) -> Result<Self, Error> {
        let capture = RtiCapture::open_as(path, codes)?;
        let notes = capture.notes().iter().cloned().chain(near_note(&capture)).collect();
        let converted = capture.near().is_some().then(|| converted(&capture, path)).transpose()?;
        Ok(Self { capture, converted, notes })
    }

    /// Lights, files and size of the photographs.
    pub fn capture(&self) -> &RtiCapture {
        &self.capture
    }

    /// Differences between the list of lights and the photographs.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Linear values of the photograph under a light.
    ///
    /// # Errors
    /// Returns the errors of [`RtiCapture::image`].
    pub fn image(&self, light: usize) -> Result<Image, InputError> {
        let Some(converted) = self.converted.as_ref().and_then(|samples| samples.images.get(light)) else {
            return self.capture.image(light);
        };
        Ok(Image::new(self.capture.size(), converted.clone().into_linear()))
    }
}

fn converted(capture: &RtiCapture, path: &Path) -> Result<LightSamples, Error> {
    let samples = samples_of_capture(path, capture)?;
    Ok(samples.distant().map_err(|error| InputError::format(path, error))?.into_owned())
}
