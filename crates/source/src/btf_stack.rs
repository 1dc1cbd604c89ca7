//! Folders of images, one per view and light: a BTF as it was measured.

use crate::InputError;
use crate::exr_header::exr_headers;
use brdfc_formats::FormatError;
use brdfc_formats::colour::decode_srgb;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::measured::btf_stack::{StackContents, StackIndex, is_image};
use image::{DynamicImage, ImageError, ImageFormat, ImageReader};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Most pixels per row and rows of an image.
pub const MAX_SIZE: u32 = 4096;
/// Levels of folders that are searched: the stack's own and those in it.
const LEVELS: usize = 2;
/// Most files and folders that are looked at.
const MAX_ENTRIES: usize = 1 << 20;
/// Most memory that decoding one image may take: four f32 per pixel of the largest, twice.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// A complete stack of images of one size. The tile is rectified to the plane z = 0.
///
/// Values are radiance divided by that of a white diffuser that faces the light: 1 is white.
pub struct BtfStack {
    folder: PathBuf,
    index: StackIndex,
    size: [usize; 2],
    /// Linear value of each 16-bit sRGB code.
    srgb: Vec<f32>,
}

/// One image of a stack.
///
/// Row 0 is the top of the tile, y = 1: pixel (column, row) has its centre at `((column + ½) / width,
/// 1 - (row + ½) / height)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB (Rec. 709 primaries), row by row from the top, left to right.
    pub pixels: Vec<[f32; 3]>,
}

impl BtfStack {
    /// Opens a folder, whose images may stand in folders of their own. Linked folders are not entered.
    ///
    /// Reads the header of every image, and no pixels.
    ///
    /// # Errors
    /// What cannot be read; what [`StackIndex::new`] refuses; what is no PNG, JPEG or EXR; images of different sizes or
    /// of more than [`MAX_SIZE`] pixels along a side.
    pub fn open(folder: &Path) -> Result<Self, InputError> {
        let mut paths = Vec::new();
        let mut entries = 0;
        list(folder, "", LEVELS, &mut entries, &mut paths)?;
        let mut index = StackIndex::new(&paths).map_err(|error| format_error(folder, error))?;
        (index.views.name, index.lights.name) = ("of the images".to_owned(), "of the images".to_owned());
        let size = common_size(folder, &index.files)?;
        let srgb = (0..=u16::MAX).map(|code| decode_srgb(f64::from(code) / 65535.0) as f32).collect();
        Ok(Self { folder: folder.to_owned(), index, size: size.map(|n| n as usize), srgb })
    }

    /// Directions to the viewer.
    pub fn views(&self) -> &DirectionSet {
        &self.index.views
    }

    /// Directions to the light.
    pub fn lights(&self) -> &DirectionSet {
        &self.index.lights
    }

    /// Pixels per row, and rows, of every image.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Reads one image, by its indices in [`BtfStack::views`] and [`BtfStack::lights`]. Nothing is kept.
    ///
    /// PNG and JPEG hold sRGB codes whatever their colour profile says, EXR linear values; alpha is ignored.
    ///
    /// # Errors
    /// An index that the stack has not; a file that cannot be read or decoded, or is no longer of the size that it had;
    /// values that are no finite numbers.
    pub fn view(&self, view: usize, light: usize) -> Result<Image, InputError> {
        for (field, index, count) in [("view", view, self.views().len()), ("light", light, self.lights().len())] {
            if index >= count {
                let error = FormatError::whole(field, index.to_string(), format!("less than {count}"));
                return Err(format_error(&self.folder, error));
            }
        }
        let path = self.folder.join(self.index.file(view, light));
        let mut reader = reader(&path)?;
        if reader.format() == Some(ImageFormat::OpenExr) {
            check_exr(&path)?;
        }
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_SIZE);
        limits.max_image_height = Some(MAX_SIZE);
        limits.max_alloc = Some(MAX_DECODER_BYTES);
        reader.limits(limits);
        let decoded = reader.decode().map_err(|error| image_error(&path, error))?;
        let [width, height] = self.size;
        if [decoded.width() as usize, decoded.height() as usize] != self.size {
            let found = format!("{} x {}", decoded.width(), decoded.height());
            let error = FormatError::whole("image size", found, format!("{width} x {height}, as when it was opened"));
            return Err(format_error(&path, error));
        }
        let pixels = self.linear(decoded);
        if let Some(at) = pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite())) {
            let found = format!("{:?} at ({}, {})", pixels[at], at % width, at / width);
            return Err(format_error(&path, FormatError::whole("pixel", found, "finite values")));
        }
        Ok(Image { width, height, pixels })
    }

    fn linear(&self, decoded: DynamicImage) -> Vec<[f32; 3]> {
        match decoded {
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
                decoded.into_rgb32f().pixels().map(|pixel| pixel.0).collect()
            }
            // 8-bit codes become 16-bit codes of the same value: times 257.
            _ => decoded.into_rgb16().pixels().map(|pixel| pixel.0.map(|code| self.srgb[usize::from(code)])).collect(),
        }
    }
}

