//! What becomes a polynomial wavelet tree: photographs under known lights, one view of a BTF, a polynomial texture map, or a
//! tree that is there already.

use crate::error::Error;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{FlatHeader, VisibilityMask, unit_vectors};
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_formats::{FormatError, Pack};
use brdfc_pwt::LightSamples;
use brdfc_pwt::measure::pictures_of_pack;
use brdfc_pwt::ptm::{samples_of, spread_lights};
use brdfc_readers::ptm::Ptm;
use brdfc_source::btf_stack::has_images;
use brdfc_source::flat_btf::{flat_btf_file, flat_view as decoded_view, open_flat_btf};
use brdfc_source::light_stack::{LightStack, is_light_stack};
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::photograph::Image;
use brdfc_source::{Input, InputError, ptm};
use rayon::prelude::*;
use std::path::Path;

/// Lights at which a map or a pack is looked at to be fitted again.
const SPREAD: usize = 96;
/// Most numbers of all photographs together: 6 GiB of them.
const MOST_NUMBERS: u64 = 3 << 29;

/// What becomes a tree.
const ALLOWED: &str = "a folder with a list of lights (.lp), the list, a BTF, a flat BTF, a .ptm or a pack (.ktx2)";

/// What was read.
pub enum LightInput {
    /// Photographs.
    Pictures(LightSamples),
    /// A polynomial texture map.
    Map(Ptm),
    /// A pack.
    Pack(PwtPack),
}

impl LightInput {
    /// Reads an input. Of BTFs the view of this index is taken, the first one if there is none.
    ///
    /// # Errors
    /// What cannot be read, or is none of these; a view that is not there; more photographs than memory should hold.
    pub fn open(input: &Input, view: Option<usize>) -> Result<Self, Error> {
        let extension = input.extension()?;
        if view.is_some() && (["ktx2", ptm::EXTENSION].contains(&extension.as_str())) {
            return Err(Error::wrong_usage("--view", "with one view", "with BTFs"));
        }
        if extension == ptm::EXTENSION {
            let map = ptm::open_ptm(input)?;
            check_spread(input, map.size())?;
            return Ok(Self::Map(map));
        }
        if extension == "ktx2" {
            return match brdfc_source::pack::open_pack(input)? {
                Pack::Pwt(pack) => {
                    // A small file may be a large picture.
                    check_spread(input, pack.header().size)?;
                    Ok(Self::Pack(pack))
                }
                other => Err(refused(input, "pack", other.kind().in_words(), "a polynomial wavelet tree")),
            };
        }
        let Some(path) = input.path() else {
            return Err(refused(input, "input", "no file", "a light stack, a BTF, a .ptm or a pack"));
        };
        if is_light_stack(path) {
            if view.is_some() {
                return Err(Error::wrong_usage("--view", "with a light stack, which has one", "with BTFs"));
            }
            return Ok(Self::Pictures(photographs(path)?));
        }
        if path.is_file() && extension != "json" && !OrdinaryBtf::is_one(path) {
            let found = if extension.is_empty() { "no extension".to_owned() } else { format!(".{extension}") };
            return Err(refused(input, "file name", &found, ALLOWED));
        }
        // Pictures may have been drawn into the folder of a flat BTF.
        if flat_btf_file(path)?.is_some() {
            return Ok(Self::Pictures(flat_view(path, view.unwrap_or(0))?));
        }
        if OrdinaryBtf::is_one(path) && (path.is_file() || has_images(path)) {
            return Ok(Self::Pictures(one_view(path, view.unwrap_or(0))?));
        }
        std::fs::metadata(path).map_err(|error| InputError::Io { name: input.to_string(), error })?;
        Err(refused(input, "input", "none of these", ALLOWED))
    }

    /// Photographs, those of one light averaged, or what a map or pack shows under many lights.
    pub fn into_samples(self) -> LightSamples {
        match self {
            Self::Pictures(samples) => samples.averaged(),
            Self::Map(map) => samples_of(&map, spread_lights(SPREAD)),
            Self::Pack(pack) => pictures_of_pack(&PwtDecoder::new(pack), spread_lights(SPREAD)),
        }
    }
}

/// Whether a photograph holds values above 1, which is white: errors in dB count them as 1.
pub fn any_above_white(samples: &LightSamples) -> bool {
    let is_bright = |picture: &Vec<[f32; 3]>| picture.as_flattened().iter().any(|value| *value > 1.0);
    samples.pictures.par_iter().any(is_bright)
}

