//! Colour of code values: what a file states, and the conversion to linear RGB of Rec. 709.

use super::raster::{Raster, Samples, collected};
use brdfc_core::words::one_line;
use brdfc_formats::FormatError;
use brdfc_formats::memory::filled;
use brdfc_readers::colour::{decode_srgb, encode_srgb};
use brdfc_readers::pixels::Pixels;
use moxcms::{ColorProfile, DataColorSpace, Matrix3d, ParsingOptions, ProfileText, ToneReprCurve, XyY, adapt_to_d50_d};
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// Maximum difference of a curve from that of sRGB, and of a matrix from the identity, that counts as rounding.
const MAX_ROUNDING: f64 = 2e-3;
/// Same for linear curves: a table of 16 bits.
const LINEAR_ROUNDING: f64 = 2e-5;
/// Maximum difference of the white of a matrix from that of Rec. 709, per channel. The white of camera profiles is not exact.
const MAX_WHITE_ERROR: f64 = 0.2;
/// Maximum excess over the gamut of Rec. 709 that counts as rounding: matrices of files have four or five digits.
pub(crate) const GAMUT_ROUNDING: f64 = 1e-4;
/// Code values of which curves are compared.
const COMPARED: usize = 256;
/// Pixels of a task.
const CHUNK: usize = 1 << 14;
/// Least of the areas that a white and two primaries enclose, and of the y of a white.
const MIN_AREA: f64 = 1e-4;
/// Chromaticities of the primaries (ITU-R BT.709, item 1.3).
const REC_709: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
/// White D65 (ITU-R BT.709, item 1.4).
const D65: [f64; 2] = [0.3127, 0.3290];
/// Chromaticities of the red, green and blue primaries of Adobe RGB (1998), whose white is D65.
const ADOBE_RGB: [[f64; 2]; 3] = [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06]];
/// Exponent of Adobe RGB (1998).
const ADOBE_RGB_GAMMA: f64 = 563.0 / 256.0;

/// Meaning of code values in spite of what files state; the primaries are those of Rec. 709.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CodeValues {
    /// Proportional to light.
    Linear,
    /// sRGB.
    Srgb,
}

/// Curve from code values, 0 to 1, to linear values.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Curve {
    /// `g, a, b, c, d, e, f` of ICC: `(a x + b)^g + e` from `d`, and `c x + f` below.
    Parametric([f64; 7]),
    /// Values of 16 bits, at equal distances.
    Table(Vec<u16>),
}

