//! Photographs under near lights, converted to photographs under distant ones.

use crate::fit::multiply_add;
use crate::kriging::{Shortlist, rows};
use crate::stack::{LightSamples, spread};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::Domain;
use brdfc_readers::near_lights::NearLights;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Maximum number of near lights.
pub const MAX_LIGHTS: usize = 400;
/// Cells along each side in whose corners the interpolation is computed; between them its weights are linear.
const CELLS: usize = 8;
/// Number of texels by which the interpolation is chosen.
const TEXELS: usize = 512;
/// Rows that are converted at a time.
const ROWS: usize = 64;
/// Scale of the values that are interpolated.
const DOMAIN: Domain = Domain::Display;

/// Converts photographs whose lights are near to the directions of the lights from the middle of the images, which are those of
/// `samples`. Its values are those at the mean distance of the lights ([`NearLights::at_mean_distance`]).
///
/// Each pixel sees other directions. An interpolation between them, chosen by lights that are left out, predicts the change
/// from the direction of a pixel to that of the middle; the change is added to the photograph, which keeps its detail.
///
/// # Errors
/// Returns an error for more than [`MAX_LIGHTS`] lights.
pub fn distant(samples: &LightSamples, near: &NearLights) -> Result<LightSamples, FormatError> {
    let count = samples.lights.len();
    if count > MAX_LIGHTS {
        return Err(FormatError::whole("near lights", count.to_string(), format!("at most {MAX_LIGHTS}")));
    }
    let changes = Changes::new(samples, near);
    let [width, height] = samples.size;
    let mut images: Vec<Vec<[f32; 3]>> = (0..count).map(|_| Vec::with_capacity(width * height)).collect();
    for first in (0..height).step_by(ROWS) {
        let rows: Vec<usize> = (first..(first + ROWS).min(height)).collect();
        let rows: Vec<Vec<f32>> = rows.into_par_iter().map(|row| changes.converted(samples, row)).collect();
        for row in rows {
            let of_lights = row.as_chunks::<3>().0.chunks_exact(width);
            images.iter_mut().zip(of_lights).for_each(|(image, row)| image.extend_from_slice(row));
        }
    }
    Ok(LightSamples {
        images: images.into_iter().map(Into::into).collect(),
        lights: samples.lights.clone(),
        defined: samples.defined.clone(),
        ..*samples
    })
}

/// Changes of the values of all lights, as linear functions of these values.
struct Changes {
    /// Number of lights.
    count: usize,
    /// For each corner of the cells, row by row, a matrix, row by row.
    corners: Vec<Vec<f32>>,
}

impl Changes {
    fn new(samples: &LightSamples, near: &NearLights) -> Self {
        let [width, height] = samples.size;
        let values = middle(samples);
        let interpolation = Shortlist::new(&samples.lights, &values).combined(&values).unwrap_or_default();
        let corner = |at: usize| {
            let [column, row] = [at % (CELLS + 1), at / (CELLS + 1)].map(|k| k as f64 / CELLS as f64);
            let seen = near.directions([column * width as f64, row * height as f64]);
            let [target, own] = [&samples.lights, &seen].map(|at| interpolation.predictions(&seen, at));
            (target - own).transpose().iter().map(|number| *number as f32).collect()
        };
        let corners = (0..(CELLS + 1) * (CELLS + 1)).into_par_iter().map(corner).collect();
        Self { count: samples.lights.len(), corners }
    }

    /// Linear values of a row under all distant lights: light by light, pixel by pixel.
    fn converted(&self, samples: &LightSamples, row: usize) -> Vec<f32> {
        let [width, height] = samples.size;
        let of_row = |image| encoded(samples, image, row * width..(row + 1) * width);
        let values: Vec<Vec<f32>> = (0..self.count).map(of_row).collect();
        let y = CELLS as f64 * (row as f64 + 0.5) / height as f64;
        // Of the corners at the left of each cell and at the right of the last.
        let matrices: Vec<Vec<f32>> = (0..=CELLS).map(|column| self.between(column, y)).collect();
        let mut changed = values.clone();
        for cell in 0..CELLS {
            let columns = [cell, cell + 1].map(|k| (k * width).div_ceil(CELLS));
            let pixels = columns[1] - columns[0];
            if pixels == 0 {
                continue;
            }
            let part: Vec<f32> = values.iter().flat_map(|row| &row[3 * columns[0]..3 * columns[1]]).copied().collect();
            let sides = [cell, cell + 1].map(|side| {
                let mut product = vec![0.0; part.len()];
                multiply_add(self.count, self.count, 3 * pixels, &matrices[side], &part, &mut product);
                product
            });
            for (light, changed) in changed.iter_mut().enumerate() {
                for k in 0..3 * pixels {
                    let x = CELLS as f64 * ((columns[0] + k / 3) as f64 + 0.5) / width as f64 - cell as f64;
                    let [left, right] = sides.each_ref().map(|side| side[light * 3 * pixels + k]);
                    changed[3 * columns[0] + k] += left + (right - left) * x as f32;
                }
            }
        }
        let mut changed = changed.concat();
        DOMAIN.decode_each(&mut changed);
        changed
    }

    /// Matrix on a vertical line between cells. `y` counts cells from the top.
    fn between(&self, column: usize, y: f64) -> Vec<f32> {
        let above = (y as usize).min(CELLS - 1);
        let [a, b] = [above, above + 1].map(|row| &self.corners[row * (CELLS + 1) + column]);
        let share = (y - above as f64) as f32;
        a.iter().zip(b).map(|(a, b)| a + (b - a) * share).collect()
    }
}

/// Values of some texels around the middle, where directions are nearly those of the lights: a row for each light.
fn middle(samples: &LightSamples) -> DMatrix<f64> {
    let [width, height] = samples.size;
    let [columns, lines] = samples.size.map(|side| side.div_ceil(2));
    let texel = |k: usize| (height / 4 + k / columns) * width + width / 4 + k % columns;
    let texels: Vec<usize> = spread(columns * lines, TEXELS).into_iter().map(texel).collect();
    let of_light = |light| texels.iter().flat_map(|texel| encoded(samples, light, *texel..texel + 1)).collect();
    let values: Vec<Vec<f32>> = (0..samples.lights.len()).map(of_light).collect();
    rows(&values)
}

/// Encoded values of pixels.
fn encoded(samples: &LightSamples, light: usize, pixels: std::ops::Range<usize>) -> Vec<f32> {
    let mut values = samples.images[light].linear(pixels).as_flattened().to_vec();
    DOMAIN.encode_each(&mut values);
    values
}
