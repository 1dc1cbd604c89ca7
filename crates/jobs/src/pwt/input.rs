//! Opens inputs of polynomial wavelet trees: photographs under known lights, one view of a BTF or all, a file of an RTI viewer, or an
//! existing tree.

use super::limits::{MAX_BYTES, check_amount, check_linear, refused};
use super::views::{ViewChoice, all_flat_views, all_views};
use crate::error::Error;
use crate::exposure::{Exposure, Exposures};
use brdfc_core::words::{counted, join_truncated};
use brdfc_formats::Pack;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::unit_vectors;
use brdfc_formats::pwt::{LightBasis, PwtDecoder, PwtPack};
use brdfc_pwt::LightSamples;
use brdfc_pwt::measure::images_of_pack;
use brdfc_pwt::near::check_count;
use brdfc_pwt::ptm::{samples_of, spread_lights};
use brdfc_readers::pixels::Pixels;
use brdfc_readers::viewer_file::ViewerFile;
use brdfc_source::flat_btf::{flat_view as decoded_view, open_flat_btf};
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::photograph::CodeValues;
use brdfc_source::rti_capture::{RtiCapture, format_range};
use brdfc_source::viewer_file::open_viewer_file;
use brdfc_source::{Input, InputError, Kind};
use rayon::prelude::*;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Number of lights under which a map or a pack is rendered to be fitted again.
const SPREAD: usize = 96;
/// Number of lights for each term of a large map: more than enough to recover its functions.
const LIGHTS_PER_TERM: usize = 4;
/// Number of photographs that a note names.
const MAX_NAMED: usize = 3;

/// Inputs that are accepted.
const ALLOWED: &str =
    "a folder with a list of lights (.lp), the list, a BTF, a flat BTF, a .ptm, a .rti or a pack (.ktx2)";

/// An input that was read.
pub enum LightInput {
    /// Photographs with their lights.
    Photographs(LightSamples, About),
    /// A file of an RTI viewer.
    Map(Box<dyn ViewerFile>),
    /// A pack of a polynomial wavelet tree.
    Pack(PwtPack),
}

/// Facts about photographs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct About {
    /// Colour of the code values of images in files, and how they are converted.
    pub colour: Option<String>,
    /// Differences between the list of lights and the photographs, and other statements of the images that are applied.
    pub notes: Vec<String>,
}

impl LightInput {
    /// Same as [`Self::open_as`], with the code values that photographs state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open_as`].
    pub fn open(input: &Input, view: Option<ViewChoice>) -> Result<Self, Error> {
        Self::open_as(input, view, None)
    }

    /// Reads an input. `view` is the view of a BTF, the first one by default, or all views; `codes` is the
    /// meaning of the code values of photographs in spite of what they state.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read or is of another kind, the view does not exist, or the photographs exceed the
    /// limit.
    pub fn open_as(input: &Input, view: Option<ViewChoice>, codes: Option<CodeValues>) -> Result<Self, Error> {
        let kind = Kind::of(input)?;
        let is_folder = input.path().is_some_and(Path::is_dir);
        if codes.is_some() && !(kind == Kind::RtiCapture || kind == Kind::Btf && is_folder) {
            return Err(Error::usage("--photographs applies only to RTI captures and folders of BTF images"));
        }
        let has_one_view =
            matches!(kind, Kind::RtiCapture | Kind::Ptm | Kind::Rti) || kind.is_ktx2() && !kind.is_flat_btf();
        if view.is_some() && has_one_view {
            return Err(Error::usage(format!("--view does not apply to {}, only to BTFs", kind.name())));
        }
        let view = view.unwrap_or(ViewChoice::One(0));
        match (kind, input.path()) {
            (Kind::RtiCapture, Some(path)) => {
                let (samples, about) = photographs(path, codes)?;
                Ok(Self::Photographs(samples, about))
            }
            (Kind::Btf, Some(path)) => {
                let btf = OrdinaryBtf::open_as(path, codes)?;
                let samples = match view {
                    ViewChoice::One(view) => one_view(path, &btf, view)?,
                    ViewChoice::All => all_views(path, &btf)?,
                };
                let notes = btf.notes().iter().cloned().chain(exposures(&samples).facts().notes()).collect();
                let about = About { colour: btf.colour().map(str::to_owned), notes };
                Ok(Self::Photographs(samples, about))
            }
            (_, Some(path)) if kind.is_flat_btf() => {
                let samples = flat_view(path, view)?;
                let about = About { notes: exposures(&samples).facts().notes(), ..About::default() };
                Ok(Self::Photographs(samples, about))
            }
            _ if kind.is_ktx2() => match brdfc_source::pack::open_pack(input)? {
                Pack::Pwt(pack) if pack.header().view_count() > 1 => Err(refused(
                    input,
                    "views",
                    &pack.header().view_count().to_string(),
                    "a pack of one view, or the BTF itself",
                )),
                Pack::Pwt(pack) => {
                    // A small file may hold a large image.
                    check_spread(input, pack.header().size, SPREAD)?;
                    Ok(Self::Pack(pack))
                }
                other => Err(refused(input, "pack", other.kind().summary(), "a polynomial wavelet tree")),
            },
            _ => {
                let map = open_viewer_file(input)?.ok_or_else(|| kind.refused(input, ALLOWED))?;
                check_spread(input, map.size(), lights_of(map.as_ref()))?;
                Ok(Self::Map(map))
            }
        }
    }

