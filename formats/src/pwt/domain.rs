//! Scale in which texels are sums of terms.

use crate::vector_math::{exp, ln};

/// Scale of linear, non-negative values. A least-squares fit distributes its errors evenly over the scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// The linear values themselves.
    Linear,
    /// sRGB-encoded values, 0 to 1 for linear 0 to 1.
    Display,
    /// Cube roots, as in CIE lightness.
    CubeRoot,
    /// Logarithms, `ln(value + ε)`.
    Logarithm {
        /// `ε`, added to values before the logarithm, positive.
        epsilon: f32,
    },
}

/// Largest decoded value: the largest half.
pub const LARGEST: f32 = 65504.0;

impl Domain {
    /// Name for command line and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Display => "display",
            Self::CubeRoot => "cube-root",
            Self::Logarithm { .. } => "log",
        }
    }

    /// Number in files, and `ε`, 0 if there is none.
    pub fn code(self) -> (u32, f32) {
        match self {
            Self::Linear => (0, 0.0),
            Self::Display => (1, 0.0),
            Self::CubeRoot => (2, 0.0),
            Self::Logarithm { epsilon } => (3, epsilon),
        }
    }

    /// Domain with this number in files.
    pub fn from_code(code: u32, epsilon: f32) -> Option<Self> {
        match code {
            0 => Some(Self::Linear),
            1 => Some(Self::Display),
            2 => Some(Self::CubeRoot),
            3 => Some(Self::Logarithm { epsilon }),
            _ => None,
        }
    }

    /// Encodes a linear value. Negative values count as 0, except for [`Self::Display`], which continues linearly,
    /// because polynomials of sRGB-encoded values can be negative.
    pub fn encode(self, value: f32) -> f32 {
        let mut values = [value];
        self.encode_each(&mut values);
        values[0]
    }

    /// [`Self::encode`] for many values, with the same bits; uses SIMD.
    pub fn encode_each(self, values: &mut [f32]) {
        match self {
            Self::Linear => values.iter_mut().for_each(|v| *v = v.max(0.0)),
            Self::Display => values.iter_mut().for_each(|v| *v = display_code(*v)),
            Self::CubeRoot => values.iter_mut().for_each(|v| *v = cube_root(v.max(0.0))),
            Self::Logarithm { epsilon } => values.iter_mut().for_each(|v| *v = ln(v.max(0.0) + epsilon)),
        }
    }

    /// Decodes to a linear value, 0 to [`LARGEST`].
    pub fn decode(self, value: f32) -> f32 {
        let mut values = [value];
        self.decode_each(&mut values);
        values[0]
    }

    /// [`Self::decode`] for many values, with the same bits.
    pub fn decode_each(self, values: &mut [f32]) {
        // NaN becomes 0.
        let within = |linear: f32, value: f32| if linear > 0.0 && !value.is_nan() { linear.min(LARGEST) } else { 0.0 };
        match self {
            Self::Linear => values.iter_mut().for_each(|v| *v = within(*v, *v)),
            Self::Display => values.iter_mut().for_each(|v| *v = within(of_display_code(*v), *v)),
            Self::CubeRoot => values.iter_mut().for_each(|v| *v = within(*v * *v * *v, *v)),
            Self::Logarithm { epsilon } => values.iter_mut().for_each(|v| *v = within(exp(*v) - epsilon, *v)),
        }
    }
}

/// Smallest argument of the logarithm.
const TINY: f32 = 1e-30;

#[inline]
fn display_code(value: f32) -> f32 {
    let high = 1.055 * exp(ln(value.max(TINY)) * (1.0 / 2.4)) - 0.055;
    if value <= 0.003_130_8 { 12.92 * value } else { high }
}

#[inline]
fn of_display_code(code: f32) -> f32 {
    let high = exp(2.4 * ln(((code + 0.055) * (1.0 / 1.055)).max(TINY)));
    if code <= 0.040_45 { code * (1.0 / 12.92) } else { high }
}

#[inline]
fn cube_root(value: f32) -> f32 {
    let root = exp(ln(value.max(TINY)) * (1.0 / 3.0));
    if value > TINY { root } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_readers::colour::encode_srgb;

    const ALL: [Domain; 4] = [Domain::Linear, Domain::Display, Domain::CubeRoot, Domain::Logarithm { epsilon: 0.01 }];

    #[test]
    fn values_round_trip() {
        for domain in ALL {
            let (code, epsilon) = domain.code();
            assert_eq!(Domain::from_code(code, epsilon), Some(domain));
            for k in 0..=1000 {
                let value = k as f32 / 500.0;
                let back = domain.decode(domain.encode(value));
                assert!((back - value).abs() <= 2e-6 * (value + 0.01) + 1e-7, "{domain:?} {value} {back}");
            }
            let below = domain.encode(-1.0);
            assert!(if domain == Domain::Display { below == -12.92 } else { below == domain.encode(0.0) });
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
