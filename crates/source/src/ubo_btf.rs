//! BTFs of the Bonn database of 2014, as images of an ordinary BTF. Layout: `crates/readers/src/ubo_btf.md`.

use crate::InputError;
use crate::misnamed::wrong_contents;
use crate::photograph::Image;
use crate::read::{check_length, open_path};
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::recognise::START_BYTES;
use brdfc_readers::ubo_btf::{Description, ReadError, UboBtf};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Extension of the files.
pub const EXTENSION: &str = "btf";
/// Maximum size of a file, bytes; its matrices take no more memory than the file.
pub const MAX_BYTES: u64 = 4 << 30;

/// A file with its matrices in memory; images are computed on demand.
pub struct UboBtfFile {
    path: PathBuf,
    btf: UboBtf,
    /// Factor of each light that converts values to radiance relative to a white diffuser that faces the light.
    factors: Vec<f32>,
}

impl UboBtfFile {
    /// Opens a file.
    ///
    /// # Errors
    /// Returns an error for files that cannot be read, have more than [`MAX_BYTES`], or that [`UboBtf::from_reader`]
    /// rejects.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let (mut file, length) = open_path(path)?;
        check_length(length, MAX_BYTES).map_err(|error| InputError::format(path, error))?;
        let btf = UboBtf::from_reader(BufReader::new(&mut file)).map_err(|error| match error {
            ReadError::Io(error) => InputError::io(path, error),
            ReadError::Format(error) => {
                let mut start = Vec::new();
                let again = file.seek(SeekFrom::Start(0));
                let read = again.and_then(|_| file.take(START_BYTES as u64).read_to_end(&mut start));
                // The error of the layout is more helpful than an error of reading the start again.
                read.map_or_else(
                    |_| InputError::format(path, error.clone()),
                    |_| wrong_contents(path, &start, length, error.clone()),
                )
            }
        })?;
        let description = btf.description();
        let cosine = |light: [f64; 3]| if description.has_cosine { 1.0 } else { light[2] as f32 };
        let factors = description.lights.directions().into_iter().map(cosine).collect();
        Ok(Self { path: path.to_owned(), btf, factors })
    }

    /// Directions to the viewer.
    pub fn views(&self) -> &DirectionSet {
        &self.btf.description().views
    }

    /// Directions to the light.
    pub fn lights(&self) -> &DirectionSet {
        &self.btf.description().lights
    }

    /// Width and height, texels.
    pub fn size(&self) -> [usize; 2] {
        self.btf.description().size
    }

    /// Description in the file.
    pub fn description(&self) -> &Description {
        self.btf.description()
    }

    /// The BTF as stored: values without the cosine of the light, unless the file declares that they include it.
    pub fn btf(&self) -> &UboBtf {
        &self.btf
    }

    /// Computes one image: radiance over the radiance of a white diffuser that faces the light, row 0 at the top.
    ///
    /// # Errors
    /// Returns an error for indices out of range of [`Self::views`] and [`Self::lights`].
    pub fn image(&self, view: usize, light: usize) -> Result<Image, InputError> {
        let mut pixels = self.btf.image(view, light).map_err(|error| InputError::format(&self.path, error))?;
        // The light is in range, because the image exists.
        let factor = self.factors[light];
        pixels.iter_mut().flatten().for_each(|value| *value *= factor);
        Ok(Image::new(self.size(), pixels))
    }
}
