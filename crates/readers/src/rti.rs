//! RTI files of hemispherical harmonics, `.rti`: pixels as functions of the light's direction. Layout:
//! `crates/readers/src/rti.md`.

use crate::file_kind::{Begins, FileKind};
use crate::scan::quoted;
use crate::viewer_file::{Levels, ViewerFile};
use crate::words::{MAX_SIZE, Words, pixel_count};
use brdfc_formats::pwt::{LightBasis, LightCoordinates};
use brdfc_formats::{FormatError, memory};
use std::f64::consts::{PI, SQRT_2};

/// RTI files: programs write a comment with the version first.
pub static KIND: FileKind = FileKind {
    description: "an RTI file of hemispherical harmonics (.rti)",
    extensions: &["rti"],
    begins: Begins::With(&[b"#HSH"]),
};

/// Valid numbers of terms, and their degrees. Viewers also accept the degree instead of the first two.
const TERMS: [(u32, u32); 5] = [(1, 1), (2, 2), (4, 1), (9, 2), (16, 3)];
/// Terms in messages.
const ALLOWED_TERMS: &str = "4, 9 or 16, or 1 or 2 for 4 or 9";
/// Types of files that other programs define, by number.
const TYPES: [&str; 5] = ["reserved", "polynomials", "spherical harmonics", "", "adaptive basis functions"];

/// Coefficients of hemispherical harmonics for each channel of each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Rti {
    size: [u32; 2],
    degree: u32,
    scale: Vec<f32>,
    bias: Vec<f32>,
    /// For each pixel, row by row from the top, the terms of red, then of green and blue.
    bytes: Vec<u8>,
}

impl Rti {
    /// Highest degree of the harmonics, 1 to 3.
    pub fn degree(&self) -> u32 {
        self.degree
    }

    /// Range of each coefficient: `byte / 255 * scale + bias`. A value of 1 is white.
    pub fn scale(&self) -> &[f32] {
        &self.scale
    }

    /// Value of byte 0 of each coefficient.
    pub fn bias(&self) -> &[f32] {
        &self.bias
    }

    /// Parses a file.
    ///
    /// # Errors
    /// Returns an error for another type, number of channels, basis type or element size than those of the layout,
    /// sizes and terms out of range, scales and biases that are not finite, a truncated header, and a file that is
    /// shorter or longer than its header declares.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let (at, line) = after_comments(bytes);
        let mut header = Words { bytes, at, line, whole: "a header of 7 numbers" };
        let kind = header.word("type")?;
        if kind != "3" {
            let name = kind.parse().ok().and_then(|kind: usize| TYPES.get(kind));
            let found = name.map_or(quoted(kind), |name| format!("{kind} ({name})"));
            return Err(header.wrong("type", found, "3 (hemispherical harmonics)"));
        }
        let size = [header.digits("width", 1..=MAX_SIZE)?, header.digits("height", 1..=MAX_SIZE)?];
        header.only("colours", "3", &[])?;
        let word = header.word("terms")?;
        let degree = TERMS.iter().find(|(terms, _)| word == terms.to_string()).map(|(_, degree)| *degree);
        let degree = degree.ok_or_else(|| header.wrong("terms", quoted(word), ALLOWED_TERMS))?;
        header.only("basis type", "2 (RGB)", &[("1", "LRGB")])?;
        header.only("element size", "1 byte", &[("4", "floats")])?;
        let rest = header.end("the element size")?;

