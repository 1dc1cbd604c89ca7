//! RTI captures: photographs of one view under known lights. Layout: `crates/readers/src/rti_capture.md`.

use crate::InputError;
use crate::misnamed::wrong_contents;
use crate::photograph::{CodeValues, Common, Image, common_header, read_pixels};
use crate::read::{MAX_TEXT_BYTES, extension_of, read_file};
use brdfc_core::words::{counted, format_number, join_truncated};
use brdfc_formats::FormatError;
use brdfc_readers::near_lights::NearLights;
use brdfc_readers::pixels::Pixels;
use brdfc_readers::rti_capture::{LightPositions, is_above};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use unicode_normalization::UnicodeNormalization as _;

/// Extension of the lists of lights.
pub const EXTENSION: &str = "lp";
/// Extensions of photographs.
const IMAGES: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "exr"];
/// Maximum number of files of a folder that are read.
const MAX_ENTRIES: usize = 1 << 20;
/// Minimum distance of a near light from the images, and maximum distance from their middle, in widths of them.
const MIN_DISTANCE: f64 = 0.1;
const MAX_DISTANCE: f64 = 1000.0;
/// Maximum distance of a near light from the middle, relative to that of the nearest.
const MAX_RATIO: f64 = 10.0;
/// Number of lights that a note names.
const MAX_NAMED: usize = 3;

/// An RTI capture: photographs of one view and of one size, each under one light.
#[derive(Debug, Clone)]
pub struct RtiCapture {
    directions: Vec<[f32; 3]>,
    near: Option<NearLights>,
    files: Vec<PathBuf>,
    common: Common,
    codes: Option<CodeValues>,
    notes: Vec<String>,
}

impl RtiCapture {
    /// Opens an `.lp` file, or a folder that has exactly one `.lp` file.
    ///
    /// Reads the header of every image, and no pixels. Leaves out lights whose image is missing, and lights behind the
    /// plane of the images; [`Self::notes`] name them.
    ///
    /// # Errors
    /// Returns an error for unreadable files, lists that [`LightPositions::from_bytes`] rejects, no list or several,
    /// no image of a light above the horizon, the same image twice, near lights whose distances are out of range, files that are not PNG, JPEG, TIFF or EXR, and
    /// images of different sizes or orientations or with more than [`MAX_SIZE`](crate::photograph::MAX_SIZE) pixels along
    /// a side.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        Self::open_as(path, None)
    }

    /// Same as [`Self::open`], with the meaning of code values in spite of what the images state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`].
    pub fn open_as(path: &Path, codes: Option<CodeValues>) -> Result<Self, InputError> {
        let (list, lights) = read_list(path)?;
        let (files, mut notes) = files(&list, &lights)?;
        let first = files.first().map_or("", |(light, _)| &lights.names[*light]);
        let directions = files.iter().map(|(light, _)| lights.directions[*light]).collect();
        let of_files = |positions: &Vec<[f64; 3]>| files.iter().map(|(light, _)| positions[*light]).collect();
        let positions: Option<Vec<[f64; 3]>> = lights.positions.as_ref().map(of_files);
        let lines: Vec<u64> = files.iter().map(|(light, _)| lights.lines[*light]).collect();
        let files: Vec<PathBuf> = files.into_iter().map(|(_, file)| file).collect();
        let common = common_header(&files, first, codes)?;
        notes.extend_from_slice(&common.notes);
        let near = positions.map(|positions| NearLights::new(positions, common.size));
        if let Some(near) = &near {
            check_distances(near, &lines).map_err(|error| InputError::format(&list, error))?;
        }
        Ok(Self { directions, near, files, common, codes, notes })
    }

    /// Colour of the code values of the images, and how they are converted.
    pub fn colour(&self) -> &str {
        &self.common.colour
    }

    /// Differences between the list and the capture: lights that are left out, and a number that does not fit; and
    /// statements of the images other than their colour that are applied.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Unit vectors to the lights, z > 0: x to the right of the images, y up, z to the viewer. For near lights from the middle of
    /// the images.
    pub fn lights(&self) -> &[[f32; 3]] {
        &self.directions
    }

    /// Positions of the lights, if they are near.
    pub fn near(&self) -> Option<&NearLights> {
        self.near.as_ref()
    }

    /// Width and height of every image, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.common.size
    }

    /// Bytes of the pixels of all images, as [`Self::pixels`] returns them.
    pub fn bytes(&self) -> u64 {
        self.common.bytes
    }

    /// Number of lights and images: at least one.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// File of the image under a light.
    ///
    /// # Panics
    /// Panics if the light does not exist.
    pub fn file(&self, light: usize) -> &Path {
        &self.files[light]
    }

    /// Reads the image of a light as linear values, without caching it.
    ///
    /// # Errors
    /// Returns the errors of [`Self::pixels`].
    pub fn image(&self, light: usize) -> Result<Image, InputError> {
        Ok(Image::new(self.size(), self.pixels(light)?.into_linear()))
    }

    /// Reads the image of a light, without caching it.
    ///
    /// Colours are converted as the file states them; see [`Self::colour`]. Alpha is ignored.
    ///
    /// # Errors
    /// Returns an error for an index out of range, a file that cannot be read or decoded or has changed its size, and
    /// values that are not finite.
    pub fn pixels(&self, light: usize) -> Result<Pixels, InputError> {
        let Some(file) = self.files.get(light) else {
            let error = FormatError::whole("light", light.to_string(), format!("less than {}", self.len()));
            return Err(InputError::format(self.files[0].parent().unwrap_or(Path::new("")), error));
        };
        read_pixels(file, self.size(), self.codes)
    }

    /// Facts about the capture.
    pub fn facts(&self) -> RtiCaptureFacts {
        let polar = |direction: &[f32; 3]| {
            let [x, y, z] = direction.map(f64::from);
            x.hypot(y).atan2(z).to_degrees()
        };
        // Directions have the precision of 32-bit floats.
        let angles = self.directions.iter().map(polar);
        let (least, most) = angles.fold((90.0f64, 0.0f64), |(least, most), angle| (least.min(angle), most.max(angle)));
        let extensions: BTreeSet<String> = self.files.iter().map(|file| extension_of(file)).collect();
        RtiCaptureFacts {
            lights: self.len(),
            polar_angles: [least, most].map(rounded),
            distances: self.near.as_ref().map(|near| near.range().map(rounded)),
            size: self.size(),
            colour: self.colour().to_owned(),
            extensions: extensions.into_iter().collect(),
            notes: self.notes.clone(),
        }
    }
}

