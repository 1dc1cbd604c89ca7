//! Ordinary BTFs in any format: images of a tile for all pairs of a view and a light.

use crate::InputError;
use crate::btf_stack::BtfStack;
use crate::photograph::{CodeValues, Image};
use crate::ubo_btf::UboBtfFile;
use brdfc_formats::direction_set::DirectionSet;
use std::path::Path;

/// An ordinary BTF: an image for each pair of a view and a light.
pub enum OrdinaryBtf {
    /// A folder of images.
    Stack(BtfStack),
    /// A file of the Bonn database of 2014.
    Ubo(Box<UboBtfFile>),
}

impl OrdinaryBtf {
    /// Opens a folder or a file.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or is invalid, if images are missing or differ in size, or if there
    /// are too many or too large images; see [`BtfStack::open`] and [`UboBtfFile::open`].
    pub fn open(path: &Path) -> Result<Self, InputError> {
        Self::open_as(path, None)
    }

    /// Same as [`Self::open`], with the meaning of code values in spite of what the images of a folder state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`].
    pub fn open_as(path: &Path, codes: Option<CodeValues>) -> Result<Self, InputError> {
        Ok(if path.is_dir() {
            Self::Stack(BtfStack::open_as(path, codes)?)
        } else {
            Self::Ubo(Box::new(UboBtfFile::open(path)?))
        })
    }

    /// Directions to the viewer.
    pub fn views(&self) -> &DirectionSet {
        match self {
            Self::Stack(stack) => stack.views(),
            Self::Ubo(file) => file.views(),
        }
    }

    /// Directions to the light.
    pub fn lights(&self) -> &DirectionSet {
        match self {
            Self::Stack(stack) => stack.lights(),
            Self::Ubo(file) => file.lights(),
        }
    }

    /// Width and height of every image, pixels.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Stack(stack) => stack.size(),
            Self::Ubo(file) => file.size(),
        }
    }

    /// Colour of the code values of the images of a folder, and how they are converted.
    pub fn colour(&self) -> Option<&str> {
        match self {
            Self::Stack(stack) => Some(stack.colour()),
            Self::Ubo(_) => None,
        }
    }

    /// Differences in colour, and other statements of the images that are applied.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Stack(stack) => stack.notes(),
            Self::Ubo(_) => &[],
        }
    }

    /// Reads or computes one image, by its indices in [`Self::views`] and [`Self::lights`]: radiance over the radiance
    /// of a white diffuser that faces the light.
    ///
    /// # Errors
    /// Returns an error for an index out of range, and for an image file that cannot be read, has changed its size or
    /// has values that are not finite.
    pub fn image(&self, view: usize, light: usize) -> Result<Image, InputError> {
        match self {
            Self::Stack(stack) => stack.view(view, light),
            Self::Ubo(file) => file.image(view, light),
        }
    }
}
