//! Faces of a cube map, in the order and orientation of Vulkan, WebGPU and OpenGL, and filtered look-ups.

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

/// Texels of a cube map. Look-ups filter across the edges of the cube, as GPUs do: faces have a border of one texel from their
/// neighbours.
#[derive(Debug, Clone)]
pub struct FilteredCube {
    /// Texels along each side of a face, without the border.
    side: usize,
    /// Six faces of `(side + 2)²` texels, row by row.
    texels: Vec<[f32; 3]>,
}

impl FilteredCube {
    /// Cube map of `6 side²` texels: face by face, row by row.
    ///
    /// # Panics
    /// If there are fewer texels.
    pub fn new(side: usize, inner: &[[f32; 3]]) -> Self {
        let wide = side + 2;
        let texel = |face: usize, column: usize, row: usize| inner[(face * side + row) * side + column];
        let nearest = |point: FacePoint| {
            let [column, row] = [point.s, point.t].map(|c| ((0.5 * (c + 1.0) * side as f64) as usize).min(side - 1));
            texel(point.face, column, row)
        };
        let is_inside = |at: usize| (1..=side).contains(&at);
        let mut texels = Vec::with_capacity(6 * wide * wide);
        for (face, row, column) in (0..6).flat_map(|f| (0..wide).flat_map(move |r| (0..wide).map(move |c| (f, r, c)))) {
            let across = |column: usize, row: usize| {
                nearest(FacePoint::of(
                    FacePoint::on_grid(face, side, [column as f64 - 0.5, row as f64 - 0.5]).direction(),
                ))
            };
            texels.push(match (is_inside(column), is_inside(row)) {
                (true, true) => texel(face, column - 1, row - 1),
                (false, false) => {
                    // Three faces meet at a corner, and no fourth texel exists: the mean of the three.
                    let [inner_column, inner_row] = [column, row].map(|at| at.clamp(1, side));
                    let three = [
                        across(inner_column, row),
                        across(column, inner_row),
                        texel(face, inner_column - 1, inner_row - 1),
                    ];
                    [0, 1, 2].map(|k| three.iter().map(|texel| texel[k]).sum::<f32>() / 3.0)
                }
                _ => across(column, row),
            });
        }
        Self { side, texels }
    }

    /// Texels along each side of a face.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Bilinear value at a point.
    pub fn filtered(&self, point: FacePoint) -> [f32; 3] {
        let [(column, right), (row, down)] = [point.s, point.t].map(|c| {
            let position = 0.5 * (c + 1.0) * self.side as f64 + 0.5;
            let lower = (position as usize).min(self.side);
            (lower, (position - lower as f64) as f32)
        });
        let wide = self.side + 2;
        let first = (point.face * wide + row) * wide + column;
        let [a, b, c, d] = [first, first + 1, first + wide, first + wide + 1].map(|at| self.texels[at]);
        [0, 1, 2].map(|k| {
            let above = a[k] + right * (b[k] - a[k]);
            let below = c[k] + right * (d[k] - c[k]);
            above + down * (below - above)
        })
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
