//! Lights near the surface: their direction and distance differ from pixel to pixel. Layout of their positions:
//! `crates/readers/src/rti_capture.md`.

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

    /// The lights in groups, at their mean positions. Distances stay relative to those of all lights.
    pub fn of_groups(&self, groups: &[Vec<usize>]) -> Self {
        let mean = |group: &Vec<usize>| {
            let sum = |axis: usize| group.iter().map(|light| self.positions[*light][axis]).sum::<f64>();
            [0, 1, 2].map(|axis| sum(axis) / group.len() as f64)
        };
        Self { positions: groups.iter().map(mean).collect(), ..self.clone() }
    }

    /// Distance of a light from the middle of the images, in widths of them.
    ///
    /// # Panics
    /// Panics if the light does not exist.
    pub fn distance(&self, light: usize) -> f64 {
        // Squares of wrong positions may overflow.
        let [x, y, z] = self.positions[light];
        x.hypot(y).hypot(z)
    }

    /// Distances from the middle of the images, in widths of them.
    pub fn distances(&self) -> impl Iterator<Item = f64> {
        (0..self.positions.len()).map(|light| self.distance(light))
    }

    /// Smallest and largest distance from the middle of the images, in widths of them.
    pub fn range(&self) -> [f64; 2] {
        self.distances().fold([f64::INFINITY, 0.0], |[least, most], distance| [least.min(distance), most.max(distance)])
    }

    /// Distance of each light from the nearest point of the images, in widths of them.
    pub fn clearances(&self) -> impl Iterator<Item = f64> {
        let [width, height] = self.size.map(|side| side as f64);
        let beyond = move |c: f64, side: f64| (c.abs() - 0.5 * side / width).max(0.0);
        self.positions.iter().map(move |[x, y, z]| square([beyond(*x, width), beyond(*y, height), *z]).sqrt())
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

    /// Factor that gives a point of the images, in pixels, the irradiance of a light at the mean distance of all lights,
    /// perpendicular to it. All lights have the same intensity.
    pub fn factor(&self, light: usize, point: [f64; 2]) -> f32 {
        (square(self.seen_from(self.positions[light], point)) / self.mean_square) as f32
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
        assert_eq!(lights.range(), [1.0, 1.3125f64.sqrt()]);
        let wide = NearLights::new(vec![[0.2, -0.1, 0.3], [0.9, 0.55, 0.0]], [8, 4]);
        let clearances: Vec<f64> = wide.clearances().collect();
        assert!((clearances[0] - 0.3).abs() < 1e-12 && (clearances[1] - 0.5).abs() < 1e-12, "{clearances:?}");
        // The mean squared distance is 1.15625; pixel centres are half a pixel from the corner.
        let factors = [0.5, 7.5].map(|x| lights.factor(1, [x, 0.5]));
        let expected = |x: f32| ((0.5 - x) * (0.5 - x) + 0.0625f32.powi(2) + 1.0) / 1.15625;
        assert!((factors[1] - expected(0.4375)).abs() < 1e-6, "{factors:?}");
        assert!((factors[0] - expected(-0.4375)).abs() < 1e-6, "{factors:?}");
        assert_eq!(lights.without(&[0]).factor(0, [7.5, 0.5]), factors[1]);
    }
}
