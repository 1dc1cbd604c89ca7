//! Branch-free exponential and logarithm in f32, which compilers vectorise in loops. The functions of the standard
//! library are calls and do not vectorise; one grid needs about ten million evaluations.
//!
//! The polynomials are minimax fits on the reduced range. The tests bound their error.

/// `exp(x)` with a relative error below 2.5e-7 for `|x| <= 80`; saturates outside.
#[inline]
pub fn exp(x: f32) -> f32 {
    const C: [f32; 5] = [0.5, 1.666_652e-1, 4.166_620_6e-2, 8.368_882e-3, 1.395_047_8e-3];
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    // Adding and subtracting 1.5 * 2^23 rounds to the nearest integer.
    const ROUND: f32 = 12_582_912.0;
    let x = x.clamp(-87.0, 88.0);
    let k = (x * std::f32::consts::LOG2_E + ROUND) - ROUND;
    let r = (x - k * LN2_HIGH) - k * LN2_LOW;
    let p = C[0] + r * (C[1] + r * (C[2] + r * (C[3] + r * C[4])));
    let scale = f32::from_bits(((k as i32 + 127) << 23) as u32);
    (1.0 + (r + r * r * p)) * scale
}

/// `ln(1 + x)` with a relative error below 3e-7 for `x > -1` where `1 + x` is a normal number.
#[inline]
pub fn ln_1p(x: f32) -> f32 {
    let y = 1.0 + x;
    // Rounding error of 1 + x, which matters for small x.
    let lost = if y < 4.0 { x - (y - 1.0) } else { 0.0 };
    ln(y) + lost / y
}

/// `ln(y)` of positive normal numbers with a relative error below 3e-7.
#[inline]
pub fn ln(y: f32) -> f32 {
    let (exponent, z, bend) = ln_parts(y);
    let small = bend + exponent * -2.121_944_4e-4;
    z + small + exponent * 0.693_359_4
}

/// Splits `y = 2^exponent (1 + z)` with a mantissa in `[√½, √2)`, and evaluates `ln(1 + z) - z`.
#[inline]
pub fn ln_parts(y: f32) -> (f32, f32, f32) {
    const C: [f32; 8] = [
        3.333_333e-1,
        -2.500_082e-1,
        2.000_122_7e-1,
        -1.662_335_7e-1,
        1.420_176e-1,
        -1.316_019e-1,
        1.276_156e-1,
        -7.634_455e-2,
    ];
    let bits = y.to_bits() as i32;
    let exponent = (bits - 0x3f35_04f3) >> 23;
    let z = f32::from_bits((bits - (exponent << 23)) as u32) - 1.0;
    let p = C[0] + z * (C[1] + z * (C[2] + z * (C[3] + z * (C[4] + z * (C[5] + z * (C[6] + z * C[7]))))));
    (exponent as f32, z, z * z * (z * p - 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn exp_is_close(x in -80.0f32..80.0) {
            let exact = f64::from(x).exp();
            prop_assert!((f64::from(exp(x)) - exact).abs() <= 2.5e-7 * exact, "{x}");
        }

        #[test]
        fn ln_is_close(log in -80.0f32..80.0) {
            let y = log.exp();
            let exact = f64::from(y).ln();
            prop_assert!((f64::from(ln(y)) - exact).abs() <= 3e-7 * exact.abs() + 1e-12, "{y}");
        }

        #[test]
        fn ln_1p_is_close(x in prop_oneof![-0.999f32..1e6, -1e-3f32..1e-3, -1e-7f32..1e-7]) {
            let exact = f64::from(x).ln_1p();
            prop_assert!((f64::from(ln_1p(x)) - exact).abs() <= 3e-7 * exact.abs() + 1e-30, "{x}");
        }
    }

    #[test]
    fn ends_saturate() {
        assert!(exp(-1e30) < 1e-37 && exp(1e30).is_finite() && exp(0.0) == 1.0);
        assert_eq!((ln(1.0), ln_1p(0.0)), (0.0, 0.0));
    }
}
