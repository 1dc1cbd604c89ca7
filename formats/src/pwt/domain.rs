//! In which scale texels are sums of terms.

use crate::vector_math::{exp, ln};

/// A scale of linear values, 0 or more. Errors of least squares spread over it evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// The values themselves.
    Linear,
    /// The codes of sRGB, 0 to 1 for the values 0 to 1.
    Display,
    /// Cube roots, as lightness has them.
    CubeRoot,
    /// `ln(value + ε)`.
    Logarithm {
        /// `ε`, positive.
        epsilon: f32,
    },
}

/// Largest value that comes out: the largest half.
pub const LARGEST: f32 = 65504.0;

impl Domain {
    /// The name that scripts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Display => "display",
            Self::CubeRoot => "cube-root",
            Self::Logarithm { .. } => "log",
        }
    }

    /// The number that files have, and `ε`, 0 where there is none.
    pub fn code(self) -> (u32, f32) {
        match self {
            Self::Linear => (0, 0.0),
            Self::Display => (1, 0.0),
            Self::CubeRoot => (2, 0.0),
            Self::Logarithm { epsilon } => (3, epsilon),
        }
    }

    /// The domain of a number.
    pub fn from_code(code: u32, epsilon: f32) -> Option<Self> {
        match code {
            0 => Some(Self::Linear),
            1 => Some(Self::Display),
            2 => Some(Self::CubeRoot),
            3 => Some(Self::Logarithm { epsilon }),
            _ => None,
        }
    }

    /// A linear value on this scale; what is negative counts as 0.
    pub fn encode(self, value: f32) -> f32 {
        let value = value.max(0.0);
        match self {
            Self::Linear => value,
            Self::Display => {
                if value <= 0.003_130_8 {
                    12.92 * value
                } else {
                    1.055 * exp(ln(value) / 2.4) - 0.055
                }
            }
            Self::CubeRoot => value.cbrt(),
            Self::Logarithm { epsilon } => ln(value + epsilon),
        }
    }

    /// The linear value, 0 to [`LARGEST`].
    pub fn decode(self, value: f32) -> f32 {
        let linear = match self {
            Self::Linear => value,
            Self::Display => {
                if value <= 0.040_45 {
                    value / 12.92
                } else {
                    exp(2.4 * ln((value + 0.055) / 1.055))
                }
            }
            Self::CubeRoot => value * value * value,
            Self::Logarithm { epsilon } => exp(value) - epsilon,
        };
        if linear > 0.0 && !value.is_nan() { linear.min(LARGEST) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::encode_srgb;

    const ALL: [Domain; 4] = [Domain::Linear, Domain::Display, Domain::CubeRoot, Domain::Logarithm { epsilon: 0.01 }];

    #[test]
    fn there_and_back() {
        for domain in ALL {
            let (code, epsilon) = domain.code();
            assert_eq!(Domain::from_code(code, epsilon), Some(domain));
            for k in 0..=1000 {
                let value = k as f32 / 500.0;
                let back = domain.decode(domain.encode(value));
                assert!((back - value).abs() <= 2e-6 * (value + 0.01) + 1e-7, "{domain:?} {value} {back}");
            }
            assert_eq!(domain.encode(-1.0), domain.encode(0.0));
            assert!(domain.decode(f32::NAN) == 0.0 && domain.decode(1e30) <= LARGEST && domain.decode(-1e30) == 0.0);
        }
        assert_eq!(Domain::from_code(4, 0.0), None);
    }

    #[test]
    fn display_codes_are_those_of_srgb() {
        for k in 0..=255 {
            let value = k as f32 / 255.0;
            assert!((f64::from(Domain::Display.encode(value)) - encode_srgb(f64::from(value))).abs() < 1e-6);
        }
    }
}