    /// Terms of the functions of a file of an RTI viewer.
    pub fn basis(&self) -> Option<LightBasis> {
        if let Self::Map(map) = self { Some(map.basis()) } else { None }
    }

    /// Notes about photographs: what was left out, and what has nothing to fit.
    pub fn notes(&self) -> Vec<String> {
        let Self::Photographs(_, about) = self else { return Vec::new() };
        about.notes.clone()
    }

    /// Colour of the code values of photographs in files, and how they are converted.
    pub fn colour(&self) -> Option<&str> {
        if let Self::Photographs(_, about) = self { about.colour.as_deref() } else { None }
    }

    /// Photographs, averaged per light, or renderings of a map or a pack under many lights.
    pub fn into_samples(self) -> LightSamples {
        match self {
            Self::Photographs(samples, _) => samples.averaged(),
            Self::Map(map) => samples_of(map.as_ref(), spread_lights(lights_of(map.as_ref()))),
            Self::Pack(pack) => images_of_pack(&PwtDecoder::new(pack), [0.0, 0.0, 1.0], spread_lights(SPREAD)),
        }
    }
}

/// Returns true if a photograph has values above 1 (white), which errors in dB count as 1.
pub fn any_above_white(samples: &LightSamples) -> bool {
    // Levels end at white.
    let is_bright = |photograph: &Pixels| match photograph {
        Pixels::Linear(values) => values.as_flattened().iter().any(|value| *value > 1.0),
        Pixels::Levels8(_) | Pixels::Levels16(_) => false,
    };
    samples.images.par_iter().any(is_bright)
}

