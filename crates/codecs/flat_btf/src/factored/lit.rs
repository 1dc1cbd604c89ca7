//! Initial estimate of the lights that reach a texel, before shadows are solved.

/// Share of a texel's brightest mean over the views above which a light initially counts as reaching it.
const LIT_SHARE: f32 = 0.05;

/// Sets sums of lightness to 1 if they exceed this share of the largest, else to 0.
pub(super) fn threshold(sums: &mut [f32]) {
    let least = LIT_SHARE * sums.iter().copied().fold(0.0, f32::max);
    sums.iter_mut().for_each(|sum| *sum = f32::from(u8::from(*sum > least)));
}
