//! Compares photographs with packs, maps or captures made from them, one image at a time to save memory.

use super::limits::refused;
use super::photographs::DistantPhotographs;
use crate::error::Error;
use brdfc_formats::pwt::PwtDecoder;
use brdfc_formats::{FormatError, Pack};
use brdfc_pwt::measure::{PhotographSums, StackErrors, photograph_sums};
use brdfc_pwt::ptm::image_rows;
use brdfc_readers::viewer_file::ViewerFile;
use brdfc_source::pack::open_pack;
use brdfc_source::photograph::CodeValues;
use brdfc_source::rti_capture::RtiCapture;
use brdfc_source::viewer_file::open_viewer_file;
use brdfc_source::{Input, InputError, Kind};
use rayon::prelude::*;
use std::ops::Range;
use std::path::Path;

/// Number of rows decoded at once.
const BAND: usize = 64;
/// Largest difference between coordinates of equal lights.
const SAME_LIGHT: f32 = 1e-4;

/// Inputs that can be compared with photographs.
const ALLOWED: &str = "a pack of 'brdfc pwt', a .ptm, a .rti or an RTI capture";

/// Errors of an input against photographs.
#[derive(Debug, Clone, serde::Serialize, schemars::JsonSchema)]
pub struct PhotographComparison {
    /// Errors over all photographs.
    #[serde(flatten)]
    pub errors: StackErrors,
    /// Errors of each photograph.
    pub photographs: Vec<PhotographErrors>,
    /// Differences between the list of lights of the reference and its photographs.
    #[serde(skip)]
    pub notes: Vec<String>,
}

/// Errors of one photograph.
#[derive(Debug, Clone, Copy, serde::Serialize, schemars::JsonSchema)]
pub struct PhotographErrors {
    /// Unit vector to its light.
    pub light: [f32; 3],
    /// PSNR of sRGB levels, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

/// An input that can be rendered under the lights of the reference.
enum Compared {
    Pack(Box<PwtDecoder>),
    Map(Box<dyn ViewerFile>),
    Stack(Box<DistantPhotographs>),
}

/// Measures a pack, a polynomial texture map or another RTI capture against the photographs of an RTI capture, as sRGB levels
/// and by ΔE (CIE76). `codes` is the meaning of the code values of photographs in spite of what they state.
///
/// # Errors
/// Returns an error if an input cannot be read, is of another kind or size, or is a capture under other lights.
pub fn compare_photographs(
    reference: &Path,
    input: &Input,
    codes: Option<CodeValues>,
) -> Result<PhotographComparison, Error> {
    let photographs = DistantPhotographs::open(reference, codes)?;
    let stack = photographs.capture();
    let shown = Compared::open(input, stack, codes)?;
    let width = stack.size()[0];
    let of_light = |light: usize| -> Result<PhotographSums, InputError> {
        let reference = photographs.image(light)?.pixels;
        if let Compared::Stack(other) = &shown {
            return Ok(photograph_sums(&other.image(light)?.pixels, &reference));
        }
        let mut sums = PhotographSums::default();
        for first in (0..stack.size()[1]).step_by(BAND) {
            let rows = first..(first + BAND).min(stack.size()[1]);
            let texels = rows.start * width..rows.end * width;
            sums += photograph_sums(&shown.rows(stack.lights()[light], rows), &reference[texels]);
        }
        Ok(sums)
    };
    let sums: Vec<Result<_, InputError>> = (0..stack.len()).into_par_iter().map(of_light).collect();
    let sums = sums.into_iter().collect::<Result<Vec<_>, _>>()?;
    let each = stack.lights().iter().zip(&sums).map(|(light, sums)| PhotographErrors {
        light: *light,
        psnr: sums.psnr(),
        delta_e: sums.mean_delta_e(),
    });
    let errors = StackErrors::of_photographs(&sums);
    Ok(PhotographComparison { errors, photographs: each.collect(), notes: photographs.notes().to_vec() })
}

impl Compared {
    fn open(input: &Input, reference: &RtiCapture, codes: Option<CodeValues>) -> Result<Self, Error> {
        let kind = Kind::of(input)?;
        let shown = match (kind, input.path()) {
            (kind, _) if kind.is_ktx2() => match open_pack(input)? {
                Pack::Pwt(pack) if pack.header().view_count() > 1 => {
                    let found = pack.header().view_count().to_string();
                    return Err(refused(input, "views", &found, "1, like the reference"));
                }
                Pack::Pwt(pack) => Self::Pack(Box::new(PwtDecoder::new(pack))),
                other => return Err(refused(input, "pack", other.kind().summary(), ALLOWED)),
            },
            (Kind::RtiCapture, Some(path)) => Self::Stack(Box::new(DistantPhotographs::open(path, codes)?)),
            _ => Self::Map(open_viewer_file(input)?.ok_or_else(|| kind.refused(input, ALLOWED))?),
        };
        let found = match &shown {
            Self::Pack(decoder) => decoder.pack().header().size.map(|side| side as usize),
            Self::Map(map) => map.size().map(|side| side as usize),
            Self::Stack(photographs) => photographs.capture().size(),
        };
        let wrong = |error: FormatError| Error::from(InputError::Format { name: input.to_string(), error });
        let [width, height] = reference.size();
        if found != [width, height] {
            let allowed = format!("{width} x {height}, the size of the reference");
            return Err(wrong(FormatError::whole("size", format!("{} x {}", found[0], found[1]), allowed)));
        }
        if let Self::Stack(photographs) = &shown {
            same_lights(photographs.capture().lights(), reference.lights()).map_err(wrong)?;
        }
        Ok(shown)
    }

    /// Linear RGB of some rows under a light; empty for captures, whose images are compared whole.
    fn rows(&self, light: [f32; 3], rows: Range<usize>) -> Vec<[f32; 3]> {
        match self {
            Self::Pack(decoder) => {
                let weights = decoder.pack().header().weights(light);
                decoder.unpacked_rows(0, 0, rows.clone()).rows(rows, &weights)
            }
            Self::Map(map) => image_rows(map.as_ref(), light, rows),
            Self::Stack(_) => Vec::new(),
        }
    }
}

/// Checks that two captures have the same lights.
fn same_lights(found: &[[f32; 3]], expected: &[[f32; 3]]) -> Result<(), FormatError> {
    let refused = |found: String, allowed: String| Err(FormatError::whole("lights", found, allowed));
    if found.len() != expected.len() {
        return refused(found.len().to_string(), format!("{}, as in the reference", expected.len()));
    }
    let near = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME_LIGHT);
    match found.iter().zip(expected).position(|pair| !near(pair)) {
        None => Ok(()),
        Some(at) => {
            let text = |[x, y, z]: [f32; 3]| format!("({x:.4}, {y:.4}, {z:.4})");
            refused(
                format!("{} as number {}", text(found[at]), at + 1),
                format!("{}, as in the reference", text(expected[at])),
            )
        }
    }
}