pub(super) fn refused(input: &impl std::fmt::Display, field: &'static str, found: &str, allowed: &str) -> Error {
    let error = FormatError::whole(field, found.to_owned(), allowed);
    InputError::Format { name: input.to_string(), error }.into()
}

fn check_amount(input: &impl std::fmt::Display, size: [usize; 2], lights: usize) -> Result<(), Error> {
    let numbers = size.map(|side| side as u64).into_iter().product::<u64>() * 3 * lights as u64;
    if numbers <= MOST_NUMBERS {
        return Ok(());
    }
    let found = format!("{lights} of {} x {} pixels", size[0], size[1]);
    let allowed = format!("{} million pixels in all", MOST_NUMBERS / 3_000_000);
    Err(refused(input, "photographs", &found, &allowed))
}

/// A map or a pack is fitted again at what it shows under [`SPREAD`] lights.
fn check_spread(input: &impl std::fmt::Display, size: [u32; 2]) -> Result<(), Error> {
    let pixels: u64 = size.map(u64::from).iter().product();
    let most = MOST_NUMBERS / 3 / SPREAD as u64;
    if pixels <= most {
        return Ok(());
    }
    let found = format!("{} x {} pixels", size[0], size[1]);
    let allowed = format!("{most} in all, to be looked at under {SPREAD} lights");
    Err(refused(input, "size", &found, &allowed))
}

/// Linear RGB of so many photographs, decoded side by side; of several errors the first. What a file has below black is noise.
fn decoded(
    count: usize,
    image: impl Fn(usize) -> Result<Image, InputError> + Sync + Send,
) -> Result<Vec<Vec<[f32; 3]>>, InputError> {
    let images: Vec<Result<Image, _>> = (0..count).into_par_iter().map(image).collect();
    let not_negative = |mut image: Image| {
        image.pixels.as_flattened_mut().iter_mut().for_each(|value| *value = value.max(0.0));
        image.pixels
    };
    images.into_iter().map(|image| image.map(not_negative)).collect()
}

/// All photographs of a light stack, decoded side by side.
fn photographs(path: &Path) -> Result<LightSamples, Error> {
    let stack = LightStack::open(path)?;
    check_amount(&path.display(), stack.size(), stack.len())?;
    let pictures = decoded(stack.len(), |light| stack.image(light))?;
    Ok(LightSamples { size: stack.size(), lights: stack.lights().to_vec(), pictures, repeats: false, defined: None })
}

fn one_view(path: &Path, view: usize) -> Result<LightSamples, Error> {
    let btf = OrdinaryBtf::open(path)?;
    check_view(view, btf.views().len())?;
    let lights: Vec<[f32; 3]> = btf.lights().directions().into_iter().map(single).collect();
    check_amount(&path.display(), btf.size(), lights.len())?;
    let pictures = decoded(lights.len(), |light| btf.image(view, light))?;
    Ok(LightSamples { size: btf.size(), lights, pictures, repeats: true, defined: None })
}

/// A view of a flat BTF, with the texels that it sees as defined ones where the asset says which. Its rows go up, those of
/// pictures down.
fn flat_view(path: &Path, view: usize) -> Result<LightSamples, Error> {
    let file = open_flat_btf(path)?;
    let number = u32::try_from(view).unwrap_or(u32::MAX);
    let (found, views) = decoded_view(&file, number).map_err(|error| InputError::format(path, error))?;
    check_view(view, views as usize)?;
    let view = found.expect("its number was checked");
    let header = view.header();
    let side = header.size as usize;
    let lights = unit_vectors(&header.lights);
    check_amount(&path.display(), [side, side], header.lights.len())?;
    let decoded = |light: usize| {
        let rows = view.light(light as u32).chunks_exact(side).rev();
        rows.flatten().map(|texel| brdfc_formats::container::rgb9e5::decode(*texel)).collect()
    };
    let pictures = (0..header.lights.len()).into_par_iter().map(decoded).collect();
    let defined = file.mask.as_ref().and_then(|mask| seen_texels(mask, header));
    Ok(LightSamples { size: [side, side], lights, pictures, repeats: true, defined })
}

/// Which texels a view of a flat BTF sees; nothing where it sees none.
fn seen_texels(mask: &VisibilityMask, header: &FlatHeader) -> Option<Vec<bool>> {
    let size = header.size;
    let seen = (0..size * size).map(|texel| mask.is_seen(header.view, [texel % size, size - 1 - texel / size]));
    Some(seen.collect()).filter(|seen: &Vec<bool>| seen.contains(&true))
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
