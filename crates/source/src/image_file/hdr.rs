//! Radiance HDR: its header, which says what the pixels have been multiplied by, and RGBE or XYZE pixels.

use super::ask::{Ask, ImageReader};
use super::colour::{Colour, Curve};
use super::header::Header;
use super::orientation::Orientation;
use super::raster::{Depth, Raster, Samples, collected};
use brdfc_core::words::format_number;
use brdfc_formats::FormatError;
use brdfc_formats::memory::filled;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use std::io::{Cursor, Read};

/// Maximum length of the header and of a line of it, bytes.
const MAX_HEADER_BYTES: u64 = 1 << 20;
/// Primaries and white of XYZ.
const XYZ: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];

/// Statements of a header.
struct Radiance {
    /// Width of the stored lines, and their number.
    stored: [usize; 2],
    orientation: Orientation,
    /// Product of all exposures and colour corrections.
    factor: [f64; 3],
    gamma: f64,
    is_xyz: bool,
    primaries: Option<[[f64; 2]; 4]>,
    notes: Vec<String>,
}

pub(super) fn header(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Header, FormatError> {
    let radiance = open(reader, ask)?;
    let colour = ask.colour(|| match radiance.primaries {
        _ if radiance.is_xyz => Colour::of_curve("XYZ (Radiance FORMAT)", Curve::LINEAR, Some(XYZ)),
        Some(primaries) => Colour::of_curve("primaries of Radiance PRIMARIES", Curve::LINEAR, Some(primaries)),
        None => Ok(Colour::linear("linear (Radiance)")),
    })?;
    let size = radiance.orientation.size(radiance.stored);
    let orientation = radiance.orientation;
    Ok(Header { size, channels: 3, depth: Depth::F32, colour, orientation, notes: radiance.notes })
}

pub(super) fn samples(mut reader: impl ImageReader, ask: &Ask<'_>) -> Result<Raster, FormatError> {
    let Radiance { stored: [width, height], factor, gamma, .. } = open(&mut reader, ask)?;
    // The decoder accepts one order of lines, and reads as many as this header says.
    let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let decoder = HdrDecoder::new(Cursor::new(head).chain(reader)).map_err(|error| ask.broken(error))?;
    let mut bytes = filled("pixels", width * height * 12, 0u8)?;
    decoder.read_image(&mut bytes).map_err(|error| ask.broken(error))?;
    let mut samples = collected(bytes.as_chunks().0.iter().map(|sample| f32::from_ne_bytes(*sample)))?;
    drop(bytes);
    if gamma != 1.0 || factor != [1.0; 3] {
        for pixel in samples.as_chunks_mut::<3>().0 {
            for (value, factor) in pixel.iter_mut().zip(factor) {
                let linear = if gamma == 1.0 { f64::from(*value) } else { f64::from(*value).powf(gamma) };
                *value = (linear / factor) as f32;
            }
        }
    }
    Ok(Raster { size: [width, height], channels: 3, samples: Samples::F32(samples) })
}

/// Reads the header; the pixels follow.
fn open(reader: &mut impl ImageReader, ask: &Ask<'_>) -> Result<Radiance, FormatError> {
    let mut radiance = Radiance {
        stored: [0; 2],
        orientation: Orientation::UPRIGHT,
        factor: [1.0; 3],
        gamma: 1.0,
        is_xyz: false,
        primaries: None,
        notes: Vec::new(),
    };
    let mut reader = reader.take(MAX_HEADER_BYTES);
    let mut line = || -> Result<String, FormatError> {
        let mut bytes = Vec::new();
        std::io::BufRead::read_until(&mut reader, b'\n', &mut bytes).map_err(|error| ask.broken(error))?;
        if bytes.pop() != Some(b'\n') {
            return Err(ask.broken("the header has no end"));
        }
        Ok(String::from_utf8_lossy(&bytes).trim_end_matches('\r').to_owned())
    };
    line()?;
    loop {
        let text = line()?;
        if text.is_empty() {
            break;
        }
        // Indented lines are of the images that this one was made of.
        if let Some((name, value)) = text.split_once('=').filter(|(name, _)| !name.starts_with(char::is_whitespace)) {
            radiance.set(name.trim(), value.trim(), ask)?;
        }
    }
    let resolution = line()?;
    radiance.resolve(&resolution).ok_or_else(|| {
        let allowed = "-Y HEIGHT +X WIDTH, or another order of Y and X";
        FormatError::whole("HDR resolution", resolution.clone(), allowed)
    })?;
    ask.check_size(radiance.orientation.size(radiance.stored))?;
    Ok(radiance)
}

impl Radiance {
    fn set(&mut self, name: &str, value: &str, ask: &Ask<'_>) -> Result<(), FormatError> {
        let numbers = |count: usize, valid: fn(f64) -> bool| {
            let found: Option<Vec<f64>> = value.split_whitespace().map(|number| number.parse().ok()).collect();
            found.filter(|found| found.len() == count && found.iter().all(|n| n.is_finite() && valid(*n))).ok_or_else(
                || FormatError::whole(format!("HDR {name}"), value, format!("{count} numbers, positive for factors")),
            )
        };
        let positive: fn(f64) -> bool = |number| number > 0.0;
        match name {
            "EXPOSURE" | "COLORCORR" => {
                let factors = numbers(if name == "EXPOSURE" { 1 } else { 3 }, positive)?;
                let all: [f64; 3] = std::array::from_fn(|c| factors[c % factors.len()]);
                self.factor = std::array::from_fn(|c| self.factor[c] * all[c]);
                let shown: Vec<String> = factors.iter().map(|factor| format_number(*factor)).collect();
                self.notes.push(format!("{name} {} divided out", shown.join(" ")));
            }
            "GAMMA" => {
                let gamma = numbers(1, positive)?[0];
                self.gamma *= gamma;
                if gamma != 1.0 {
                    self.notes.push(format!("GAMMA {} undone", format_number(gamma)));
                }
            }
            "PRIMARIES" => {
                let all = numbers(8, |_| true)?;
                // Programs that state no primaries write zeros.
                let is_stated = all.iter().any(|number| *number != 0.0);
                self.primaries = is_stated.then(|| std::array::from_fn(|k| [all[2 * k], all[2 * k + 1]]));
            }
            "FORMAT" => match value {
                "32-bit_rle_rgbe" => {}
                "32-bit_rle_xyze" => self.is_xyz = true,
                _ => return Err(ask.found(format!("format {value}"))),
            },
            _ => {}
        }
        Ok(())
    }

    /// Reads the line of the resolution: the direction and number of lines, then of the pixels of a line.
    fn resolve(&mut self, text: &str) -> Option<()> {
        let [lines, height, pixels, width] = text.split_whitespace().collect::<Vec<_>>()[..] else { return None };
        let number = match (lines, pixels) {
            ("-Y", "+X") => 1,
            ("-Y", "-X") => 2,
            ("+Y", "-X") => 3,
            ("+Y", "+X") => 4,
            ("+X", "-Y") => 5,
            ("-X", "-Y") => 6,
            ("-X", "+Y") => 7,
            ("+X", "+Y") => 8,
            _ => return None,
        };
        self.orientation = Orientation::of(number);
        self.stored = [width.parse().ok()?, height.parse().ok()?];
        Some(())
    }
}
