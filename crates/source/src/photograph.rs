//! Photographs: PNG, JPEG, TIFF and EXR images of a BTF stack or RTI capture.

use crate::InputError;
use crate::image_file::{self, Ask, Header, Purpose};
use crate::tile_image::FileImage;
use brdfc_formats::FormatError;
use brdfc_readers::pixels::Pixels;
use image::ImageFormat;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

pub use crate::image_file::CodeValues;

/// Maximum width and height of an image, pixels.
pub const MAX_SIZE: usize = 16384;
/// Maximum number of pixels of an image: 12 bytes each are less than 2 GiB.
pub const MAX_PIXELS: usize = 160_000_000;
/// Files that [`read_pixels`] reads.
const ALLOWED: &str = "a complete PNG, JPEG, TIFF or EXR image";
const FORMATS: [ImageFormat; 4] = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::OpenExr];

/// A photograph: linear RGB (Rec. 709 primaries), 1 is the full scale of integer formats.
///
/// Row 0 is the top, y = 1: the centre of pixel (column, row) is at `((column + ½) / width, 1 - (row + ½) / height)`.
pub type Image = FileImage<3>;

/// Common properties of the headers of several photographs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Common {
    /// Width and height, 0 without photographs.
    pub size: [usize; 2],
    /// Bytes of all [`Pixels`].
    pub bytes: u64,
    /// Colour of the code values, and how they are converted.
    pub colour: String,
    /// Differences in colour, and other statements of the files that are applied.
    pub notes: Vec<String>,
}

impl Image {
    /// Reads an image of `size`, width and height in pixels, as [`read_pixels`] does.
    ///
    /// # Errors
    /// Returns the errors of [`read_pixels`].
    pub(crate) fn read(path: &Path, size: [usize; 2], codes: Option<CodeValues>) -> Result<Self, InputError> {
        Ok(Self::new(size, read_pixels(path, size, codes)?.into_linear()))
    }
}

/// Reads the pixels of an image of `size`, width and height in pixels.
///
/// Converts colours as the file states them, unless `codes` says what they are. Integers without a statement are sRGB,
/// and floats linear. Alpha is ignored; a TIFF whose colours are multiplied by it is rejected unless alpha
/// is 1 everywhere.
///
/// # Errors
/// Returns an error for a file that cannot be read or decoded, or has another size, and for values that are not
/// finite.
pub(crate) fn read_pixels(path: &Path, size: [usize; 2], codes: Option<CodeValues>) -> Result<Pixels, InputError> {
    let wrong = |error| InputError::format(path, error);
    let (mut header, raster) = image_file::read(open(path)?, &ask(codes)).map_err(wrong)?;
    if raster.size != size {
        let [[width, height], found] = [size, raster.size];
        let found = format!("{} x {}", found[0], found[1]);
        let allowed = format!("{width} x {height}, the size when it was opened");
        return Err(wrong(FormatError::whole("image size", found, allowed)));
    }
    let pixels = header.pixels(raster).map_err(wrong)?;
    if let Pixels::Linear(pixels) = &pixels
        && let Some(at) = pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite()))
    {
        let found = format!("{:?} at ({}, {})", pixels[at], at % size[0], at / size[0]);
        return Err(wrong(FormatError::whole("pixel", found, "finite values")));
    }
    Ok(pixels)
}

/// Reads the headers of all images.
///
/// # Errors
/// Returns an error for files that cannot be read or are not PNG, JPEG, TIFF or EXR, for images of different sizes or
/// orientations, or with more than [`MAX_SIZE`] pixels along a side or [`MAX_PIXELS`] in all. `first` names the first
/// image in errors.
pub(crate) fn common_header(paths: &[PathBuf], first: &str, codes: Option<CodeValues>) -> Result<Common, InputError> {
    let mut common = Common::default();
    let (mut colours, mut notes, mut grey) = (BTreeMap::new(), BTreeMap::new(), 0);
    let mut of_first: Option<Header> = None;
    for path in paths {
        let wrong = |error| InputError::format(path, error);
        let header = image_file::read_header(&mut open(path)?, &ask(codes)).map_err(wrong)?;
        let [width, height] = header.size;
        common.bytes += header.pixel_bytes() * width as u64 * height as u64;
        *colours.entry(header.colour.to_string()).or_insert(0) += 1;
        grey += usize::from(header.channels < 3);
        for note in header.conversions().into_iter().skip(1) {
            *notes.entry(note).or_insert(0) += 1;
        }
        let of_first = of_first.get_or_insert_with(|| header.clone());
        if header.orientation != of_first.orientation {
            let allowed = format!("{}, that of {first}", of_first.orientation);
            return Err(wrong(FormatError::whole("orientation", header.orientation.to_string(), allowed)));
        }
        if header.size != of_first.size {
            let allowed = format!("{} x {}, the size of {first}", of_first.size[0], of_first.size[1]);
            return Err(wrong(FormatError::whole("image size", format!("{width} x {height}"), allowed)));
        }
    }
    common.size = of_first.map_or([0; 2], |header| header.size);
    let of = |(text, count): (&String, &usize)| match *count == paths.len() {
        true => text.clone(),
        false => format!("{text} ({count} of {} images)", paths.len()),
    };
    common.colour = colours.iter().map(of).collect::<Vec<_>>().join("; ");
    let mixed = (colours.len() > 1).then(|| format!("the images state different colours: {}", common.colour));
    let is_partly_grey = (1..paths.len()).contains(&grey);
    let partly_grey =
        is_partly_grey.then(|| format!("{} of {} images are grey, the others have colours", grey, paths.len()));
    common.notes = mixed.into_iter().chain(partly_grey).chain(notes.iter().map(of)).collect();
    Ok(common)
}

fn ask(codes: Option<CodeValues>) -> Ask<'static> {
    Ask { purpose: Purpose::Colours(codes), field: "image", allowed: ALLOWED, formats: &FORMATS, check: &check_size }
}

fn check_size([width, height]: [usize; 2]) -> Result<(), FormatError> {
    if width.max(height) <= MAX_SIZE && width * height <= MAX_PIXELS {
        return Ok(());
    }
    let allowed = format!("1 to {MAX_SIZE} along each side, and at most {MAX_PIXELS} pixels");
    Err(FormatError::whole("image size", format!("{width} x {height}"), allowed))
}

fn open(path: &Path) -> Result<BufReader<File>, InputError> {
    File::open(path).map(BufReader::new).map_err(|error| InputError::io(path, error))
}
