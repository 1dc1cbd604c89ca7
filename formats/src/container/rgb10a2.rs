//! Colours in 32 bits: three components of 10 bits, as in `VK_FORMAT_A2B10G10R10_UNORM_PACK32` and `rgb10a2unorm`. Red
//! is in bits 0 to 9, green in 10 to 19, blue in 20 to 29; both alpha bits are 1.

/// Quantisation steps from 0 to 1.
pub const STEPS: f32 = 1023.0;

/// Nearest representable colour. Components are clamped to `0..=1`; NaN becomes 0.
pub fn encode(colour: [f32; 3]) -> u32 {
    let [r, g, b] = colour.map(|c| (c.clamp(0.0, 1.0) * STEPS).round() as u32);
    r | g << 10 | b << 20 | 3 << 30
}

/// Colour of a texel.
pub fn decode(texel: u32) -> [f32; 3] {
    [texel, texel >> 10, texel >> 20].map(|bits| (bits & 1023) as f32 * (1.0 / STEPS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_texels() {
        assert_eq!(encode([0.0; 3]), 0xc000_0000);
        assert_eq!(encode([1.0, 0.0, 0.0]), 0xc000_03ff);
        assert_eq!(encode([0.0, 1.0, 2.0]), 0xffff_fc00);
        assert_eq!(encode([f32::NAN, -1.0, 0.5]), 0xc000_0000 | 512 << 20);
    }

    #[test]
    fn every_step_round_trips() {
        for step in 0..1024 {
            let texel = step | (1023 - step) << 10 | (step / 2) << 20 | 3 << 30;
            assert_eq!(encode(decode(texel)), texel);
        }
        assert_eq!(decode(u32::MAX), [1.0; 3]);
    }
}
