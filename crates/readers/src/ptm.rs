//! Polynomial texture maps, `.ptm`: pixels as polynomials in the light's direction. Layout:
//! `crates/readers/src/ptm.md`.

mod compressed;

pub use compressed::DecodeJpeg;

use crate::file_kind::{Begins, FileKind};
use crate::scan::quoted;
use crate::words::{MAX_SIZE, Words, pixel_count};
use brdfc_formats::{FormatError, memory};

/// Polynomial texture maps: the file begins with their version.
pub static KIND: FileKind = FileKind {
    description: "a polynomial texture map (.ptm)",
    extensions: &["ptm"],
    begins: Begins::With(&[b"PTM_1."]),
};

/// Number of coefficients of a polynomial: of u², v², uv, u, v and 1, in this order.
pub const TERMS: usize = 6;
/// Version at the beginning of files.
pub const VERSION: &str = "PTM_1.2";
/// Version whose `PTM_FORMAT_LRGB` has the colour of each pixel after its coefficients.
const INTERLEAVED: &str = "PTM_1.1";

const RGB: &str = "PTM_FORMAT_RGB";
const LRGB: &str = "PTM_FORMAT_LRGB";
const JPEG_RGB: &str = "PTM_FORMAT_JPEG_RGB";
const JPEG_LRGB: &str = "PTM_FORMAT_JPEG_LRGB";
/// Largest magnitude of a bias that quantisation chooses.
const MAX_BIAS: f64 = (1u32 << 30) as f64;

/// A polynomial for each pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Ptm {
    size: [u32; 2],
    scale: [f32; TERMS],
    bias: [i32; TERMS],
    model: PtmModel,
    is_compressed: bool,
}

/// The bytes of all pixels, row by row from the top, left to right.
#[derive(Debug, Clone, PartialEq)]
pub enum PtmModel {
    /// A polynomial for each channel.
    Rgb(Vec<[[u8; TERMS]; 3]>),
    /// A polynomial that multiplies a colour.
    Lrgb {
        /// Coefficients of the polynomial of each pixel, as in the file.
        luminance: Vec<[u8; TERMS]>,
        /// Colour of each pixel, RGB, as in the file.
        colour: Vec<[u8; 3]>,
    },
}

impl PtmModel {
    /// Name of the format in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Rgb(_) => RGB,
            Self::Lrgb { .. } => LRGB,
        }
    }

    /// Collects bytes by plane, a coefficient or a colour, and by pixel; rows run from the bottom.
    fn of_planes(is_rgb: bool, size: [u32; 2], byte: impl Fn(usize, usize) -> u8) -> Result<Self, FormatError> {
        let (width, count) = (size[0] as usize, pixel_count(size)? as usize);
        let pixels = || from_top(width, count);
        let terms = |first: usize, at: usize| std::array::from_fn(|term| byte(first + term, at));
        if is_rgb {
            let mut all = memory::reserved("pixels", count)?;
            all.extend(pixels().map(|at| [0, TERMS, 2 * TERMS].map(|first| terms(first, at))));
            return Ok(Self::Rgb(all));
        }
        let (mut luminance, mut colour) = (memory::reserved("pixels", count)?, memory::reserved("pixels", count)?);
        luminance.extend(pixels().map(|at| terms(0, at)));
        colour.extend(pixels().map(|at| [0, 1, 2].map(|channel| byte(TERMS + channel, at))));
        Ok(Self::Lrgb { luminance, colour })
    }
}

/// The six terms of a light with these x and y of its unit vector.
pub fn terms([u, v]: [f32; 2]) -> [f64; TERMS] {
    let (u, v) = (f64::from(u), f64::from(v));
    [u * u, v * v, u * v, u, v, 1.0]
}

