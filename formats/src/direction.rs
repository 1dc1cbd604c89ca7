//! Pairs of directions, and their mapping to the grid cells of wavelet packs, shared by encoders and decoders.
//!
//! A wavelet pack holds a table over two hemispheres, `outer` and `inner`, each on the same N x N grid. The outer axis
//! is the image in a slice, filtered by the sampler; the inner axis is wavelet-transformed over slices. A
//! [`Parameterisation`] maps a direction pair to a point on each hemisphere.

/// A vector in the local frame: x = tangent, y = bitangent, z = normal.
pub type Vector = [f64; 3];

/// Unit vectors that point away from the surface, to the light and to the viewer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionPair {
    /// Direction to the light, `wi`.
    pub incoming: Vector,
    /// Direction to the viewer, `wo`.
    pub outgoing: Vector,
}

impl DirectionPair {
    /// Pair of unit vectors.
    pub fn new(incoming: Vector, outgoing: Vector) -> Self {
        Self { incoming, outgoing }
    }

    /// Pair from polar angles to the normal and azimuths from the tangent, radians.
    pub fn from_angles(theta_i: f64, phi_i: f64, theta_o: f64, phi_o: f64) -> Self {
        Self::new(from_polar(theta_i, phi_i), from_polar(theta_o, phi_o))
    }

    /// The pair with light and viewer exchanged.
    pub fn exchanged(self) -> Self {
        Self::new(self.outgoing, self.incoming)
    }

    /// Returns true if both directions are above the horizon, `z > 0`.
    pub fn is_above_horizon(self) -> bool {
        self.incoming[2] > 0.0 && self.outgoing[2] > 0.0
    }
}