impl Curve {
    pub(super) const LINEAR: Self = Self::Parametric([1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    const SRGB: Self = Self::Parametric([2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.040_45, 0.0, 0.0]);

    pub(super) const fn power(exponent: f64) -> Self {
        Self::Parametric([exponent, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    pub(super) fn eval(&self, code: f64) -> f64 {
        match self {
            Self::Parametric([_, _, _, c, d, _, f]) if code < *d => c * code + f,
            Self::Parametric([g, a, b, _, _, e, _]) => (a * code + b).powf(*g) + e,
            Self::Table(values) => {
                let position = code.clamp(0.0, 1.0) * (values.len() - 1) as f64;
                let below = (position as usize).min(values.len().saturating_sub(2));
                let [low, high] = [below, (below + 1).min(values.len() - 1)].map(|at| f64::from(values[at]));
                (low + (high - low) * (position - below as f64)) / 65535.0
            }
        }
    }

    /// Curve of an ICC profile; `None` without a valid one.
    fn of_icc(curve: &ToneReprCurve) -> Option<Self> {
        let of = |values: &[f32]| -> Option<[f64; 7]> {
            let at = |k: usize| values.get(k).copied().map_or(0.0, f64::from);
            let [g, a, b, c, d] = [at(0), at(1), at(2), at(3), at(4)];
            Some(match values.len() {
                1 => [g, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                3 if a != 0.0 => [g, a, b, 0.0, -b / a, 0.0, 0.0],
                4 if a != 0.0 => [g, a, b, 0.0, -b / a, c, c],
                5 => [g, a, b, c, d, 0.0, 0.0],
                7 => [g, a, b, c, d, at(5), at(6)],
                _ => return None,
            })
        };
        Some(match curve {
            ToneReprCurve::Parametric(values) => Self::Parametric(of(values)?),
            ToneReprCurve::Lut(values) => match values[..] {
                [] => Self::LINEAR,
                [gamma] => Self::power(f64::from(gamma) / 256.0),
                _ => Self::Table(values.clone()),
            },
        })
    }

    /// Compares two curves; false for curves with values that are not finite.
    fn is_near(&self, other: &Self, tolerance: f64) -> bool {
        let mut codes = (0..=COMPARED).map(|k| k as f64 / COMPARED as f64);
        codes.all(|code| (self.eval(code) - other.eval(code)).abs() <= tolerance)
    }
}

type Matrix = [[f64; 3]; 3];

/// Conversion of code values to linear RGB of Rec. 709.
#[derive(Debug, Clone, PartialEq)]
enum Conversion {
    Srgb,
    Linear,
    Curves(Box<Curves>),
}

/// Curves of the channels, and the matrix after them.
#[derive(Debug, Clone, PartialEq)]
struct Curves {
    curves: [Curve; 3],
    matrix: Option<Matrix>,
}

/// Colour of the code values of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Colour {
    stated: String,
    conversion: Conversion,
}

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.conversion {
            Conversion::Curves(_) => write!(f, "{}, converted to linear Rec. 709", self.stated),
            Conversion::Srgb | Conversion::Linear => f.write_str(&self.stated),
        }
    }
}

impl Colour {
    pub(super) fn srgb(stated: &str) -> Self {
        Self { stated: stated.to_owned(), conversion: Conversion::Srgb }
    }

    pub(super) fn linear(stated: &str) -> Self {
        Self { stated: stated.to_owned(), conversion: Conversion::Linear }
    }

    /// Adobe RGB (1998).
    pub(super) fn adobe_rgb(stated: &str) -> Result<Self, FormatError> {
        let curve = Curve::power(ADOBE_RGB_GAMMA);
        Self::new(stated, [curve.clone(), curve.clone(), curve], Some(from_primaries(stated, ADOBE_RGB, D65)?))
    }

    /// Colour of one curve for all channels and primaries; Rec. 709 without chromaticities of red, green, blue and white.
    pub(super) fn of_curve(stated: &str, curve: Curve, primaries: Option<[[f64; 2]; 4]>) -> Result<Self, FormatError> {
        let matrix = primaries.map(|[r, g, b, white]| from_primaries(stated, [r, g, b], white)).transpose()?;
        Self::new(stated, [curve.clone(), curve.clone(), curve], matrix)
    }

    /// Same as [`Self::of_curve`] with the curve of sRGB.
    pub(super) fn of_srgb_curve(stated: &str, primaries: [[f64; 2]; 4]) -> Result<Self, FormatError> {
        Self::of_curve(stated, Curve::SRGB, Some(primaries))
    }

    /// Colour of an ICC profile with curves, and for RGB with a matrix.
    pub(super) fn of_profile(icc: &[u8], channels: usize) -> Result<Self, FormatError> {
        let wrong =
            |found: &str| FormatError::whole("ICC profile", found, "curves and a matrix of RGB, or a curve of grey");
        let options = ParsingOptions { max_allowed_trc_size: 1 << 16, ..ParsingOptions::default() };
        let profile = ColorProfile::new_from_slice_with_options(icc, options);
        let profile = profile.map_err(|error| wrong(&one_line(&error)).problem())?;
        let name =
            profile.description.as_ref().and_then(name).map_or("ICC profile".to_owned(), |n| format!("{n} profile"));
        match profile.color_space {
            DataColorSpace::Gray if channels < 3 => {
                let curve = profile.gray_trc.as_ref().and_then(Curve::of_icc).ok_or_else(|| wrong("no valid curve"))?;
                Self::of_curve(&name, curve, None)
            }
            DataColorSpace::Rgb => Self::of_rgb(&name, &profile).and_then(|colour| {
                colour.ok_or_else(|| {
                    wrong(if profile.red_trc.is_none() { "a profile of tables" } else { "no valid curve" })
                })
            }),
            other => Err(wrong(&format!("a profile of {other:?} for {} channels", channels.min(3)))),
        }
    }

    /// Colour of the curves and the matrix of a profile; `None` without curves.
    pub(super) fn of_rgb(stated: &str, profile: &ColorProfile) -> Result<Option<Self>, FormatError> {
        let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
        let [Some(r), Some(g), Some(b)] = curves.map(|curve| curve.as_ref().and_then(Curve::of_icc)) else {
            return Ok(None);
        };
        Self::new(stated, [r, g, b], Some(from_d50(profile.colorant_matrix()))).map(Some)
    }

    fn new(stated: &str, curves: [Curve; 3], matrix: Option<Matrix>) -> Result<Self, FormatError> {
        let is_finite = |curve: &Curve| (0..=COMPARED).all(|k| curve.eval(k as f64 / COMPARED as f64).is_finite());
        if !(curves.iter().all(is_finite) && matrix.iter().flatten().flatten().all(|m| m.is_finite())) {
            return Err(FormatError::whole("colour", stated, "curves and primaries of finite values"));
        }
        let curves =
            curves.map(|curve| if curve.is_near(&Curve::LINEAR, LINEAR_ROUNDING) { Curve::LINEAR } else { curve });
        let identity = |m: &Matrix| {
            let off = |r: usize, c: usize| (m[r][c] - if r == c { 1.0 } else { 0.0 }).abs();
            (0..9).all(|k| off(k / 3, k % 3) <= MAX_ROUNDING)
        };
        if let Some(white) = matrix.as_ref().map(|matrix| transform(matrix, [1.0; 3]))
            && white.iter().any(|w| (w - 1.0).abs() > MAX_WHITE_ERROR)
        {
            let found = format!("a matrix whose white is {white:.3?} in Rec. 709");
            return Err(FormatError::whole(format!("colour of {stated}"), found, "about [1, 1, 1]"));
        }
        let matrix = matrix.filter(|matrix| !identity(matrix));
        let all = |is: &dyn Fn(&Curve) -> bool| matrix.is_none() && curves.iter().all(is);
        let conversion = match () {
            () if all(&|curve| curve.is_near(&Curve::SRGB, MAX_ROUNDING)) => Conversion::Srgb,
            () if all(&|curve| *curve == Curve::LINEAR) => Conversion::Linear,
            () => Conversion::Curves(Box::new(Curves { curves, matrix })),
        };
        let stated = match conversion {
            Conversion::Srgb if !stated.contains("sRGB") => format!("{stated}, sRGB"),
            Conversion::Linear if !stated.contains("linear") => format!("{stated}, linear"),
            _ => stated.to_owned(),
        };
        Ok(Self { stated, conversion })
    }

    /// Colour that a caller states.
    pub(super) fn given(codes: CodeValues) -> Self {
        match codes {
            CodeValues::Linear => Self::linear("read as linear Rec. 709"),
            CodeValues::Srgb => Self::srgb("read as sRGB"),
        }
    }

    /// Returns true if pixels of 8 bits remain pixels of 8 bits.
    pub(super) fn is_srgb(&self) -> bool {
        self.conversion == Conversion::Srgb
    }

    /// Pixels of a raster, and the number of those outside the gamut of Rec. 709 that are clipped: those of integers.
    /// Integers that are not sRGB become sRGB levels of 16 bits.
    ///
    /// # Errors
    /// Returns an error if there is not enough memory.
    pub(super) fn pixels(&self, raster: Raster) -> Result<(Pixels, usize), FormatError> {
        let channels = raster.channels;
        let pixels = match (raster.samples, self.is_srgb()) {
            (Samples::U8(codes), true) => Pixels::Levels8(Arc::new(collected(triples(&codes, channels))?)),
            (Samples::U16(codes), true) => Pixels::Levels16(Arc::new(collected(triples(&codes, channels))?)),
            (Samples::U8(codes), false) => return self.levels(&codes, channels, 255),
            (Samples::U16(codes), false) => return self.levels(&codes, channels, 65535),
            (Samples::F32(codes), _) => {
                let of = |codes: &[f32; 3]| self.linear_of(codes.map(f64::from)).map(|value| value as f32);
                let mut pixels = collected(triples(&codes, channels))?;
                if self.conversion != Conversion::Linear {
                    pixels.par_iter_mut().for_each(|pixel| *pixel = of(pixel));
                }
                pixels.into()
            }
        };
        Ok((pixels, 0))
    }

    fn linear_of(&self, codes: [f64; 3]) -> [f64; 3] {
        match &self.conversion {
            Conversion::Srgb => codes.map(decode_srgb),
            Conversion::Linear => codes,
            Conversion::Curves(of) => {
                let linear = std::array::from_fn(|c| of.curves[c].eval(codes[c]));
                of.matrix.as_ref().map_or(linear, |matrix| transform(matrix, linear))
            }
        }
    }

    /// sRGB levels of 16 bits of codes up to `white`, and the number of clipped pixels.
    fn levels<T: Copy + Sync + Into<u16>>(
        &self,
        codes: &[T],
        channels: usize,
        white: u16,
    ) -> Result<(Pixels, usize), FormatError> {
        let level = |linear: f64| (65535.0 * encode_srgb(linear)).round() as u16;
        let matrix = if let Conversion::Curves(of) = &self.conversion { of.matrix.as_ref() } else { None };
        let curve = |c: usize, code: f64| match &self.conversion {
            Conversion::Curves(of) => of.curves[c].eval(code),
            _ => self.linear_of([code; 3])[c],
        };
        let linear: [Vec<f64>; 3] =
            std::array::from_fn(|c| (0..=white).map(|code| curve(c, f64::from(code) / f64::from(white))).collect());
        // Curves alone leave no gamut.
        let Some(matrix) = matrix else {
            let alone = linear.map(|values| values.into_iter().map(level).collect::<Vec<u16>>());
            let of = |codes: [T; 3]| std::array::from_fn(|c| alone[c][usize::from(codes[c].into())]);
            return Ok((Pixels::Levels16(Arc::new(collected(triples(codes, channels).map(of))?)), 0));
        };
        let is_outside = |value: &f64| !(-GAMUT_ROUNDING..=1.0 + GAMUT_ROUNDING).contains(value);
        let mut pixels = filled("pixels", codes.len() / channels, [0; 3])?;
        let parts = pixels.par_chunks_mut(CHUNK).zip(codes.par_chunks(CHUNK * channels));
        let clipped = parts.map(|(pixels, codes)| {
            let mut clipped = 0;
            for (pixel, codes) in pixels.iter_mut().zip(triples(codes, channels)) {
                let converted = transform(matrix, std::array::from_fn(|c| linear[c][usize::from(codes[c].into())]));
                clipped += usize::from(converted.iter().any(is_outside));
                *pixel = converted.map(level);
            }
            clipped
        });
        let clipped = clipped.sum();
        Ok((Pixels::Levels16(Arc::new(pixels)), clipped))
    }
}

/// Grey or RGB of each pixel, without alpha.
pub(super) fn triples<T: Copy>(codes: &[T], channels: usize) -> impl ExactSizeIterator<Item = [T; 3]> {
    codes.chunks_exact(channels).map(move |c| if channels < 3 { [c[0]; 3] } else { [c[0], c[1], c[2]] })
}

fn transform(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| matrix[r][0] * v[0] + matrix[r][1] * v[1] + matrix[r][2] * v[2])
}

/// Matrix to Rec. 709 from RGB whose XYZ columns are relative to the white D50.
fn from_d50(columns: Matrix3d) -> Matrix {
    columns_of(REC_709, D65).inverse().mat_mul(columns).v
}

/// XYZ of primaries, adapted to the white D50 by the Bradford transform.
fn columns_of(primaries: [[f64; 2]; 3], white: [f64; 2]) -> Matrix3d {
    let [r, g, b] = primaries.map(|[x, y]| [x, y, 1.0 - x - y]);
    let white = XyY::new(white[0], white[1], 1.0);
    let columns = Matrix3d { v: std::array::from_fn(|k| [r[k], g[k], b[k]]) };
    adapt_to_d50_d(ColorProfile::rgb_to_xyz_d(columns, white.to_xyzd()), white)
}

/// Matrix to Rec. 709 from RGB of some primaries, whose white becomes D65.
fn from_primaries(stated: &str, primaries: [[f64; 2]; 3], white: [f64; 2]) -> Result<Matrix, FormatError> {
    // Twice the areas of the triangles between the white and two primaries.
    let area = |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let [r, g, b] = primaries;
    let parts = [[r, g, white], [g, b, white], [b, r, white]].map(area);
    let is_inside = parts.iter().all(|part| *part > MIN_AREA) || parts.iter().all(|part| *part < -MIN_AREA);
    if is_inside && white[1] > MIN_AREA {
        return Ok(from_d50(columns_of(primaries, white)));
    }
    let found = format!("{primaries:?} around {white:?}");
    Err(FormatError::whole(stated.to_owned(), found, "primaries that enclose the white"))
}

/// Name of a profile, on one line.
fn name(text: &ProfileText) -> Option<String> {
    let name = match text {
        ProfileText::PlainString(text) => text.as_str(),
        ProfileText::Localizable(texts) => texts.first()?.value.as_str(),
        ProfileText::Description(text) if text.ascii_string.is_empty() => text.unicode_string.as_str(),
        ProfileText::Description(text) => text.ascii_string.as_str(),
    };
    let visible: String = name.chars().filter(|c| !c.is_control()).take(60).collect();
    let name = visible.trim();
    (!name.is_empty()).then(|| name.to_owned())
}