impl Ptm {
    /// Creates a map from bytes, with coefficients `(byte - bias) * scale`.
    ///
    /// # Errors
    /// Returns an error for sides of 0 or more than 65,536, another number of pixels, and scales that are 0 or
    /// not finite.
    pub fn new(size: [u32; 2], scale: [f32; TERMS], bias: [i32; TERMS], model: PtmModel) -> Result<Self, FormatError> {
        let count = pixel_count(size)?;
        let lengths = match &model {
            PtmModel::Rgb(pixels) => [pixels.len(); 2],
            PtmModel::Lrgb { luminance, colour } => [luminance.len(), colour.len()],
        };
        if let Some(found) = lengths.into_iter().find(|length| *length as u64 != count) {
            let allowed = format!("{count} for {} x {}", size[0], size[1]);
            return Err(FormatError::whole("pixels", found.to_string(), allowed));
        }
        if let Some(scale) = scale.into_iter().find(|scale| !is_scale(*scale)) {
            return Err(FormatError::whole("scale", scale.to_string(), SCALES));
        }
        Ok(Self { size, scale, bias, model, is_compressed: false })
    }

    /// Quantises coefficients of u², v², uv, u, v and 1 for each channel of each pixel, in 8-bit levels. Pixels are row
    /// by row from the top.
    ///
    /// Each term has the smallest scale with which a byte spans its lowest to its highest coefficient. The error of
    /// each coefficient is at most half of [`Self::scale`], which is 1/255 of that range, or 2^-30 of the largest
    /// coefficient if that is more. Terms that are constant over all pixels are exact.
    ///
    /// # Errors
    /// Same as [`Self::new`]. Also returns an error for coefficients that are not finite.
    pub fn from_coefficients_rgb(size: [u32; 2], pixels: &[[[f32; TERMS]; 3]]) -> Result<Self, FormatError> {
        let rule = Quantisation::of(pixels.as_flattened())?;
        let bytes = pixels.iter().map(|pixel| pixel.map(|coefficients| rule.bytes(coefficients))).collect();
        Self::new(size, rule.scale, rule.bias, PtmModel::Rgb(bytes))
    }

    /// Quantises coefficients of the polynomial that multiplies `colour`, as [`Self::from_coefficients_rgb`] does.
    ///
    /// # Errors
    /// Returns an error for sides of 0 or more than 65,536, another number of pixels, and coefficients that are
    /// not finite.
    pub fn from_coefficients_lrgb(
        size: [u32; 2],
        luminance: &[[f32; TERMS]],
        colour: &[[u8; 3]],
    ) -> Result<Self, FormatError> {
        let rule = Quantisation::of(luminance)?;
        let bytes = luminance.iter().map(|coefficients| rule.bytes(*coefficients)).collect();
        Self::new(size, rule.scale, rule.bias, PtmModel::Lrgb { luminance: bytes, colour: colour.to_vec() })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Scale of each term.
    pub fn scale(&self) -> [f32; TERMS] {
        self.scale
    }

    /// Bias of each term: the byte that means 0.
    pub fn bias(&self) -> [i32; TERMS] {
        self.bias
    }

    /// Quantised polynomials of all pixels, as the file stores them.
    pub fn model(&self) -> &PtmModel {
        &self.model
    }

    /// Name of the format of the file from which the map was read, or to which it would be written.
    pub fn format(&self) -> &'static str {
        match (self.is_compressed, self.model.name()) {
            (false, name) => name,
            (true, RGB) => JPEG_RGB,
            (true, _) => JPEG_LRGB,
        }
    }

    /// Coefficients that the bytes represent.
    pub fn coefficients(&self, bytes: [u8; TERMS]) -> [f64; TERMS] {
        std::array::from_fn(|term| (f64::from(bytes[term]) - f64::from(self.bias[term])) * f64::from(self.scale[term]))
    }