/// Facts about an RTI capture.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct RtiCaptureFacts {
    /// Number of lights, each with one image.
    pub lights: usize,
    /// Smallest and largest angle between a light and the direction of view, degrees.
    pub polar_angles: [f64; 2],
    /// Smallest and largest distance of near lights from the middle of the images, in widths of them; absent for distant lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distances: Option<[f64; 2]>,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Colour of the code values of the images, and how they are converted.
    pub colour: String,
    /// Extensions of the images, in lower case, without duplicates.
    pub extensions: Vec<String>,
    /// Differences between the list and the capture, such as lights without an image, and other statements of the images
    /// that are applied, such as their orientation.
    pub notes: Vec<String>,
}

impl RtiCaptureFacts {
    /// Lines for people: names and values.
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let Self { lights, polar_angles: [least, most], distances, size: [width, height], colour, extensions, notes } =
            self;
        let mut lines = vec![
            ("kind", "RTI capture: photographs of one view under known lights".to_owned()),
            ("lights", lights.to_string()),
            ("angles to the view", format!("{least} to {most} degrees")),
        ];
        let near = distances.map(|distances| format!("{} image widths from the middle", format_range(distances)));
        lines.extend(near.map(|near| ("near lights", near)));
        lines.push(("images", format!(".{}", extensions.join(", ."))));
        lines.push(("pixels", format!("{width} x {height}")));
        lines.push(("colour", colour.clone()));
        lines.extend(notes.iter().map(|note| ("note", note.clone())));
        lines
    }
}

fn rounded(number: f64) -> f64 {
    (number * 1e3).round() / 1e3
}

/// Formats a range of distances; once if both ends are equal.
pub fn format_range([least, most]: [f64; 2]) -> String {
    let [least, most] = [least, most].map(rounded);
    if least == most { least.to_string() } else { format!("{least} to {most}") }
}

