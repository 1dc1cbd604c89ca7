//! Lights near the surface: their direction and distance differ from pixel to pixel. Layout of their positions:
//! `crates/readers/src/rti_capture.md`.

use crate::pixels::Pixels;

/// Positions of lights near a flat surface, which the images show from above.
#[derive(Debug, Clone, PartialEq)]
pub struct NearLights {
    positions: Vec<[f64; 3]>,
    size: [usize; 2],
    /// Mean squared distance of the lights from the middle.
    mean_square: f64,
}

impl NearLights {
    /// Lights at positions above the surface (z > 0), in widths of the images from their middle: x to the right, y up, z to the viewer.
    /// `size` is columns and rows of the images.
    pub fn new(positions: Vec<[f64; 3]>, size: [usize; 2]) -> Self {
        let mean_square =
            positions.iter().map(|position| square(*position)).sum::<f64>() / positions.len().max(1) as f64;
        Self { positions, size, mean_square }
    }

    /// The lights without some of them. Distances stay relative to those of all lights.
    pub fn without(&self, left_out: &[usize]) -> Self {
        let rest = (0..self.positions.len()).filter(|light| !left_out.contains(light));
        Self { positions: rest.map(|light| self.positions[light]).collect(), ..self.clone() }
    }

    /// Smallest and largest distance from the middle of the images, in widths of them.
    pub fn distances(&self) -> [f64; 2] {
        let distances = self.positions.iter().map(|position| square(*position).sqrt());
        distances.fold([f64::INFINITY, 0.0], |[least, most], distance| [least.min(distance), most.max(distance)])
    }

    /// Unit vectors to all lights from a point of the images: columns and rows from the upper left corner, in pixels.
    pub fn directions(&self, point: [f64; 2]) -> Vec<[f32; 3]> {
        let unit = |position: &[f64; 3]| {
            let vector = self.seen_from(*position, point);
            let length = square(vector).sqrt();
            vector.map(|c| (c / length) as f32)
        };
        self.positions.iter().map(unit).collect()
    }

    /// Factors of the pixels of a row that give them the irradiance of a light at the mean distance of all lights, perpendicular
    /// to it. All lights have the same intensity.
    pub fn factors(&self, light: usize, row: usize) -> impl Iterator<Item = f32> {
        let (position, y) = (self.positions[light], row as f64 + 0.5);
        let squared = move |x: usize| square(self.seen_from(position, [x as f64 + 0.5, y]));
        (0..self.size[0]).map(move |x| (squared(x) / self.mean_square) as f32)
    }

    /// Multiplies the image under a light by its [`Self::factors`].
    pub fn at_mean_distance(&self, light: usize, mut image: Pixels) -> Pixels {
        let width = self.size[0];
        for (row, pixels) in image.to_mut().chunks_exact_mut(width).enumerate() {
            pixels
                .iter_mut()
                .zip(self.factors(light, row))
                .for_each(|(pixel, factor)| *pixel = pixel.map(|c| c * factor));
        }
        image
    }

    /// Vector from a point of the images to a position.
    fn seen_from(&self, [x, y, z]: [f64; 3], [column, row]: [f64; 2]) -> [f64; 3] {
        let [width, height] = self.size.map(|side| side as f64);
        [x - (column / width - 0.5), y - (0.5 * height - row) / width, z]
    }
}

fn square(vector: [f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers in the middle, at a corner and straight below a light.
    #[test]
    fn directions_and_distances() {
        let lights = NearLights::new(vec![[0.0, 0.0, 1.0], [0.5, 0.25, 1.0]], [8, 4]);
        assert_eq!(lights.directions([4.0, 2.0])[0], [0.0, 0.0, 1.0]);
        let second = lights.directions([4.0, 2.0])[1];
        let length = 1.3125f32.sqrt();
        assert!((second[0] - 0.5 / length).abs() < 1e-6 && (second[1] - 0.25 / length).abs() < 1e-6, "{second:?}");
        // The upper right corner is at x = 1/2, y = 1/4.
        assert_eq!(lights.directions([8.0, 0.0])[1], [0.0, 0.0, 1.0]);
        assert_eq!(lights.distances(), [1.0, 1.3125f64.sqrt()]);
        // The mean squared distance is 1.15625; pixel centres are half a pixel from the corner.
        let factors: Vec<f32> = lights.factors(1, 0).collect();
        let expected = |x: f32| ((0.5 - x) * (0.5 - x) + 0.0625f32.powi(2) + 1.0) / 1.15625;
        assert!((factors[7] - expected(0.4375)).abs() < 1e-6, "{factors:?}");
        assert!((factors[0] - expected(-0.4375)).abs() < 1e-6, "{factors:?}");
        let image = lights.at_mean_distance(1, vec![[1.0, 2.0, 0.0]; 32].into());
        assert_eq!(image.pixel(7), [factors[7], 2.0 * factors[7], 0.0]);
        assert_eq!(lights.without(&[0]).factors(0, 0).collect::<Vec<_>>(), factors);
    }
}