        let terms = (degree as usize + 1).pow(2);
        let count = pixel_count(size)? * 3 * terms as u64;
        let found = rest.len() as u64;
        if found != 8 * terms as u64 + count {
            let allowed = format!(
                "{}: {terms} scales and biases, then {} x {} pixels",
                8 * terms as u64 + count,
                size[0],
                size[1]
            );
            return Err(FormatError::whole("file length", format!("{found} bytes after the header"), allowed));
        }
        let (numbers, pixels) = rest.split_at(8 * terms);
        let start = bytes.len() - rest.len();
        let mut numbers = numbers.as_chunks::<4>().0.iter().enumerate().map(|(k, bytes)| {
            let number = f32::from_le_bytes(*bytes);
            let field = if k < terms { "scale" } else { "bias" };
            let wrong = || FormatError::at_byte((start + 4 * k) as u64, field, number.to_string(), "a finite number");
            number.is_finite().then_some(number).ok_or_else(wrong)
        });
        let scale = numbers.by_ref().take(terms).collect::<Result<_, _>>()?;
        let bias = numbers.collect::<Result<_, _>>()?;
        let mut bytes = memory::reserved("pixels", pixels.len())?;
        bytes.extend_from_slice(pixels);
        Ok(Self { size, degree, scale, bias, bytes })
    }
}

impl ViewerFile for Rti {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn basis(&self) -> LightBasis {
        LightBasis { coordinates: LightCoordinates::Hemisphere, degree: self.degree }
    }

    fn under(&self, light: [f32; 3]) -> Levels<'_> {
        let harmonics = harmonics(self.degree, light);
        let numbers = |numbers: &[f32], factor: f64| -> Vec<f64> {
            harmonics.iter().zip(numbers).map(|(value, number)| value * f64::from(*number) * factor).collect()
        };
        // 1 is level 255.
        let offset = numbers(&self.bias, 255.0).iter().sum::<f64>();
        let weights = numbers(&self.scale, 1.0);
        Box::new(move |pixel| {
            let channels = &self.bytes[3 * pixel * weights.len()..];
            [0, 1, 2].map(|channel| {
                let bytes = &channels[channel * weights.len()..][..weights.len()];
                offset + bytes.iter().zip(&weights).map(|(byte, weight)| f64::from(*byte) * weight).sum::<f64>()
            })
        })
    }
}

impl Words<'_> {
    /// Reads a word that must be the first word of `allowed`. `named` are other words with names for messages.
    fn only(&mut self, field: &'static str, allowed: &str, named: &[(&str, &str)]) -> Result<(), FormatError> {
        let word = self.word(field)?;
        if allowed.split(' ').next() == Some(word) {
            return Ok(());
        }
        let name = named.iter().find(|(other, _)| *other == word);
        let found = name.map_or(quoted(word), |(_, name)| format!("{word} ({name})"));
        Err(self.wrong(field, found, allowed))
    }
}

/// Position and line number after the comments at the beginning of a file.
fn after_comments(bytes: &[u8]) -> (usize, u64) {
    let (mut at, mut line) = (0, 1);
    while bytes.get(at) == Some(&b'#') {
        at += bytes[at..].iter().position(|byte| *byte == b'\n').map_or(bytes.len() - at, |length| length + 1);
        line += 1;
    }
    (at, line)
}

/// Values of the harmonics for a light, in the order of the file: for each degree `l`, orders `m` from `l` to `-l`.
///
/// They are orthonormal over the hemisphere, and those of order 2 and -2 have the opposite sign of the definition.
fn harmonics(degree: u32, light: [f32; 3]) -> Vec<f64> {
    let unscaled = LightBasis { coordinates: LightCoordinates::Hemisphere, degree }.evaluate(light);
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    let value = |l: u32, order: i32| {
        let m = order.unsigned_abs();
        let norm = (f64::from(2 * l + 1) * factorial(l - m) / (2.0 * PI * factorial(l + m))).sqrt();
        let sign = if m == 2 { -1.0 } else { 1.0 };
        let factor = if m == 0 { 1.0 } else { SQRT_2 };
        sign * factor * norm * f64::from(unscaled[((l * l + l) as i32 + order) as usize])
    };
    (0..=degree).flat_map(|l| (-(l as i32)..=l as i32).rev().map(move |order| value(l, order))).collect()
}

#[cfg(test)]
mod tests;