/// Checks the distances of near lights.
fn check_distances(near: &NearLights, lines: &[u64]) -> Result<(), FormatError> {
    let wrong = |light: usize, found: f64, place: &str, allowed: String| {
        let found = format!("{} image widths from the {place}", format_number(rounded(found)));
        Err(FormatError::at_line(lines[light], "position", found, allowed))
    };
    if let Some((light, distance)) = near.clearances().enumerate().find(|(_, distance)| *distance < MIN_DISTANCE) {
        return wrong(light, distance, "images", format!("{MIN_DISTANCE} or more"));
    }
    // A position in another unit; all lights have the same intensity.
    let nearest = near.range()[0];
    let most = (MAX_RATIO * nearest).min(MAX_DISTANCE);
    if let Some((light, distance)) = near.distances().enumerate().find(|(_, distance)| *distance > most) {
        let allowed = format!("at most {}; the nearest light is {} away", rounded(most), rounded(nearest));
        return wrong(light, distance, "middle", allowed);
    }
    Ok(())
}

/// Returns true if a path is a list of lights by its name, or a folder with such a list.
pub(crate) fn is_rti_capture(path: &Path) -> bool {
    if path.is_dir() { lists(path).is_ok_and(|lists| !lists.is_empty()) } else { extension_of(path) == EXTENSION }
}

/// Lists of lights in a folder, sorted.
fn lists(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let mut found = Vec::new();
    let io = |error| InputError::io(folder, error);
    for (number, entry) in std::fs::read_dir(folder).map_err(io)?.enumerate() {
        if number == MAX_ENTRIES {
            let error = FormatError::whole("files", format!("more than {MAX_ENTRIES}"), "the files of one RTI capture");
            return Err(InputError::format(folder, error));
        }
        let path = entry.map_err(io)?.path();
        if extension_of(&path) == EXTENSION && path.is_file() && !is_of_macos(&path) {
            found.push(path);
        }
    }
    found.sort_unstable();
    Ok(found)
}

/// Finds and reads the list of a path.
fn read_list(path: &Path) -> Result<(PathBuf, LightPositions), InputError> {
    let list = if path.is_dir() { the_list(path)? } else { path.to_owned() };
    let bytes = read_file(&list, MAX_TEXT_BYTES)?;
    let lights =
        LightPositions::from_bytes(&bytes).map_err(|error| wrong_contents(&list, &bytes, bytes.len() as u64, error))?;
    Ok((list, lights))
}

/// The list of an RTI capture and its existing photographs, complete or not. All lists of a folder if none can be read.
pub(crate) fn files_of_stack(path: &Path) -> Vec<PathBuf> {
    let Ok((list, lights)) = read_list(path) else { return lists(path).unwrap_or_default() };
    let folder = list.parent().unwrap_or(Path::new(""));
    photographs(folder, &lights.names).into_iter().flatten().chain([list]).collect()
}

fn the_list(folder: &Path) -> Result<PathBuf, InputError> {
    let mut found = lists(folder)?;
    if let (Some(list), true) = (found.pop(), found.is_empty()) {
        return Ok(list);
    }
    let all = lists(folder)?;
    let names: Vec<String> =
        all.iter().filter_map(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned()).collect();
    let allowed = "one .lp file in the folder, or the path of one";
    let error = match names.is_empty() {
        true => FormatError::whole("lists of lights", "no .lp file", allowed).problem(),
        false => FormatError::whole("lists of lights", names.join(", "), allowed),
    };
    Err(InputError::format(folder, error))
}

/// Lights with an image, and notes about others.
type Found = (Vec<(usize, PathBuf)>, Vec<String>);

