//! Interpolation of a pixel from the coarser level (section 3.2, figure 9 of Bagher et al. 2012).

/// The surface at the point that a pixel of a level stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UpsamplingGuide {
    /// Position of the point in the finest buffer, in pixels.
    pub at: [f32; 2],
    /// Position in world space.
    pub position: [f32; 3],
    /// Unit shading normal.
    pub normal: [f32; 3],
    /// Cosine of the angle between normal and view.
    pub cosine: f32,
    /// Direction of the projected normal in the image, a unit vector; arbitrary if the normal points to the viewer.
    pub across: [f32; 2],
    /// Index of the part.
    pub part: u32,
}

/// Maximum distance of a parent from the pixel's tangent plane, in units of the distance between both.
const DEPTH: f32 = 0.25;
/// Minimum sum of weights for interpolation.
pub const MIN_WEIGHT: f32 = 1e-3;

/// `w = α g_z(z - z_i) g_a(p - p_i)`; 0 for another part. `spacing` is the distance of parents, in pixels of the finest
/// buffer.
///
/// `α` is the bilinear weight of the parent's point: 1 if the pixel stands for the same point, 0 at a distance of
/// `spacing`. `g_z` compares along the normal, not along the view: a plane seen obliquely is one surface. `g_a` is
/// `exp(-vᵀ M v)`, `v` in pixels of the coarser level, `M = R_φᵀ diag(1, cos θ) R_φ`: wider at right angles to the
/// projected normal, where the surface turns less from pixel to pixel.
pub fn weight(pixel: &UpsamplingGuide, parent: &UpsamplingGuide, spacing: f32) -> f32 {
    if pixel.part != parent.part {
        return 0.0;
    }
    let step = [0, 1, 2].map(|k| parent.position[k] - pixel.position[k]);
    let length_squared = dot(step, step);
    let off = dot(step, pixel.normal);
    let depth = if length_squared > 0.0 { off * off / (DEPTH * DEPTH * length_squared) } else { 0.0 };
    let v = [0, 1].map(|k| (parent.at[k] - pixel.at[k]) / spacing);
    let alpha = (1.0 - v[0].abs()).max(0.0) * (1.0 - v[1].abs()).max(0.0);
    let along = v[0] * pixel.across[0] + v[1] * pixel.across[1];
    let sideways = v[1] * pixel.across[0] - v[0] * pixel.across[1];
    alpha * (-(depth + along * along + pixel.cosine * sideways * sideways)).exp()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Indices of the up to four pixels of the coarser level around a pixel of the finer one. Skips positions outside the
/// level.
pub fn parents([x, y]: [usize; 2], [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let near = |c: usize, size: usize| {
        let own = c / 2;
        let other = if c.is_multiple_of(2) { own.checked_sub(1) } else { Some(own + 1).filter(|o| *o < size) };
        [Some(own), other]
    };
    let (columns, rows) = (near(x, width), near(y, height));
    rows.into_iter().flat_map(move |row| columns.into_iter().filter_map(move |column| Some(row? * width + column?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: UpsamplingGuide = UpsamplingGuide {
        at: [8.0, 8.0],
        position: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
        cosine: 1.0,
        across: [1.0, 0.0],
        part: 0,
    };

    fn moved(at: [f32; 2], position: [f32; 3]) -> UpsamplingGuide {
        UpsamplingGuide { at, position, ..FLAT }
    }

    #[test]
    fn parents_are_those_around() {
        let found = |at, size| parents(at, size).collect::<Vec<_>>();
        assert_eq!(found([5, 2], [4, 4]), [4 + 2, 4 + 3, 2, 3]);
        assert_eq!(found([0, 0], [4, 4]), [0]);
        assert_eq!(found([7, 1], [4, 1]), [3]);
    }

    #[test]
    fn weights_follow_distance_depth_and_tilt() {
        assert_eq!(weight(&FLAT, &FLAT, 4.0), 1.0);
        let neighbour = weight(&FLAT, &moved([10.0, 8.0], [0.1, 0.0, 0.0]), 4.0);
        assert!((neighbour - 0.5 * (-0.25f32).exp()).abs() < 1e-6);
        assert_eq!(weight(&FLAT, &moved([12.0, 8.0], [0.2, 0.0, 0.0]), 4.0), 0.0, "a spacing away");
        assert!(weight(&FLAT, &moved([10.0, 8.0], [0.1, 0.0, 0.1]), 4.0) < 0.01 * neighbour, "behind an edge");
        assert_eq!(weight(&FLAT, &UpsamplingGuide { part: 1, ..FLAT }, 4.0), 0.0);
        // Seen obliquely, the kernel is wide at right angles to the projected normal.
        let tilted = UpsamplingGuide { cosine: 0.2, ..FLAT };
        let along = weight(&tilted, &moved([10.0, 8.0], [0.1, 0.0, 0.0]), 4.0);
        let across = weight(&tilted, &moved([8.0, 10.0], [0.0, 0.1, 0.0]), 4.0);
        assert!(across > 1.2 * along, "{across} {along}");
    }
}
