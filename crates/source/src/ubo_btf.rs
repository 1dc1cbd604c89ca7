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

/// Extension of such files, without the point.
pub const EXTENSION: &str = "btf";
/// Most bytes of a file; its matrices take no more memory than the file itself.
pub const MAX_BYTES: u64 = 4 << 30;

/// A file whose matrices are in memory; images are computed when they are asked for.
pub struct UboBtfFile {
    path: PathBuf,
    btf: UboBtf,
    /// What brings values under each light to radiance relative to a white diffuser that faces it.
    factors: Vec<f32>,
}

impl UboBtfFile {
    /// Opens a file.
    ///
    /// # Errors
    /// What cannot be read; more than [`MAX_BYTES`]; what [`UboBtf::from_reader`] refuses.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let (mut file, length) = open_path(path)?;
        check_length(length, MAX_BYTES).map_err(|error| InputError::format(path, error))?;
        let btf = UboBtf::from_reader(BufReader::new(&mut file)).map_err(|error| match error {
            ReadError::Io(error) => InputError::io(path, error),
            ReadError::Format(error) => {
                let mut start = Vec::new();
                let again = file.seek(SeekFrom::Start(0));
                let read = again.and_then(|_| file.take(START_BYTES as u64).read_to_end(&mut start));
                // The layout's error says more than that the start cannot be read again.
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

    /// Texels per row, and rows.
    pub fn size(&self) -> [usize; 2] {
        self.btf.description().size
    }

    /// What the file says of itself.
    pub fn description(&self) -> &Description {
        self.btf.description()
    }

    /// The BTF as it stands in the file: values without the cosine of the light, unless it says that they have it.
    pub fn btf(&self) -> &UboBtf {
        &self.btf
    }

    /// Computes one image: radiance divided by that of a white diffuser that faces the light, row 0 at the top.
    ///
    /// # Errors
    /// Indices that [`Self::views`] and [`Self::lights`] have not.
    pub fn image(&self, view: usize, light: usize) -> Result<Image, InputError> {
        let mut pixels = self.btf.image(view, light).map_err(|error| InputError::format(&self.path, error))?;
        // The light is one of the file's, or there is no image.
        let factor = self.factors[light];
        pixels.iter_mut().flatten().for_each(|value| *value *= factor);
        let [width, height] = self.size();
        Ok(Image { width, height, pixels })
    }
}

/// Whether a path has the extension of such files.
pub fn is_ubo_btf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}
