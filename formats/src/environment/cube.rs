//! Faces of a cube map, in the order and orientation of Vulkan, WebGPU and OpenGL.

/// Coordinates on a face of the cube `[-1, 1]³`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    /// Face: +X, -X, +Y, -Y, +Z, -Z.
    pub face: usize,
    /// Position along the columns, -1 to 1.
    pub s: f64,
    /// Position along the rows, -1 to 1.
    pub t: f64,
}

impl FacePoint {
    /// Point of a direction of any length but 0.
    pub fn of([x, y, z]: [f64; 3]) -> Self {
        let [ax, ay, az] = [x, y, z].map(f64::abs);
        let (face, s, t, major) = if ax >= ay && ax >= az {
            if x >= 0.0 { (0, -z, -y, ax) } else { (1, z, -y, ax) }
        } else if ay >= az {
            if y >= 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
        } else if z >= 0.0 {
            (4, x, -y, az)
        } else {
            (5, -x, -y, az)
        };
        Self { face, s: s / major, t: t / major }
    }

    /// Point of a position on the texel grid of a face with `side` texels per side. Texel `(column, row)` has its
    /// centre at `(column + ½, row + ½)`. Positions outside lie on the plane of the face.
    pub fn on_grid(face: usize, side: usize, [column, row]: [f64; 2]) -> Self {
        let [s, t] = [column, row].map(|position| 2.0 * position / side as f64 - 1.0);
        Self { face, s, t }
    }

    /// Direction of the point, of length 1 or more.
    pub fn direction(self) -> [f64; 3] {
        let Self { face, s, t } = self;
        match face {
            0 => [1.0, -t, -s],
            1 => [-1.0, -t, s],
            2 => [s, 1.0, t],
            3 => [s, -1.0, -t],
            4 => [s, -t, 1.0],
            _ => [-s, -t, -1.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_and_points_are_inverse() {
        for face in 0..6 {
            for [column, row] in [[0.5, 0.5], [3.5, 1.5], [2.0, 3.5]] {
                let point = FacePoint::on_grid(face, 4, [column, row]);
                assert_eq!(FacePoint::of(point.direction().map(|c| 0.3 * c)), point);
            }
        }
        let axes =
            [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        for (face, axis) in axes.into_iter().enumerate() {
            assert_eq!(FacePoint::of(axis), FacePoint { face, s: 0.0, t: 0.0 });
        }
    }
}
