//! CIE L*a*b* of linear RGB, fast enough for whole BTFs.

/// XYZ of linear RGB with the primaries of sRGB, relative to the white point (D65): one row per component.
pub const XYZ: [[f64; 3]; 3] = [
    [0.433_953, 0.376_219_4, 0.189_827_6],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.017_756_6, 0.109_467_96, 0.872_775_4],
];

/// Cube root of numbers from 0 to 1, within 1e-6 relative: an initial guess from the bits, then two steps of Halley's
/// method.
#[inline]
fn cube_root(x: f32) -> f32 {
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    let step = |y: f32| {
        let cube = y * y * y;
        y * (cube + 2.0 * x) / (2.0 * cube + x)
    };
    step(step(guess))
}

/// L*a*b* (D65) of linear RGB with the primaries of sRGB. White is (1, 1, 1); components are clipped to 0 to 1 first,
/// as in a rendering.
#[inline]
pub fn lab(colour: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = colour.map(|c| c.clamp(0.0, 1.0));
    let [x, y, z] = XYZ.map(|row| row[0] as f32 * r + row[1] as f32 * g + row[2] as f32 * b);
    let f = |t: f32| if t > 0.008_856_452 { cube_root(t) } else { t * 7.787_037 + 16.0 / 116.0 };
    let (fx, fy, fz) = (f(x), f(y), f(z));
    [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]
}

/// [`lab`] of several colours at once, by channel, with the same bits, but in wide instructions.
pub fn lab_each<const N: usize>(colours: &[[f32; N]; 3]) -> [[f32; N]; 3] {
    let mut all = [[0.0; N]; 3];
    for k in 0..N {
        let [l, a, b] = lab([colours[0][k], colours[1][k], colours[2][k]]);
        (all[0][k], all[1][k], all[2][k]) = (l, a, b);
    }
    all
}

/// Squared distance of two colours in L*a*b* (the square of ΔE of 1976).
#[inline]
pub fn distance_squared(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use palette::white_point::D65;
    use palette::{FromColor, Lab, LinSrgb};
    use proptest::array::{uniform3, uniform24};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_a_library(r in 0.0f32..1.0, g in 0.0f32..1.0, b in 0.0f32..1.0, dark in 0u32..4) {
            let scale = 0.1f32.powi(dark as i32);
            let colour = [r, g, b].map(|c| c * scale);
            let ours = lab(colour);
            let known = Lab::<D65, f64>::from_color(LinSrgb::from(colour.map(f64::from)));
            for (a, b) in ours.into_iter().zip([known.l, known.a, known.b]) {
                prop_assert!((f64::from(a) - b).abs() < 0.01, "{colour:?} {ours:?} {known:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn several_at_once_are_the_same(colours in uniform3(uniform24(-0.1f32..1.2))) {
            let all = lab_each(&colours);
            for k in 0..24 {
                let one = lab([0, 1, 2].map(|c| colours[c][k]));
                prop_assert_eq!([0, 1, 2].map(|c| all[c][k].to_bits()), one.map(f32::to_bits));
            }
        }
    }

    #[test]
    fn white_black_and_beyond() {
        let white = lab([1.0; 3]);
        assert!((white[0] - 100.0).abs() < 1e-3 && white[1].abs() < 0.01 && white[2].abs() < 0.01, "{white:?}");
        assert_eq!(lab([7.0; 3]), white);
        assert!(lab([0.0; 3])[0].abs() < 1e-4);
    }
}
