//! Colour space in which a factored flat BTF is a sum: cube roots of tristimulus values, split into lightness and two
//! opponent colours. Distances in it approximate colour differences (ΔE of 1976), and scaling a colour scales all three
//! numbers by one factor.

/// Rows of the sRGB matrix, divided by the white point: white is (1, 1, 1).
const TO_XYZ: [[f32; 3]; 3] = [
    [0.433_953, 0.376_219_4, 0.189_827_6],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.017_756_6, 0.109_467_96, 0.872_775_4],
];

/// Inverse of [`TO_XYZ`].
const TO_RGB: [[f32; 3]; 3] = [
    [3.079_955_6, -1.537_188, -0.542_767_4],
    [-0.921_258_8, 1.876_025_7, 0.045_232_937],
    [0.052_887_354, -0.204_026_68, 1.151_139_4],
];

/// Maximum cube root of a tristimulus value, above the largest value of a view. It keeps decoded colours finite for any
/// file contents.
const MAX_ROOT: f32 = 41.0;

/// Cube root of non-negative numbers with a relative error below 1e-6 from 1e-18 on; 0 below.
#[inline]
pub fn cube_root(x: f32) -> f32 {
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_37a0);
    let step = |y: f32| {
        let cube = y * y * y;
        y * (cube + 2.0 * x) / (2.0 * cube + x)
    };
    if x > 1e-18 { step(step(guess)) } else { 0.0 }
}

/// Opponent colours of an asset as ratios to lightness: minimum and maximum of the first, then of the second, in steps
/// of 1/48. All linear RGB colours are within -2.25 and 1.65.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChromaRange(pub [i8; 4]);

/// Step size of [`ChromaRange`].
const CHROMA_STEP: f32 = 1.0 / 48.0;

impl ChromaRange {
    /// The largest range that a file stores. It contains the ratios of all linear RGB colours.
    pub const ALL: Self = Self([-128, 127, -128, 127]);

    /// Smallest range that contains two ranges of ratios.
    pub fn around(ratios: [[f32; 2]; 2]) -> Self {
        let [[a, b], [c, d]] = ratios.map(|[low, high]| [(low / CHROMA_STEP).floor(), (high / CHROMA_STEP).ceil()]);
        // Conversions saturate.
        Self([a as i8, b as i8, c as i8, d as i8])
    }

    /// Word in a file and a uniform block: one byte each, the first lowest.
    pub fn word(self) -> u32 {
        u32::from_le_bytes(self.0.map(|step| step as u8))
    }

    /// Range that a word holds; inverse of [`Self::word`].
    pub fn from_word(word: u32) -> Self {
        Self(word.to_le_bytes().map(|byte| byte as i8))
    }

    /// Clamps a sum to the range: lightness to at least 0, opponent colours to their limits. Without this, errors of a
    /// few components give dark texels colours that the surface does not have.
    #[inline]
    pub fn bound(self, [lightness, red_green, yellow_blue]: [f32; 3]) -> [f32; 3] {
        let lightness = lightness.max(0.0);
        let [a, b, c, d] = self.0.map(|step| f32::from(step) * CHROMA_STEP * lightness);
        [lightness, red_green.max(a).min(b), yellow_blue.max(c).min(d)]
    }
}

/// Lightness and two opponent colours of linear RGB: `116 y`, `500 (x - y)`, `200 (y - z)` with `x`, `y`, `z` the cube
/// roots of tristimulus values relative to white. L*a*b*'s offset is omitted, so that `to_opponent(s³ c) = s
/// to_opponent(c)`.
#[inline]
pub fn to_opponent([r, g, b]: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = TO_XYZ.map(|[mr, mg, mb]| cube_root((mr * r + mg * g + mb * b).max(0.0)));
    [116.0 * y, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear RGB, non-negative and finite: the inverse of [`to_opponent`].
#[inline]
pub fn from_opponent([lightness, red_green, yellow_blue]: [f32; 3]) -> [f32; 3] {
    let y = lightness * (1.0 / 116.0);
    let x = y + red_green * (1.0 / 500.0);
    let z = y - yellow_blue * (1.0 / 200.0);
    // NaN becomes 0.
    let [x, y, z] = [x, y, z].map(|root| if root > 0.0 { root.min(MAX_ROOT) } else { 0.0 });
    let [x, y, z] = [x * x * x, y * y * y, z * z * z];
    TO_RGB.map(|[mx, my, mz]| (mx * x + my * y + mz * z).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A dark texel with a small error in red is cyan; clamped to the colours of a brown surface it is dark.
    #[test]
    fn colours_stay_within_their_range() {
        let brown = to_opponent([0.2, 0.1, 0.05]);
        let range = ChromaRange::around([1, 2].map(|k: usize| [0.9 * brown[k] / brown[0], 1.1 * brown[k] / brown[0]]));
        assert_eq!(ChromaRange::from_word(range.word()), range);
        assert_eq!(range.bound(brown), brown);
        let off = [5.0, -8.0, 1.0];
        let [cyan, bound] = [from_opponent(off), from_opponent(range.bound(off))];
        assert!(cyan[1] > 10.0 * cyan[0] && bound[0] > bound[1] && bound[1] > bound[2], "{cyan:?} {bound:?}");
        assert_eq!(from_opponent(range.bound([-3.0, 2.0, 1.0])), [0.0; 3]);
        // ALL contains every colour.
        for colour in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]] {
            assert_eq!(ChromaRange::ALL.bound(to_opponent(colour)), to_opponent(colour));
        }
    }

    #[test]
    fn known_colours() {
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 2e-3);
        assert!(near(to_opponent([1.0; 3]), [116.0, 0.0, 0.0]));
        assert!(near(to_opponent([0.125; 3]), [58.0, 0.0, 0.0]));
        assert_eq!(to_opponent([0.0; 3]), [0.0; 3]);
        assert_eq!(from_opponent([0.0; 3]), [0.0; 3]);
        // L*a*b* of pure red is (53.24, 80.09, 67.20); here lightness has no offset of 16.
        let red = to_opponent([1.0, 0.0, 0.0]);
        assert!(
            (red[0] - 69.24).abs() < 0.01 && (red[1] - 80.09).abs() < 0.1 && (red[2] - 67.2).abs() < 0.1,
            "{red:?}"
        );
    }

    /// The largest value of a view round-trips, and any file contents give finite numbers.
    #[test]
    fn colours_are_finite() {
        let largest = from_opponent(to_opponent([65_408.0; 3]));
        assert!(largest.iter().all(|c| (c / 65_408.0 - 1.0).abs() < 1e-5), "{largest:?}");
        for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e30] {
            for at in 0..3 {
                let mut opponent = [50.0, 0.0, 0.0];
                opponent[at] = number;
                let colour = from_opponent(opponent);
                assert!(colour.iter().all(|c| (0.0..3e5).contains(c)), "{opponent:?}: {colour:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn colours_round_trip(colour in prop::array::uniform3(0.01f32..4.0), shade in 0.05f32..1.0) {
            let there = to_opponent(colour);
            let back = from_opponent(there);
            let scaled = to_opponent(colour.map(|c| c * shade * shade * shade));
            for k in 0..3 {
                prop_assert!((back[k] - colour[k]).abs() < 2e-5 * 4.0, "{colour:?} {back:?}");
                prop_assert!((scaled[k] - shade * there[k]).abs() < 1e-3, "{scaled:?} {there:?}");
            }
        }
    }
}