/// What a folder of images has, be it complete or not, and the size of its images.
///
/// # Errors
/// As [`BtfStack::open`], but for missing images.
pub fn survey(folder: &Path) -> Result<(StackContents, [u32; 2]), InputError> {
    let mut paths = Vec::new();
    list(folder, "", LEVELS, &mut 0, &mut paths)?;
    let contents = StackContents::new(&paths).map_err(|error| format_error(folder, error))?;
    let size = common_size(folder, &contents.files)?;
    Ok((contents, size))
}

/// Whether a folder, or a folder in it, has a file with the extension of an image.
pub fn has_images(folder: &Path) -> bool {
    let mut paths = Vec::new();
    list(folder, "", LEVELS, &mut 0, &mut paths).is_ok() && paths.iter().any(|path| is_image(path))
}

/// The size of all images.
fn common_size(folder: &Path, files: &[String]) -> Result<[u32; 2], InputError> {
    let mut size = [0; 2];
    for file in files {
        let found = image_size(&folder.join(file))?;
        if *file == files[0] {
            size = found;
        }
        if found != size {
            let allowed = format!("{} x {}, as {} has", size[0], size[1], files[0]);
            let error = FormatError::whole("image size", format!("{} x {}", found[0], found[1]), allowed);
            return Err(format_error(&folder.join(file), error));
        }
    }
    Ok(size)
}

/// Files below `folder`, with `/` between folders, behind `prefix`.
fn list(
    folder: &Path,
    prefix: &str,
    levels: usize,
    entries: &mut usize,
    paths: &mut Vec<String>,
) -> Result<(), InputError> {
    for entry in std::fs::read_dir(folder).map_err(|error| io_error(folder, error))? {
        let entry = entry.map_err(|error| io_error(folder, error))?;
        *entries += 1;
        if *entries > MAX_ENTRIES {
            let found = format!("more than {MAX_ENTRIES}");
            return Err(format_error(folder, FormatError::whole("files and folders", found, "a stack of images")));
        }
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        // The kind of a link is that of the link itself: no loops.
        let kind = entry.file_type().map_err(|error| io_error(&entry.path(), error))?;
        if kind.is_dir() {
            if levels > 1 {
                list(&entry.path(), &format!("{name}/"), levels - 1, entries, paths)?;
            }
        } else if kind.is_file() || entry.path().is_file() {
            paths.push(name);
        }
    }
    Ok(())
}

fn reader(path: &Path) -> Result<ImageReader<std::io::BufReader<std::fs::File>>, InputError> {
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let reader = reader.map_err(|error| io_error(path, error))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::OpenExr) => Ok(reader),
        _ => Err(format_error(path, FormatError::whole("image", "some other layout", "PNG, JPEG or EXR"))),
    }
}

/// The decoder has no limit of what it asks for to decode a block.
fn check_exr(path: &Path) -> Result<(), InputError> {
    let file = std::fs::File::open(path).map_err(|error| io_error(path, error))?;
    let headers = exr_headers(std::io::BufReader::new(file), "a whole PNG, JPEG or EXR image");
    headers.map(drop).map_err(|error| format_error(path, error))
}

fn image_size(path: &Path) -> Result<[u32; 2], InputError> {
    let (width, height) = reader(path)?.into_dimensions().map_err(|error| image_error(path, error))?;
    if (1..=MAX_SIZE).contains(&width) && (1..=MAX_SIZE).contains(&height) {
        return Ok([width, height]);
    }
    let allowed = format!("1 to {MAX_SIZE} along each side");
    Err(format_error(path, FormatError::whole("image size", format!("{width} x {height}"), allowed)))
}

fn image_error(path: &Path, error: ImageError) -> InputError {
    match error {
        // These say that the file ends early or is broken, not that it cannot be read.
        ImageError::IoError(error)
            if ![ErrorKind::UnexpectedEof, ErrorKind::InvalidData, ErrorKind::Other].contains(&error.kind()) =>
        {
            io_error(path, error)
        }
        ImageError::Limits(_) => {
            let allowed = format!("1 to {MAX_SIZE} along each side");
            format_error(path, FormatError::whole("image size", "more pixels than a decoder takes", allowed))
        }
        error => format_error(path, FormatError::whole("image", error.to_string(), "a whole PNG, JPEG or EXR image")),
    }
}

fn format_error(path: &Path, error: FormatError) -> InputError {
    InputError::Format { name: path.display().to_string(), error }
}

fn io_error(path: &Path, error: std::io::Error) -> InputError {
    InputError::Io { name: path.display().to_string(), error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes() {
        for (code, linear) in [(0.0, 0.0), (1.0, 1.0), (188.0 / 255.0, 0.502_886_5), (10.0 / 255.0, 0.003_035_27)] {
            assert!((decode_srgb(code) - linear).abs() < 1e-7, "{code}");
        }
    }
}