/// Unit vector at a polar angle `theta` to the normal and azimuth `phi` from the tangent, radians.
pub fn from_polar(theta: f64, phi: f64) -> Vector {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// Dot product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a - b`.
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + s b`.
pub fn add_scaled(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// Scales a vector to length 1; a zero vector becomes the normal.
pub fn normalize(v: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    if length > 0.0 { [v[0] / length, v[1] / length, v[2] / length] } else { [0.0, 0.0, 1.0] }
}

/// Half vector, `normalize(wi + wo)`.
pub fn half_vector(pair: DirectionPair) -> Vector {
    let (i, o) = (pair.incoming, pair.outgoing);
    normalize([i[0] + o[0], i[1] + o[1], i[2] + o[2]])
}

/// Longitude and colatitude on the tangent-pole grid (Claustres et al. 2007, section 4.1), each in `[0, π]`:
/// `x = sin φ cos θ, y = cos φ, z = sin φ sin θ`. Returned as `[θ, φ]`.
pub fn to_tangent_pole(d: Vector) -> [f64; 2] {
    let z = d[2].max(0.0);
    [z.atan2(d[0]), (d[0] * d[0] + z * z).sqrt().atan2(d[1])]
}

/// The direction at longitude `θ` and colatitude `φ`; inverse of [`to_tangent_pole`].
pub fn from_tangent_pole([theta, phi]: [f64; 2]) -> Vector {
    [phi.sin() * theta.cos(), phi.cos(), phi.sin() * theta.sin()]
}

/// Centre of cell `(column, row)` of an `n` x `n` tangent-pole grid: `θ = (column + ½) π / n`, `φ = (row + ½) π / n`.
pub fn cell_centre(column: usize, row: usize, n: usize) -> Vector {
    let step = std::f64::consts::PI / n as f64;
    from_tangent_pole([(column as f64 + 0.5) * step, (row as f64 + 0.5) * step])
}

/// Mapping of a direction pair to two points on hemispheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(rename_all = "kebab-case")
)]
pub enum Parameterisation {
    /// Outer = incoming, inner = outgoing, as in the paper.
    TangentPole,
    /// Outer = half vector `h`, inner = the incoming direction in the frame that the shortest rotation from `h` to the
    /// normal gives (the difference vector of Rusinkiewicz 1998, without its singularity at `h` = normal).
    HalfDifference,
}

impl Parameterisation {
    /// Names for command line and files.
    pub const NAMES: [(&'static str, Self); 2] =
        [("tangent-pole", Self::TangentPole), ("half-difference", Self::HalfDifference)];

    /// Name for command line and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::TangentPole => "tangent-pole",
            Self::HalfDifference => "half-difference",
        }
    }

    /// Number in a pack's header.
    pub fn code(self) -> u32 {
        match self {
            Self::TangentPole => 0,
            Self::HalfDifference => 1,
        }
    }

    /// Parameterisation with this [`Self::code`]; `None` for unknown codes.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::NAMES.into_iter().map(|(_, p)| p).find(|p| p.code() == code)
    }

    /// Outer and inner hemisphere points of a direction pair.
    pub fn to_axes(self, pair: DirectionPair) -> (Vector, Vector) {
        match self {
            Self::TangentPole => (pair.incoming, pair.outgoing),
            Self::HalfDifference => {
                let half = half_vector(pair);
                (half, rotate_to_normal(half, pair.incoming))
            }
        }
    }

    /// Direction pair of an outer and an inner hemisphere point.
    ///
    /// With half vectors a direction may be below the horizon: see [`DirectionPair::is_above_horizon`].
    pub fn from_axes(self, outer: Vector, inner: Vector) -> DirectionPair {
        match self {
            Self::TangentPole => DirectionPair::new(outer, inner),
            Self::HalfDifference => {
                let mirrored = [-inner[0], -inner[1], inner[2]];
                DirectionPair::new(rotate_from_normal(outer, inner), rotate_from_normal(outer, mirrored))
            }
        }
    }
}

/// Rotates `v` by the shortest rotation that takes the unit vector `axis` (above the horizon) to the normal.
pub fn rotate_to_normal(axis: Vector, v: Vector) -> Vector {
    let [x, y, z] = axis;
    let s = (x * v[0] + y * v[1]) / (1.0 + z);
    [v[0] - x * (s + v[2]), v[1] - y * (s + v[2]), dot(axis, v)]
}

/// Inverse of [`rotate_to_normal`]: the rotation that turns the normal to `axis`, applied to `v`.
pub fn rotate_from_normal(axis: Vector, v: Vector) -> Vector {
    let [x, y, z] = axis;
    let s = (x * v[0] + y * v[1]) / (1.0 + z);
    [v[0] - x * (s - v[2]), v[1] - y * (s - v[2]), z * v[2] - (x * v[0] + y * v[1])]
}

/// `atan2(y, x)` for `y >= 0`, radians in `[0, π]`, within 3e-7 of the exact angle.
///
/// Odd minimax polynomial on [0, 1] with a fixed order of f32 operations, so that shaders can reproduce it: built-in
/// functions of GPUs are not precise enough to agree.
pub fn polynomial_atan2(y: f32, x: f32) -> f32 {
    polynomial_atan2_each([y], [x])[0]
}

/// [`polynomial_atan2`] of several pairs at once, for SIMD.
pub fn polynomial_atan2_each<const N: usize>(y: [f32; N], x: [f32; N]) -> [f32; N] {
    const C: [f32; 8] = [
        9.999_993_4e-1,
        -3.332_986e-1,
        1.994_656_6e-1,
        -0.139_086_3,
        9.642_198e-2,
        -5.591_232_7e-2,
        2.186_295_8e-2,
        -4.054_566_4e-3,
    ];
    std::array::from_fn(|k| {
        let (y, ax) = (y[k], x[k].abs());
        let steep = y > ax;
        let (small, large) = (if steep { ax } else { y }, if steep { y } else { ax });
        let t = small / if large > 0.0 { large } else { 1.0 };
        let t2 = t * t;
        let mut p = C[7];
        for c in C[..7].iter().rev() {
            p = p * t2 + c;
        }
        let angle = subtracted_if(steep, std::f32::consts::FRAC_PI_2, p * t);
        subtracted_if(x[k] < 0.0, std::f32::consts::PI, angle)
    })
}

/// `from - angle` if the condition holds, else `angle`. Branch-free, because random directions would be mispredicted.
pub(crate) fn subtracted_if(condition: bool, from: f32, angle: f32) -> f32 {
    let bits = u32::from(condition).wrapping_neg();
    f32::from_bits(from.to_bits() & bits) + f32::from_bits(angle.to_bits() ^ (bits & 0x8000_0000))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn upper() -> impl Strategy<Value = Vector> {
        (0.01f64..1.56, 0.0f64..std::f64::consts::TAU).prop_map(|(t, p)| from_polar(t, p))
    }

    fn close(a: Vector, b: Vector) -> bool {
        (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12)
    }

    proptest! {
        #[test]
        fn tangent_pole_round_trip(d in upper()) {
            prop_assert!(close(from_tangent_pole(to_tangent_pole(d)), d));
        }

        #[test]
        fn axes_round_trip(i in upper(), o in upper()) {
            let pair = DirectionPair::new(i, o);
            for (_, p) in Parameterisation::NAMES {
                let (outer, inner) = p.to_axes(pair);
                let back = p.from_axes(outer, inner);
                prop_assert!(close(back.incoming, i) && close(back.outgoing, o), "{p:?}");
            }
        }

        #[test]
        fn exchange_turns_the_difference_vector_by_half_a_turn(i in upper(), o in upper()) {
            let p = Parameterisation::HalfDifference;
            let (h, d) = p.to_axes(DirectionPair::new(i, o));
            let (h2, d2) = p.to_axes(DirectionPair::new(o, i));
            prop_assert!(close(h, h2) && close([-d[0], -d[1], d[2]], d2));
        }

        #[test]
        fn polynomial_angle_is_close(angle in 0.0f64..std::f64::consts::PI, r in 1e-3f64..1e3) {
            let (y, x) = ((r * angle.sin()) as f32, (r * angle.cos()) as f32);
            let exact = f64::from(y).atan2(f64::from(x));
            prop_assert!((f64::from(polynomial_atan2(y, x)) - exact).abs() < 3e-7);
        }
    }

    #[test]
    fn the_pole_is_the_bitangent_and_the_grid_spans_the_hemisphere() {
        assert!(close(from_tangent_pole([1.0, 0.0]), [0.0, 1.0, 0.0]));
        assert!(close(from_tangent_pole([std::f64::consts::FRAC_PI_2; 2]), [0.0, 0.0, 1.0]));
        for row in 0..8 {
            for column in 0..8 {
                let d = cell_centre(column, row, 8);
                assert!(d[2] > 0.0 && (dot(d, d) - 1.0).abs() < 1e-14);
            }
        }
    }
}
