//! Photographs in the domain of a fit, padded to the extent of a pack.

use crate::stack::LightSamples;
use brdfc_formats::pwt::Domain;
use brdfc_readers::pixels::{LINEAR_8, Pixels};
use std::ops::Range;

/// Converts pixels to a domain; 8-bit levels by a table.
pub struct Encoder {
    domain: Domain,
    of_levels: [f32; 256],
}

impl Encoder {
    /// Encoder of a domain.
    pub fn new(domain: Domain) -> Self {
        let mut of_levels = *LINEAR_8;
        domain.encode_each(&mut of_levels);
        Self { domain, of_levels }
    }

    /// Values of some pixels.
    pub fn colours(&self, image: &Pixels, range: Range<usize>) -> Vec<[f32; 3]> {
        if let Pixels::Levels8(levels) = image {
            return levels[range].iter().map(|pixel| pixel.map(|level| self.of_levels[usize::from(level)])).collect();
        }
        let mut values = image.linear(range).into_owned();
        self.domain.encode_each(values.as_flattened_mut());
        values
    }
}

/// Photographs in a domain, padded to an extent by mirroring.
pub struct Padded<'a> {
    /// The photographs.
    pub samples: &'a LightSamples,
    /// Columns and rows, at least those of the photographs.
    pub extent: [usize; 2],
    encoder: Encoder,
}

impl<'a> Padded<'a> {
    /// Photographs in a domain.
    pub fn new(samples: &'a LightSamples, domain: Domain, extent: [usize; 2]) -> Self {
        Self { samples, extent, encoder: Encoder::new(domain) }
    }

    /// Colours of a row of the photograph under a light.
    pub fn row(&self, light: usize, row: usize) -> Vec<[f32; 3]> {
        let [width, height] = self.samples.size;
        let first = mirrored(row, height) * width;
        let mut colours = self.encoder.colours(&self.samples.images[light], first..first + width);
        for column in width..self.extent[0] {
            colours.push(colours[mirrored(column, width)]);
        }
        colours
    }
}

fn mirrored(k: usize, side: usize) -> usize {
    let at = k % (2 * side);
    if at < side { at } else { 2 * side - 1 - at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Levels and linear values of the same pixels are equal in every domain, and so is their mirror image.
    #[test]
    fn levels_and_linear_values_are_equal() {
        let levels = Pixels::Levels8(Arc::new((0..6u8).map(|k| [40 * k, 255 - k, k]).collect()));
        let linear = Pixels::Linear(Arc::new((0..6).map(|at| levels.pixel(at)).collect()));
        for domain in [Domain::Linear, Domain::Display, Domain::CubeRoot, Domain::Logarithm { epsilon: 0.01 }] {
            let rows = |image: &Pixels| {
                let samples = LightSamples::new([3, 2], vec![[0.0, 0.0, 1.0]], vec![image.clone()]);
                let padded = Padded::new(&samples, domain, [5, 3]);
                [0, 1, 2].map(|row| padded.row(0, row))
            };
            let found = rows(&levels);
            assert_eq!(found, rows(&linear));
            assert_eq!(found[1], found[2]);
            assert_ne!(found[0], found[1]);
            assert_eq!((found[0].len(), found[0][3], found[0][4]), (5, found[0][2], found[0][1]));
        }
    }
}
