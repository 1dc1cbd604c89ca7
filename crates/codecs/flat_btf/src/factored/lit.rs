//! Which lights reach a texel, before shadows are solved for.

/// What is brighter than this share of a texel's brightest mean over the views is lit at first.
const LIT_SHARE: f32 = 0.05;

/// 1 where a sum of lightness is not far below the largest, 0 else.
pub(super) fn threshold(sums: &mut [f32]) {
    let least = LIT_SHARE * sums.iter().copied().fold(0.0, f32::max);
    sums.iter_mut().for_each(|sum| *sum = f32::from(u8::from(*sum > least)));
}
