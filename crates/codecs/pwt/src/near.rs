//! Photographs under near lights, converted to photographs under distant ones.

use crate::fit::multiply_add;
use crate::kriging::{Shortlist, rows};
use crate::stack::{LightSamples, spread};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::Domain;
use brdfc_readers::near_lights::NearLights;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

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

/// Checks the number of near lights.
///
/// # Errors
/// Returns an error for more than [`MAX_LIGHTS`].
pub fn check_count(lights: usize) -> Result<(), FormatError> {
    if lights <= MAX_LIGHTS {
        return Ok(());
    }
    Err(FormatError::whole("near lights", lights.to_string(), format!("at most {MAX_LIGHTS}")))
}

impl LightSamples {
    /// Converts images under near lights to the mean distance of the lights ([`NearLights::factor`]), and to their directions from
    /// the middle of the images. Images under distant lights stay as they are.
    ///
    /// Each pixel sees other directions. An interpolation between them, chosen by lights that are left out, predicts the change
    /// from the direction of a pixel to that of the middle; the change is added to the image, which keeps its detail.
    ///
    /// # Errors
    /// Returns an error for more than [`MAX_LIGHTS`] near lights.
    pub fn distant(&self) -> Result<Cow<'_, Self>, FormatError> {
        self.near.as_ref().map_or(Ok(Cow::Borrowed(self)), |near| converted(self, near).map(Cow::Owned))
    }

    /// The images without some lights, and only those, under distant lights. The former do not depend on the latter.
    ///
    /// # Errors
    /// Returns an error for more than [`MAX_LIGHTS`] near lights.
    pub fn split(&self, left_out: &[usize]) -> Result<[Self; 2], FormatError> {
        let rest: Vec<usize> = (0..self.lights.len()).filter(|light| !left_out.contains(light)).collect();
        Ok([self.without(left_out).distant()?.into_owned(), self.distant()?.without(&rest)])
    }
}

fn converted(samples: &LightSamples, near: &NearLights) -> Result<LightSamples, FormatError> {
    let count = samples.lights.len();
    check_count(count)?;
    let changes = Changes::new(samples, near);
    let [width, height] = samples.size;
    let mut images: Vec<Vec<[f32; 3]>> = (0..count).map(|_| Vec::with_capacity(width * height)).collect();
    for first in (0..height).step_by(ROWS) {
        let rows: Vec<usize> = (first..(first + ROWS).min(height)).collect();
        let rows: Vec<Vec<f32>> = rows.into_par_iter().map(|row| changes.converted(row)).collect();
        for row in rows {
            let of_lights = row.as_chunks::<3>().0.chunks_exact(width);
            images.iter_mut().zip(of_lights).for_each(|(image, row)| image.extend_from_slice(row));
        }
    }
    Ok(LightSamples {
        images: images.into_iter().map(Into::into).collect(),
        lights: samples.lights.clone(),
        near: None,
        views: samples.views.clone(),
        defined: samples.defined.clone(),
        ..*samples
    })
}

/// Changes of the values of all lights, as linear functions of these values.
struct Changes<'a> {
    samples: &'a LightSamples,
    near: &'a NearLights,
    /// For each corner of the cells, row by row, a matrix, row by row.
    corners: Vec<Vec<f32>>,
}

impl<'a> Changes<'a> {
    fn new(samples: &'a LightSamples, near: &'a NearLights) -> Self {
        let [width, height] = samples.size;
        let values = middle(samples, near);
        let interpolation = Shortlist::new(&samples.lights, &values).combined(&values).unwrap_or_default();
        let corner = |at: usize| {
            let [column, row] = [at % (CELLS + 1), at / (CELLS + 1)].map(|k| k as f64 / CELLS as f64);
            let seen = near.directions([column * width as f64, row * height as f64]);
            let [target, own] = [&samples.lights, &seen].map(|at| interpolation.predictions(&seen, at));
            (target - own).transpose().iter().map(|number| *number as f32).collect()
        };
        let corners = (0..(CELLS + 1) * (CELLS + 1)).into_par_iter().map(corner).collect();
        Self { samples, near, corners }
    }

    /// Linear values of a row under all distant lights: light by light, pixel by pixel.
    fn converted(&self, row: usize) -> Vec<f32> {
        let ([width, height], count) = (self.samples.size, self.samples.lights.len());
        let of_row = |light| at_mean_distance(self.samples, self.near, light, row, 0..width);
        let values: Vec<Vec<f32>> = (0..count).map(of_row).collect();
        let y = CELLS as f64 * (row as f64 + 0.5) / height as f64;
        // Of the corners at the left of each cell and at the right of the last.
        let matrices: Vec<Vec<f32>> = (0..=CELLS).map(|column| self.between(column, y)).collect();
        let mut changed = values.clone();
        for cell in 0..CELLS {
            // Pixels whose centres are in the cell.
            let columns = [cell, cell + 1].map(|k| (2 * k * width).saturating_sub(CELLS).div_ceil(2 * CELLS));
            let pixels = columns[1] - columns[0];
            if pixels == 0 {
                continue;
            }
            let part: Vec<f32> = values.iter().flat_map(|row| &row[3 * columns[0]..3 * columns[1]]).copied().collect();
            let sides = [cell, cell + 1].map(|side| {
                let mut product = vec![0.0; part.len()];
                multiply_add(count, count, 3 * pixels, &matrices[side], &part, &mut product);
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
fn middle(samples: &LightSamples, near: &NearLights) -> DMatrix<f64> {
    let [width, height] = samples.size;
    let [columns, lines] = samples.size.map(|side| side.div_ceil(2));
    let texel = |k: usize| (height / 4 + k / columns, width / 4 + k % columns);
    let texels: Vec<(usize, usize)> = spread(columns * lines, TEXELS).into_iter().map(texel).collect();
    let of_texel = |light, (row, x)| at_mean_distance(samples, near, light, row, x..x + 1);
    let of_light = |light| texels.iter().flat_map(|texel| of_texel(light, *texel)).collect();
    let values: Vec<Vec<f32>> = (0..samples.lights.len()).map(of_light).collect();
    rows(&values)
}

/// Encoded values of some pixels of a row at the mean distance of the lights.
fn at_mean_distance(
    samples: &LightSamples,
    near: &NearLights,
    light: usize,
    row: usize,
    columns: Range<usize>,
) -> Vec<f32> {
    let first = row * samples.size[0];
    let mut values = samples.images[light].linear(first + columns.start..first + columns.end).into_owned();
    for (pixel, x) in values.iter_mut().zip(columns) {
        let factor = near.factor(light, [x as f64 + 0.5, row as f64 + 0.5]);
        *pixel = pixel.map(|c| c * factor);
    }
    DOMAIN.encode_each(values.as_flattened_mut());
    values.into_flattened()
}
