//! Conversion of decorrelated channels to linear RGB.

use brdfc_formats::FormatError;
use brdfc_formats::vector_math::exp;

/// Added to values before taking the logarithm.
const EPSILON: f32 = 1e-5;

/// Conversion of the three channels of a file to linear red, green and blue. Discriminants are the codes in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(i32)]
pub enum ColourModel {
    /// Linear red, green and blue, without a conversion.
    Rgb = 0,
    /// Luma and two colour differences.
    Yuv = 1,
    /// `transform` row by row: `rgb[j] = Σ_i channel[i] transform[i][j] + mean[j]`.
    Pca {
        /// Added at the end.
        mean: [f32; 3],
        /// One row for each channel.
        transform: [[f32; 3]; 3],
    } = 3,
    /// Luma, orange and green: `[Y + Co - Cg, Y + Cg, Y - Co - Cg]`.
    YCoCg = 4,
    /// YUV with Y stored as `ln(Y + 1e-5)`.
    LogYuv = 9,
    /// Same as [`Self::LogYuv`], with U and V as `sign(U) ln(|U| / 1e-5)`.
    LogLogYuv = 10,
    /// Same as [`Self::LogYuv`], with U and V as shares of `Y + 1e-5`. Files of the database use this model.
    LogYRatioUv = 11,
    /// `ln(value + 1e-5)` of red, green and blue.
    LogRgb = 12,
}

impl ColourModel {
    /// Creates the model of a code; `mean` and `transform` come from the file.
    ///
    /// # Errors
    /// Returns an error at that byte for any other code.
    pub(super) fn from_code(
        code: i32,
        mean: [f32; 3],
        transform: [[f32; 3]; 3],
        offset: u64,
    ) -> Result<Self, FormatError> {
        let found = match code {
            0 => return Ok(Self::Rgb),
            1 => return Ok(Self::Yuv),
            3 => {
                let model = Self::Pca { mean, transform };
                if model.is_finite() {
                    return Ok(model);
                }
                let found = format!("{mean:?} and {transform:?}");
                return Err(FormatError::at_byte(offset + 4, "colour mean, transform", found, "finite numbers"));
            }
            4 => return Ok(Self::YCoCg),
            9 => return Ok(Self::LogYuv),
            10 => return Ok(Self::LogLogYuv),
            11 => return Ok(Self::LogYRatioUv),
            12 => return Ok(Self::LogRgb),
            2 => "2 (L*a*b*)".to_owned(),
            5 | 6 => format!("{code} (spectral)"),
            other => other.to_string(),
        };
        Err(FormatError::at_byte(offset, "colour model", found, "0, 1, 3, 4, 9, 10, 11 or 12"))
    }

    /// The code in the file.
    pub fn code(self) -> i32 {
        match self {
            Self::Rgb => 0,
            Self::Yuv => 1,
            Self::Pca { .. } => 3,
            Self::YCoCg => 4,
            Self::LogYuv => 9,
            Self::LogLogYuv => 10,
            Self::LogYRatioUv => 11,
            Self::LogRgb => 12,
        }
    }

    pub(super) fn is_finite(self) -> bool {
        match self {
            Self::Pca { mean, transform } => mean.iter().chain(transform.iter().flatten()).all(|v| v.is_finite()),
            _ => true,
        }
    }

    /// Linear RGB of three channels from the matrices.
    pub fn to_rgb(self, [a, b, c]: [f32; 3]) -> [f32; 3] {
        let luma = || exp(a) - EPSILON;
        let signed = |v: f32| if v == 0.0 { 0.0 } else { (EPSILON * exp(v.abs())).copysign(v) };
        match self {
            Self::Rgb => [a, b, c],
            Self::Yuv => yuv_to_rgb([a, b, c]),
            Self::Pca { mean, transform: [p, q, r] } => {
                std::array::from_fn(|j| a * p[j] + b * q[j] + c * r[j] + mean[j])
            }
            Self::YCoCg => [a + b - c, a + c, a - b - c],
            Self::LogYuv => yuv_to_rgb([luma(), b, c]),
            Self::LogLogYuv => yuv_to_rgb([luma(), signed(b), signed(c)]),
            Self::LogYRatioUv => {
                let scale = exp(a);
                yuv_to_rgb([scale - EPSILON, b * scale, c * scale])
            }
            Self::LogRgb => [a, b, c].map(|v| exp(v) - EPSILON),
        }
    }
}

/// Analogue YUV to RGB, of linear values.
fn yuv_to_rgb([y, u, v]: [f32; 3]) -> [f32; 3] {
    [y + 1.13983 * v, y - 0.39465 * u - 0.5806 * v, y + 2.03211 * u]
}