/// Exposures of all photographs, of each view by itself.
fn exposures(samples: &LightSamples) -> Exposures {
    let texels = samples.view_size().iter().product::<usize>().max(1);
    let all = Mutex::new(Exposures::default());
    samples.images.par_iter().enumerate().for_each(|(light, image)| {
        for view in 0..image.len() / texels {
            let exposure = Exposure::of((view * texels..(view + 1) * texels).map(|at| image.pixel(at)));
            all.lock().unwrap_or_else(PoisonError::into_inner).add([view, light], exposure);
        }
    });
    all.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// Number of lights under which a map is rendered: fewer if it is large.
fn lights_of(map: &dyn ViewerFile) -> usize {
    let pixels: u64 = map.size().map(u64::from).iter().product();
    if Pixels::BYTES_OF_LINEAR * pixels * SPREAD as u64 <= MAX_BYTES {
        SPREAD
    } else {
        LIGHTS_PER_TERM * map.basis().terms()
    }
}

/// Checks the size of a map or a pack, which is rendered under some lights and fitted again.
fn check_spread(input: &impl std::fmt::Display, size: [u32; 2], lights: usize) -> Result<(), Error> {
    let pixels: u64 = size.map(u64::from).iter().product();
    let most = MAX_BYTES / Pixels::BYTES_OF_LINEAR / lights as u64;
    if pixels <= most {
        return Ok(());
    }
    let found = format!("{} x {} pixels", size[0], size[1]);
    let allowed = format!("at most {most} in all, which are rendered under {lights} lights");
    Err(refused(input, "size", &found, &allowed))
}

/// Decodes `count` photographs in parallel. Returns the first error. Negative values are noise and become 0.
fn decoded(
    count: usize,
    image: impl Fn(usize) -> Result<Pixels, InputError> + Sync + Send,
) -> Result<Vec<Pixels>, InputError> {
    let not_negative = |mut image: Pixels| {
        if let Pixels::Linear(_) = image {
            image.to_mut().as_flattened_mut().iter_mut().for_each(|value| *value = value.max(0.0));
        }
        image
    };
    let images: Vec<Result<Pixels, _>> =
        (0..count).into_par_iter().map(|light| image(light).map(not_negative)).collect();
    images.into_iter().collect()
}

/// Note that photographs are converted, if their lights are near.
pub(crate) fn near_note(capture: &RtiCapture) -> Option<String> {
    let distances = format_range(capture.near()?.range());
    Some(format!("near lights, at distances of {distances} image widths: photographs were converted to distant lights"))
}

/// Decodes all photographs of an RTI capture in parallel.
pub(super) fn samples_of_capture(path: &Path, capture: &RtiCapture) -> Result<LightSamples, Error> {
    let pixels: u64 = capture.size().map(|side| side as u64).iter().product();
    let mut bytes = capture.bytes();
    if capture.near().is_some() {
        check_count(capture.len()).map_err(|error| InputError::format(path, error))?;
        // Converted photographs.
        bytes += Pixels::BYTES_OF_LINEAR * pixels * capture.len() as u64;
    }
    check_amount(&path.display(), capture.size(), capture.len(), bytes)?;
    let images = decoded(capture.len(), |light| capture.pixels(light))?;
    let near = capture.near().cloned();
    Ok(LightSamples { near, ..LightSamples::new(capture.size(), capture.lights().to_vec(), images) })
}

/// Reads the photographs of an RTI capture, and leaves out those that are black or white everywhere.
fn photographs(path: &Path, codes: Option<CodeValues>) -> Result<(LightSamples, About), Error> {
    let stack = RtiCapture::open_as(path, codes)?;
    let samples = samples_of_capture(path, &stack)?;
    let mut notes = stack.notes().to_vec();
    let exposures = exposures(&samples);
    let all = exposures.uniform();
    let left_out: Vec<usize> = all.iter().flat_map(|(_, places)| places).map(|[_, light]| *light).collect();
    // A flash that failed, or a lens cap: such a photograph predicts no light.
    let left_out = if left_out.len() == samples.lights.len() { Vec::new() } else { left_out };
    for (name, lights) in all.iter().filter(|(_, lights)| !lights.is_empty() && !left_out.is_empty()) {
        let file =
            |[_, light]: &[usize; 2]| stack.file(*light).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let files: Vec<String> = lights.iter().map(file).collect();
        let (count, files) = (counted(lights.len(), "light"), join_truncated(&files, MAX_NAMED));
        notes.push(format!("left out {count}, whose photograph is {name} everywhere: {files}"));
    }
    notes.extend(near_note(&stack));
    notes.extend(exposures.without(&left_out).facts().notes());
    let about = About { colour: Some(stack.colour().to_owned()), notes };
    Ok((if left_out.is_empty() { samples } else { samples.without(&left_out) }, about))
}

fn one_view(path: &Path, btf: &OrdinaryBtf, view: usize) -> Result<LightSamples, Error> {
    check_view(view, btf.views().len())?;
    let lights: Vec<[f32; 3]> = btf.lights().directions().into_iter().map(single).collect();
    check_linear(&path.display(), btf.size(), lights.len())?;
    let images = decoded(lights.len(), |light| btf.image(view, light).map(|image| image.pixels.into()))?;
    Ok(LightSamples { repeats: true, ..LightSamples::new(btf.size(), lights, images) })
}

/// A view of a flat BTF with components, or all. Rows of flat BTFs go up, rows of images go down.
fn flat_view(path: &Path, view: ViewChoice) -> Result<LightSamples, Error> {
    let file = open_flat_btf(path)?;
    let view = match view {
        ViewChoice::One(view) => view,
        ViewChoice::All => return all_flat_views(path, &file),
    };
    let number = u32::try_from(view).unwrap_or(u32::MAX);
    let (found, views) = decoded_view(&file, number).map_err(|error| InputError::format(path, error))?;
    check_view(view, views as usize)?;
    let view = found.expect("its number was checked");
    let header = view.header();
    let side = header.size as usize;
    let lights = unit_vectors(&header.lights);
    check_linear(&path.display(), [side, side], header.lights.len())?;
    let decoded = |light: usize| {
        let rows = view.light(light as u32).chunks_exact(side).rev();
        rows.flatten().map(|texel| brdfc_formats::container::rgb9e5::decode(*texel)).collect()
    };
    let images: Vec<Vec<[f32; 3]>> = (0..header.lights.len()).into_par_iter().map(decoded).collect();
    Ok(LightSamples { repeats: true, ..LightSamples::new([side, side], lights, images) })
}

fn single(direction: Vector) -> [f32; 3] {
    direction.map(|c| c as f32)
}

fn check_view(view: usize, views: usize) -> Result<(), Error> {
    if view < views {
        return Ok(());
    }
    Err(Error::wrong_usage("--view", view, format!("0 to {}", views.saturating_sub(1))))
}
