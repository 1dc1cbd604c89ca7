//! Values of a map that may be too low because the transformed image has too few pixels.

use super::{BandwidthKind, BandwidthMap, CELLS};
use std::f64::consts::{FRAC_PI_2, PI};

/// Cycles per pixel above which the transform has no finer level to detect the limit of detail.
const QUARTER: f64 = 0.25;

impl BandwidthMap {
    /// Fraction of the values of a BRDF's map, 0 to 1, of at least a quarter of a cycle per pixel of the lobe images.
    /// Lobes may vary faster there than their images resolve. `None` for other kinds of maps, whose images are the
    /// original data.
    pub fn limited(&self) -> Option<f64> {
        if self.header().kind != BandwidthKind::Brdf {
            return None;
        }
        let (values, pixels) = (self.values(), f64::from(self.header().transformed[0]));
        let rows = CELLS as usize;
        let at_limit = |(row, values): (usize, &[f32])| {
            let theta = ((row % rows) as f64 + 0.5) * FRAC_PI_2 / rows as f64;
            let limit = QUARTER * pixels * theta / (PI * theta.sin());
            values.iter().filter(|value| f64::from(**value) >= limit).count()
        };
        let count: usize = values.chunks_exact(self.size()[0] as usize).enumerate().map(at_limit).sum();
        Some(count as f64 / values.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bandwidth::BandwidthHeader;

    fn map(kind: BandwidthKind, size: u32, pixels: u32, values: &[f32]) -> BandwidthMap {
        let header = BandwidthHeader { kind, epsilon: 0.01, transformed: [pixels; 2] };
        BandwidthMap::new(header, [size; 2], values).unwrap()
    }

    #[test]
    fn a_quarter_of_a_cycle_per_pixel_is_the_limit() {
        // 64 pixels: 16 cycles per image, along 1/π radians at the normal and 1/2 at the horizon.
        for (row, limit) in [(0, 5.095), (15, 7.7593), (16, 5.095), (255, 7.7593)] {
            for (value, expected) in [(0.998 * limit, 0.0), (1.002 * limit, 1.0), (2.0 * limit, 1.0)] {
                let mut values = vec![0.0; 256 * 256];
                values[256 * row + 3] = value;
                let found = map(BandwidthKind::Brdf, 256, 64, &values).limited();
                assert_eq!(found, Some(expected / 65536.0), "{row} {value}");
                assert_eq!(map(BandwidthKind::Brdf, 256, 256, &values).limited(), Some(0.0));
            }
        }
        assert_eq!(map(BandwidthKind::Environment, 1, 64, &[1e4]).limited(), None);
    }
}