    /// Value of a pixel under a light with these x and y of its unit vector: RGB in 8-bit levels, clamped to 0 to 255.
    /// `pixel` is `row * width + column`, rows counted from the top.
    ///
    /// Only the result is clamped: a luminance above 255 may multiply a dark colour.
    ///
    /// # Panics
    /// Panics if the pixel does not exist.
    pub fn value(&self, pixel: usize, light: [f32; 2]) -> [f32; 3] {
        self.polynomials(pixel, light).map(|code| code.clamp(0.0, 255.0) as f32)
    }

    /// Value of a pixel under a light, RGB in 8-bit levels, not clamped; see [`Self::value`] for the arguments.
    ///
    /// # Panics
    /// Panics if the pixel does not exist.
    pub fn polynomials(&self, pixel: usize, light: [f32; 2]) -> [f64; 3] {
        let terms = terms(light);
        let sum = |bytes: [u8; TERMS]| -> f64 {
            self.coefficients(bytes).iter().zip(terms).map(|(coefficient, term)| coefficient * term).sum()
        };
        match &self.model {
            PtmModel::Rgb(pixels) => pixels[pixel].map(sum),
            PtmModel::Lrgb { luminance, colour } => {
                let luminance = sum(luminance[pixel]);
                colour[pixel].map(|code| luminance * f64::from(code) / 255.0)
            }
        }
    }

    /// Parses a file. `decode` decodes the planes of compressed maps.
    ///
    /// # Errors
    /// Returns an error for another version or format, sizes, scales and biases out of range, a truncated header, a
    /// file that is shorter or longer than its header declares, and planes that cannot be decoded.
    pub fn from_bytes(bytes: &[u8], decode: DecodeJpeg<'_>) -> Result<Self, FormatError> {
        let mut header = Words { bytes, at: 0, line: 1, whole: "a header of 16 words" };
        let version = header.word("version")?;
        if ![VERSION, INTERLEAVED].contains(&version) {
            return Err(header.wrong("version", quoted(version), format!("{VERSION} or {INTERLEAVED}")));
        }
        let is_interleaved = version == INTERLEAVED;
        let format = header.word("format")?;
        if ![RGB, LRGB, JPEG_RGB, JPEG_LRGB].contains(&format) {
            let known = format.starts_with("PTM_FORMAT_");
            let found = if known { format!("the unsupported {}", quoted(format)) } else { quoted(format) };
            return Err(header.wrong("format", found, format!("{RGB}, {LRGB}, {JPEG_RGB} or {JPEG_LRGB}")));
        }
        let size = [header.digits("width", 1..=MAX_SIZE)?, header.digits("height", 1..=MAX_SIZE)?];
        let (mut scale, mut bias) = ([0.0; TERMS], [0; TERMS]);
        for scale in &mut scale {
            *scale = scale_of(&mut header)?;
        }
        for bias in &mut bias {
            *bias = header.whole_number("bias")?;
        }
        let (is_rgb, is_compressed) = ([RGB, JPEG_RGB].contains(&format), [JPEG_RGB, JPEG_LRGB].contains(&format));
        let model = if is_compressed {
            let planes = if is_rgb {
                compressed::planes::<18>(header, size, decode)?
            } else {
                compressed::planes::<9>(header, size, decode)?
            };
            PtmModel::of_planes(is_rgb, size, |plane, pixel| planes[plane][pixel])?
        } else {
            let pixels = header.end("the biases")?;
            let count = pixel_count(size)?;
            let per_pixel = if is_rgb { 3 * TERMS } else { TERMS + 3 };
            // At most 2^32 pixels of 18 bytes.
            if pixels.len() as u64 != count * per_pixel as u64 {
                let found = format!("{} bytes after the header", pixels.len());
                let allowed = format!("{} for {} x {} pixels", count * per_pixel as u64, size[0], size[1]);
                return Err(FormatError::whole("file length", found, allowed));
            }
            // A block for each channel, or one for luminance and one for colour.
            let stride = |block: usize| if is_rgb || block == 0 { TERMS } else { 3 };
            PtmModel::of_planes(is_rgb, size, |plane, pixel| {
                if is_interleaved && !is_rgb {
                    return pixels[pixel * per_pixel + plane];
                }
                let block = plane / TERMS;
                pixels[block * TERMS * count as usize + pixel * stride(block) + plane % TERMS]
            })?
        };
        Ok(Self { is_compressed, ..Self::new(size, scale, bias, model)? })
    }

