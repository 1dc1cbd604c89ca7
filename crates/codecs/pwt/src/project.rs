//! Coefficients of learned terms: photographs times a matrix.

use crate::encoded::Padded;
use crate::fit::multiply_strips;
use crate::learned::Learned;

/// Approximate number of texels of a strip of rows.
const STRIP: usize = 1 << 11;

/// Coefficients of each component for all texels of padded photographs.
pub fn coefficients(learned: &Learned, photographs: &Padded<'_>) -> Vec<Vec<f32>> {
    let [width, height] = photographs.extent;
    let lights = photographs.samples.lights.len();
    let mut planes: Vec<Vec<f32>> = learned.offsets.iter().map(|offset| vec![*offset; width * height]).collect();
    let strip = width * STRIP.div_ceil(width);
    multiply_strips(&mut planes, strip, &learned.factors.concat(), 3 * lights, |texels, values| {
        for light in 0..lights {
            let rows = (texels.start / width..texels.end / width).map(|row| photographs.row(light, row));
            let colours = rows.collect::<Vec<_>>().concat();
            (0..3).for_each(|channel| values.extend(colours.iter().map(|colour| colour[channel])));
        }
    });
    planes
}
