//! IEEE 754 half precision, as used in textures of 16-bit floats.

/// Largest finite number of half precision.
pub const MAX: f32 = 65504.0;

/// Bits of the half nearest to `value`, ties to even. Values beyond the largest half become infinity; NaN becomes a
/// quiet NaN.
pub fn encode(value: f32) -> u16 {
    let sign = ((value.to_bits() >> 16) & 0x8000) as u16;
    let magnitude = value.abs();
    if magnitude.is_nan() {
        return sign | 0x7e00;
    }
    // Halfway between the largest half and the next power of two rounds to the even one, infinity.
    if magnitude >= 65520.0 {
        return sign | 0x7c00;
    }
    // One ulp of the half around this value; subnormal halves have a step of 2^-24.
    let exponent = (magnitude.to_bits() >> 23) as i32 - 127;
    let step_exponent = exponent.max(-14) - 10;
    // Scaling by a power of two is exact in f64. A carry out of the mantissa increments the exponent.
    let steps = (f64::from(magnitude) * 2f64.powi(-step_exponent)).round_ties_even() as u32;
    let biased = if exponent < -14 { 0 } else { (exponent + 14) as u32 };
    sign | (biased * 1024 + steps) as u16
}

/// Exact value of a half; NaN for NaN.
pub fn decode(bits: u16) -> f32 {
    // Reinterpreted as an f32 the exponent is 112 too low. Multiplication by 2^112 is exact, also for subnormals.
    let magnitude = match bits & 0x7fff {
        0x7c00 => f32::INFINITY,
        beyond if beyond > 0x7c00 => f32::NAN,
        finite => f32::from_bits(u32::from(finite) << 13) * f32::from_bits((112 + 127) << 23),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_halves() {
        for (value, bits) in [
            (0.0, 0),
            (-0.0, 0x8000),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65504.0, 0x7bff),
            (65519.99, 0x7bff),
            (65520.0, 0x7c00),
            (f32::NEG_INFINITY, 0xfc00),
            (2f32.powi(-14), 0x0400),
            (2f32.powi(-24), 1),
            (2f32.powi(-25), 0),
            (2f32.powi(-25) * 1.000_001, 1),
            (1.0 / 3.0, 0x3555),
            (1.0 + 2f32.powi(-11), 0x3c00),
            (1.0 + 3.0 * 2f32.powi(-11), 0x3c02),
            (f32::MIN_POSITIVE / 4.0, 0),
        ] {
            assert_eq!(encode(value), bits, "{value}");
        }
        assert!(decode(encode(f32::NAN)).is_nan());
        assert_eq!((decode(0x3c01), decode(0x03ff)), (1.0 + 2f32.powi(-10), 1023.0 / 16_777_216.0));
    }

    #[test]
    fn every_half_round_trips() {
        for bits in 0..=u16::MAX {
            let value = decode(bits);
            assert!(encode(value) == bits || value.is_nan() && (bits & 0x7fff) > 0x7c00, "{bits:#x}");
        }
    }

    proptest! {
        #[test]
        fn no_half_is_nearer(value in -MAX..MAX, scale in -20i32..1) {
            let value = value * 2f32.powi(scale);
            let bits = encode(value);
            let distance = |bits: u16| (f64::from(decode(bits)) - f64::from(value)).abs();
            if bits & 0x7fff < 0x7bff {
                prop_assert!(distance(bits) <= distance(bits + 1));
            }
            if bits & 0x7fff > 0 {
                prop_assert!(distance(bits) <= distance(bits - 1));
            }
        }
    }
}