/// Finds the image of each light above the horizon, and describes the other lights.
fn files(list: &Path, lights: &LightPositions) -> Result<Found, InputError> {
    let folder = list.parent().unwrap_or(Path::new(""));
    let (mut files, mut missing, mut behind, mut similar) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut seen = BTreeMap::new();
    let lines = lights.names.iter().zip(&lights.lines).enumerate();
    for ((light, (name, line)), file) in lines.zip(photographs(folder, &lights.names)) {
        let named = || format!("{name} (line {line})");
        let Some(file) = file else {
            missing.push(named());
            continue;
        };
        if let Some(found) = file.file_name().filter(|found| **found != *last_component(name)) {
            similar.push(format!("{} for {}", found.display(), named()));
        }
        let whole = file.canonicalize().map_err(|error| InputError::io(&file, error))?;
        if let Some(before) = seen.insert(whole, line) {
            let found = format!("{name:?} is already on line {before}");
            let error = FormatError::at_line(*line, "image", found, "each image once").problem();
            return Err(InputError::format(list, error));
        }
        if is_above(&lights.directions[light]) {
            files.push((light, file));
        } else {
            behind.push(named());
        }
    }
    if files.is_empty() {
        // Lists have a light above the horizon, and its image is missing.
        let light = lights.directions.iter().position(is_above).unwrap_or(0);
        let found = format!("{:?} does not exist, like all images of lights above the horizon", lights.names[light]);
        let allowed = "a path, or a file next to this one";
        let error = FormatError::at_line(lights.lines[light], "image", found, allowed);
        return Err(InputError::format(list, error.problem()));
    }
    let count = lights.names.len() + lights.not_finite.len();
    let stated = lights.stated.filter(|stated| *stated != count);
    let stated = stated.map(|stated| format!("the list states {} and has {count}", counted(stated, "light")));
    let left_out = |names: &[String], why: &str| {
        let named = join_truncated(names, MAX_NAMED);
        (!names.is_empty()).then(|| format!("left out {}, {why}: {named}", counted(names.len(), "light")))
    };
    let not_finite: Vec<String> =
        lights.not_finite.iter().map(|(name, line)| format!("{name} (line {line})")).collect();
    let renamed = (!similar.is_empty()).then(|| {
        let named = join_truncated(&similar, MAX_NAMED);
        format!("found {} under a similar name: {named}", counted(similar.len(), "image"))
    });
    let others = [
        left_out(&missing, "without an image"),
        left_out(&behind, "at or below the horizon"),
        left_out(&not_finite, "with a vector that is not finite"),
        renamed,
    ];
    Ok((files, stated.into_iter().chain(others.into_iter().flatten()).collect()))
}

/// Returns true for a file of attributes that macOS writes next to others on disks of other systems.
pub(crate) fn is_of_macos(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("._"))
}

/// Finds the file of each name: by its path, or else by its last component in the folder. Names without one take a file of the
/// folder that no other name has: the only one whose name differs in case or in the form of its accents, or else in the
/// extension of an image.
fn photographs(folder: &Path, names: &[String]) -> Vec<Option<PathBuf>> {
    let exact = |name: &String| {
        let slashes = name.replace('\\', "/");
        let candidates = [name, &*slashes, last_component(name)];
        candidates.into_iter().map(|name| folder.join(name)).find(|path| path.is_file())
    };
    let mut found: Vec<Option<PathBuf>> = names.iter().map(exact).collect();
    if found.iter().all(Option::is_some) {
        return found;
    }
    let taken: BTreeSet<PathBuf> = found.iter().flatten().filter_map(|path| path.canonicalize().ok()).collect();
    let paths = std::fs::read_dir(folder).into_iter().flatten().take(MAX_ENTRIES).flatten().map(|entry| entry.path());
    let is_free = |path: &PathBuf| {
        path.is_file() && !is_of_macos(path) && path.canonicalize().is_ok_and(|path| !taken.contains(&path))
    };
    let mut left: BTreeSet<PathBuf> = paths.filter(is_free).collect();
    let whole = |name: &str| Some(name.to_owned());
    let without_extension = |name: &str| stem(name).map(str::to_owned);
    for key in [&whole as &dyn Fn(&str) -> Option<String>, &without_extension] {
        let mut listed = BTreeMap::<String, Vec<&PathBuf>>::new();
        for path in &left {
            let name = normalised(&path.file_name().unwrap_or_default().to_string_lossy());
            if let Some(name) = key(&name) {
                listed.entry(name).or_default().push(path);
            }
        }
        for (found, name) in found.iter_mut().zip(names).filter(|(found, _)| found.is_none()) {
            let paths = key(&normalised(last_component(name))).and_then(|name| listed.remove(&name));
            *found = paths.filter(|paths| paths.len() == 1).map(|paths| paths[0].clone());
        }
        found.iter().flatten().for_each(|path| _ = left.remove(path));
    }
    found
}

/// A name without the extension of an image; `None` for others.
fn stem(name: &str) -> Option<&str> {
    name.rsplit_once('.').filter(|(_, extension)| IMAGES.contains(extension)).map(|(stem, _)| stem)
}

/// The part of a path after the last separator of any system.
fn last_component(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or("")
}

/// A name in lower case, with composed accents.
fn normalised(name: &str) -> String {
    name.nfc().collect::<String>().to_lowercase()
}
