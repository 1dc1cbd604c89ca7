//! Colours in 32 bits: three 9-bit mantissas with a shared 5-bit exponent, as in `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32` and
//! `rgb9e5ufloat`. Red is in bits 0 to 8, green in 9 to 17, blue in 18 to 26, the exponent in 27 to 31.

/// Largest component, `511 / 512 * 2^16`.
pub const MAX: f32 = 65408.0;
/// Maximum relative error of the largest component of a colour between `2^-16` and [`MAX`].
pub const PRECISION: f32 = 1.0 / 512.0;

const MANTISSA_BITS: i32 = 9;
const BIAS: i32 = 15;

/// Nearest colour, rounded as Vulkan and OpenGL specify it. Components are clamped to `0..=`[`MAX`]; NaN becomes 0.
pub fn encode(colour: [f32; 3]) -> u32 {
    // NaN is not greater than 0, so it becomes 0.
    let clamped = colour.map(|c| f64::from(if c > 0.0 { c.min(MAX) } else { 0.0 }));
    let largest = clamped.into_iter().fold(0.0, f64::max);
    let exponent = floor_log2(largest).max(-BIAS - 1) + 1 + BIAS;
    // Division by powers of two and the added half are exact in f64.
    let steps = |c: f64, exponent: i32| (c / 2f64.powi(exponent - BIAS - MANTISSA_BITS) + 0.5).floor() as u32;
    let exponent = exponent + i32::from(steps(largest, exponent) == 1 << MANTISSA_BITS);
    let [r, g, b] = clamped.map(|c| steps(c, exponent));
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

/// Exact colour of a texel.
#[inline]
pub fn decode(texel: u32) -> [f32; 3] {
    // 2^(exponent - 24) is always a normal number; assembling its bits is cheaper than a power.
    let step = f32::from_bits(((texel >> 27) + (127 - BIAS - MANTISSA_BITS) as u32) << 23);
    [texel, texel >> 9, texel >> 18].map(|bits| (bits & 511) as f32 * step)
}

/// Floor of the binary logarithm; for 0, a number far below every exponent in use.
fn floor_log2(value: f64) -> i32 {
    (value.to_bits() >> 52) as i32 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_texels() {
        for (colour, texel) in [
            ([0.0; 3], 0),
            ([1.0, 0.0, 0.0], 256 | 16 << 27),
            ([0.0, 1.0, 0.0], 256 << 9 | 16 << 27),
            ([0.0, 0.5, 1.0], 128 << 9 | 256 << 18 | 16 << 27),
            ([MAX; 3], u32::MAX),
            ([f32::INFINITY, f32::MAX, 1e6], u32::MAX),
            ([f32::NAN, -1.0, f32::NEG_INFINITY], 0),
            ([2f32.powi(-24), 0.0, 0.0], 1),
            ([2f32.powi(-25), 0.0, 0.0], 1),
            ([2f32.powi(-25) * 0.999, 1e-40, 0.0], 0),
            // 511.5 steps carry into the exponent.
            ([511.5 / 512.0, 0.0, 0.0], 256 | 16 << 27),
            ([511.49 / 512.0, 0.0, 0.0], 511 | 15 << 27),
            // One ulp below half a step, which an addition in f32 rounds up.
            ([1.0, 0.5f32.next_down() / 256.0, 0.5 / 256.0], 256 | 1 << 18 | 16 << 27),
        ] {
            assert_eq!(encode(colour), texel, "{colour:?}");
        }
        assert_eq!(decode(u32::MAX), [MAX; 3]);
        assert_eq!(decode(1), [2f32.powi(-24), 0.0, 0.0]);
    }

    proptest! {
        #[test]
        fn the_largest_component_is_precise(colour in prop::array::uniform3(0.0f32..1.0), scale in -14i32..16) {
            let colour = colour.map(|c| c * 2f32.powi(scale));
            let decoded = decode(encode(colour));
            let largest = colour.into_iter().fold(0.0, f32::max);
            prop_assume!(largest >= 2f32.powi(-16));
            for k in 0..3 {
                prop_assert!((decoded[k] - colour[k]).abs() <= largest * PRECISION, "{colour:?} {decoded:?}");
            }
        }

        #[test]
        fn decoded_texels_round_trip(texel in any::<u32>()) {
            // Texels with small mantissas have an equivalent form with a lower exponent, so colours are compared.
            prop_assert_eq!(decode(encode(decode(texel))), decode(texel));
        }
    }
}