    /// Bytes of an uncompressed file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let [width, height] = self.size;
        let words = |numbers: Vec<String>| numbers.join(" ");
        let scale = words(self.scale.iter().map(f32::to_string).collect());
        let bias = words(self.bias.iter().map(i32::to_string).collect());
        let mut bytes = format!("{VERSION}\n{}\n{width}\n{height}\n{scale}\n{bias}\n", self.model.name()).into_bytes();
        let (width, count) = (width as usize, width as usize * height as usize);
        match &self.model {
            PtmModel::Rgb(pixels) => {
                for channel in 0..3 {
                    bytes.extend(from_top(width, count).flat_map(|at| pixels[at][channel]));
                }
            }
            PtmModel::Lrgb { luminance, colour } => {
                bytes.extend(from_top(width, count).flat_map(|at| luminance[at]));
                bytes.extend(from_top(width, count).flat_map(|at| colour[at]));
            }
        }
        bytes
    }
}

/// Indices of pixels by row from the last to the first, each from the left. Its own inverse: files have the bottom row
/// first.
fn from_top(width: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count / width).rev().flat_map(move |row| row * width..(row + 1) * width)
}

fn scale_of(header: &mut Words<'_>) -> Result<f32, FormatError> {
    let word = header.word("scale")?;
    let scale = word.parse::<f32>().ok().filter(|scale| is_scale(*scale));
    scale.ok_or_else(|| header.wrong("scale", quoted(word), SCALES))
}

const SCALES: &str = "a finite number that is not 0";

fn is_scale(scale: f32) -> bool {
    scale.is_finite() && scale != 0.0
}

/// Scale and bias of each term.
struct Quantisation {
    scale: [f32; TERMS],
    bias: [i32; TERMS],
}

impl Quantisation {
    fn of(all: &[[f32; TERMS]]) -> Result<Self, FormatError> {
        let mut rule = Self { scale: [1.0; TERMS], bias: [0; TERMS] };
        for term in 0..TERMS {
            let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
            for coefficients in all {
                let value = coefficients[term];
                if !value.is_finite() {
                    return Err(FormatError::whole("coefficient", value.to_string(), "finite numbers"));
                }
                (lowest, highest) = (lowest.min(value.into()), highest.max(value.into()));
            }
            if lowest < highest {
                let least = ((highest - lowest) / 255.0).max(highest.max(-lowest) / MAX_BIAS);
                let rounded = least as f32;
                // A smaller scale would not span the range.
                rule.scale[term] = if f64::from(rounded) < least { rounded.next_up() } else { rounded };
                rule.bias[term] = -nearest(lowest, rule.scale[term]) as i32;
            } else if lowest.abs() > 0.0 && lowest.is_finite() {
                // Byte 1 if the coefficient is positive, otherwise byte 0.
                (rule.scale[term], rule.bias[term]) = (lowest.abs() as f32, i32::from(lowest < 0.0));
            }
        }
        Ok(rule)
    }

    fn bytes(&self, coefficients: [f32; TERMS]) -> [u8; TERMS] {
        std::array::from_fn(|term| {
            let steps = nearest(coefficients[term].into(), self.scale[term]);
            (steps + f64::from(self.bias[term])).clamp(0.0, 255.0) as u8
        })
    }
}

/// Rounds in the same direction everywhere, so that whole steps between two values stay whole.
fn nearest(value: f64, scale: f32) -> f64 {
    (value / f64::from(scale) + 0.5).floor()
}

#[cfg(test)]
mod tests;
