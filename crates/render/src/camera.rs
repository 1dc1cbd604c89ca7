//! The pinhole camera: rays for the CPU, axes for the shader.

use super::scene::{Camera, Frame};
use super::vector::{cross, subtract};
use brdfc_formats::direction::{Vector, dot, normalize};

/// WGSL that projects corners to pixels.
pub const CORNER_WGSL: &str = include_str!("corner.wgsl");

impl Camera {
    /// Unit vectors to the right, upwards and forwards in the image.
    ///
    /// A point `p` is at `x = right · r / (forward · r) / half_width`, y likewise, with `r = p - eye`; x and y are -1
    /// to 1 over the image, y up.
    pub fn basis(&self) -> (Vector, Vector, Vector) {
        let forward = normalize(subtract(self.target, self.eye));
        let right = normalize(cross(forward, self.up));
        (right, cross(right, forward), forward)
    }

    /// Half the width and half the height of the image plane at distance 1.
    pub fn half_extent(&self, width: usize, height: usize) -> [f64; 2] {
        let half_height = (0.5 * self.field_of_view.to_radians()).tan();
        [half_height * width as f64 / height as f64, half_height]
    }

    /// Returns true if eye, target and up span a view.
    pub fn is_valid(&self) -> bool {
        let forward = subtract(self.target, self.eye);
        let right = cross(forward, self.up);
        let squared = |v: Vector| dot(v, v);
        let scale = squared(forward) * squared(self.up);
        scale > 0.0 && scale.is_finite() && squared(right) > 1e-12 * scale
    }

    /// Direction, not of unit length, through a point of the image in pixels, from the left and from the top.
    pub fn ray(&self, frame: Frame, x: f64, y: f64) -> Vector {
        let (right, up, forward) = self.basis();
        let [half_width, half_height] = self.half_extent(frame.width, frame.height);
        let a = (2.0 * x / frame.width as f64 - 1.0) * half_width;
        let b = (1.0 - 2.0 * y / frame.height as f64) * half_height;
        [0, 1, 2].map(|k| forward[k] + a * right[k] + b * up[k])
    }
}

impl Frame {
    /// Position of a sample of a pixel, in pixels: `(i + ½) / samples` along both axes, sample by sample along rows.
    pub fn sample_position(&self, pixel: usize, sample: usize) -> [f64; 2] {
        let at = |cell: usize, sub: usize| cell as f64 + (sub as f64 + 0.5) / self.samples as f64;
        [at(pixel % self.width, sample % self.samples), at(pixel / self.width, sample / self.samples)]
    }

    /// Samples per pixel.
    pub fn samples_per_pixel(&self) -> usize {
        self.samples * self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_hit_points_that_project_to_their_pixel() {
        let camera =
            Camera { eye: [1.0, 2.0, 5.0], target: [0.0, 0.5, -1.0], up: [0.1, 1.0, 0.0], field_of_view: 40.0 };
        let frame = Frame { width: 300, height: 200, samples: 1 };
        let (right, up, forward) = camera.basis();
        let [half_width, half_height] = camera.half_extent(300, 200);
        for (x, y) in [(0.0, 0.0), (150.0, 100.0), (299.5, 13.25), (20.0, 180.0)] {
            let r = camera.ray(frame, x, y).map(|c| 3.7 * c);
            let w = dot(forward, r);
            let clip = [dot(right, r) / half_width / w, dot(up, r) / half_height / w];
            assert!((clip[0] - (2.0 * x / 300.0 - 1.0)).abs() < 1e-12);
            assert!((clip[1] - (1.0 - 2.0 * y / 200.0)).abs() < 1e-12);
        }
        for (a, b) in [(right, up), (up, forward), (forward, right)] {
            assert!(dot(a, b).abs() < 1e-12 && (dot(a, a) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_camera_that_looks_along_up_or_nowhere_is_not_valid() {
        let camera = Camera { eye: [0.0, 2.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0], field_of_view: 40.0 };
        assert!(camera.is_valid());
        assert!(!Camera { up: [0.0, 1.0, 0.0], ..camera }.is_valid());
        assert!(!Camera { target: camera.eye, ..camera }.is_valid());
        assert!(!Camera { up: [0.0; 3], ..camera }.is_valid());
    }

    #[test]
    fn samples_are_on_a_regular_grid() {
        let frame = Frame { width: 10, height: 4, samples: 2 };
        assert_eq!(frame.sample_position(13, 0), [3.25, 1.25]);
        assert_eq!(frame.sample_position(13, 3), [3.75, 1.75]);
        assert_eq!(frame.sample_position(13, 1), [3.75, 1.25]);
    }
}
