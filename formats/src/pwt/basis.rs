//! Basis functions of the light direction: polynomials of degree 0 to 5, or functions learned from photographs. A texel is a
//! weighted sum of them.
//!
//! All steps are f32 operations in a fixed order, the same as in `formats/src/pwt/pwt.wgsl`.

/// Coordinates of the light direction in the polynomials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum LightCoordinates {
    /// `(x, y) / (1 + z)`, the paraboloid of section 2 of the paper (Heidrich and Seidel 1998).
    Paraboloid,
    /// `(x, y)`, as in polynomial texture maps (Malzbender, Gelb and Wolters 2001).
    Projected,
    /// Hemispherical harmonics (Gautron, Křivánek, Pattanaik and Bouatouch 2004).
    Hemisphere,
    /// The paraboloid, as coordinates of a [`LightMap`](super::LightMap) of terms that are learned from photographs.
    Learned,
}

impl LightCoordinates {
    /// All variants, indexed by their number in files.
    pub const ALL: [Self; 4] = [Self::Paraboloid, Self::Projected, Self::Hemisphere, Self::Learned];
    /// The variants with polynomials.
    pub const POLYNOMIAL: [Self; 3] = [Self::Paraboloid, Self::Projected, Self::Hemisphere];

    /// Name for command line and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paraboloid => "paraboloid",
            Self::Projected => "projected",
            Self::Hemisphere => "hemisphere",
            Self::Learned => "learned",
        }
    }

    /// Highest degree: [`MAX_DEGREE`], or the largest number of learned terms after the first.
    pub fn max_degree(self) -> u32 {
        if self == Self::Learned { MAX_TERMS as u32 - 1 } else { MAX_DEGREE }
    }
}

/// Maximum degree of the polynomials.
pub const MAX_DEGREE: u32 = 5;
/// Maximum number of terms: hemispherical harmonics up to [`MAX_DEGREE`].
pub const MAX_TERMS: usize = 36;

/// All terms up to a degree, in ascending order of degree. A lower maximum degree gives a prefix of the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LightBasis {
    /// Coordinates of the light direction.
    pub coordinates: LightCoordinates,
    /// Highest degree, 0 to [`MAX_DEGREE`]; the number of learned terms after the first, up to
    /// [`LightCoordinates::max_degree`].
    pub degree: u32,
}

impl LightBasis {
    /// Number of terms of all degrees.
    pub fn terms(self) -> usize {
        let n = self.degree as usize + 1;
        match self.coordinates {
            LightCoordinates::Hemisphere => n * n,
            LightCoordinates::Learned => n,
            _ => n * (n + 1) / 2,
        }
    }

    /// Degree of a term.
    pub fn degree_of(self, term: usize) -> u32 {
        (0..self.degree).find(|degree| term < Self { degree: *degree, ..self }.terms()).unwrap_or(self.degree)
    }

    /// All terms for a unit vector to the light, above the horizon; 0 after the last one. Learned terms are those of a
    /// [`LightMap`](super::LightMap), and 0 here.
    ///
    /// Terms of degree `d`: `u^d, u^(d-1) v, …, v^d`; or the harmonics `l = d`, `m = -d` to `d`, without normalisation:
    /// `P_d^|m|(2z - 1)` times `cos(mφ)` or, for negative m, `sin(|m|φ)`.
    pub fn evaluate(self, light: [f32; 3]) -> [f32; MAX_TERMS] {
        let [x, y, z] = light;
        let mut terms = [0.0; MAX_TERMS];
        match self.coordinates {
            LightCoordinates::Hemisphere => self.harmonics(x, y, z.max(0.0), &mut terms),
            LightCoordinates::Paraboloid => {
                let [u, v] = paraboloid(light);
                self.powers(u, v, &mut terms);
            }
            LightCoordinates::Learned => {}
            LightCoordinates::Projected => self.powers(x, y, &mut terms),
        }
        terms
    }

    /// The terms of each degree are the terms of the previous degree times u, then the last of these terms times v.
    fn powers(self, u: f32, v: f32, terms: &mut [f32; MAX_TERMS]) {
        terms[0] = 1.0;
        let mut before = 0;
        for degree in 1..=self.degree as usize {
            let first = before + degree;
            for k in 0..degree {
                terms[first + k] = terms[before + k] * u;
            }
            terms[first + degree] = terms[first - 1] * v;
            before = first;
        }
    }

    /// `sin θ' e^(iφ)` with `cos θ' = 2z - 1` is `2 sqrt(z / (1 + z)) (x + iy)`, which avoids a division by 0 at the
    /// pole.
    fn harmonics(self, x: f32, y: f32, z: f32, terms: &mut [f32; MAX_TERMS]) {
        let shifted = 2.0 * z - 1.0;
        let scale = 2.0 * (z / (1.0 + z)).sqrt();
        let (a, b) = (scale * x, scale * y);
        // (a + ib)^m, and P_m^m without the power of the sine.
        let (mut cosine, mut sine, mut diagonal) = (1.0f32, 0.0f32, 1.0f32);
        for m in 0..=self.degree {
            let order = m as f32;
            if m > 0 {
                (cosine, sine) = (cosine * a - sine * b, cosine * b + sine * a);
                diagonal *= 2.0 * order - 1.0;
            }
            let (mut before, mut legendre) = (0.0f32, diagonal);
            for l in m..=self.degree {
                let middle = (l * l + l) as usize;
                terms[middle + m as usize] = legendre * cosine;
                if m > 0 {
                    terms[middle - m as usize] = legendre * sine;
                }
                let degree = l as f32;
                let next = (2.0 * degree + 1.0) * shifted * legendre - (degree + order) * before;
                (before, legendre) = (legendre, next / (degree - order + 1.0));
            }
        }
    }
}

/// Paraboloid coordinates of a light, -1 to 1 above the horizon.
pub(super) fn paraboloid([x, y, z]: [f32; 3]) -> [f32; 2] {
    [x / (1.0 + z), y / (1.0 + z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoints of equal-area cells of the hemisphere.
    fn directions() -> impl Iterator<Item = [f32; 3]> {
        const N: usize = 60;
        (0..N * 4 * N).map(|k| {
            let z = (k / (4 * N)) as f32 / N as f32 + 0.5 / N as f32;
            let phi = (k % (4 * N)) as f32 / (4 * N) as f32 * std::f32::consts::TAU;
            let r = (1.0 - z * z).sqrt();
            [r * phi.cos(), r * phi.sin(), z]
        })
    }

    #[test]
    fn terms_are_ordered_by_degree() {
        for coordinates in LightCoordinates::POLYNOMIAL {
            let full = LightBasis { coordinates, degree: MAX_DEGREE };
            assert!(full.terms() <= MAX_TERMS);
            for degree in 0..=MAX_DEGREE {
                let basis = LightBasis { degree, ..full };
                assert!((0..basis.terms()).all(|term| full.degree_of(term) <= degree));
                assert!((basis.terms()..full.terms()).all(|term| full.degree_of(term) > degree));
                for light in directions().step_by(97) {
                    let [few, all] = [basis.evaluate(light), full.evaluate(light)];
                    assert_eq!(few[..basis.terms()], all[..basis.terms()]);
                    assert!(few[basis.terms()..].iter().all(|term| *term == 0.0));
                }
            }
        }
        assert_eq!(LightBasis { coordinates: LightCoordinates::Hemisphere, degree: 5 }.terms(), 36);
        assert_eq!(LightBasis { coordinates: LightCoordinates::Projected, degree: 2 }.terms(), 6);
    }

    #[test]
    fn polynomials_of_known_points() {
        let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 2 };
        assert_eq!(basis.evaluate([0.6, -0.5, 0.3])[..6], [1.0, 0.6, -0.5, 0.6 * 0.6, 0.6 * -0.5, -0.5 * -0.5]);
        let basis = LightBasis { coordinates: LightCoordinates::Paraboloid, degree: 1 };
        assert_eq!(basis.evaluate([0.6, 0.0, 0.8])[..3], [1.0, 0.6 / 1.8, 0.0]);
    }

    /// Known answer: harmonics of unlike order or degree are orthogonal over the hemisphere; those of the paraboloid
    /// are not.
    #[test]
    fn harmonics_are_orthogonal() {
        let worst = |coordinates| {
            let basis = LightBasis { coordinates, degree: 3 };
            let n = basis.terms();
            let mut sums = vec![0.0f64; n * n];
            for light in directions() {
                let terms = basis.evaluate(light);
                for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
                    sums[i * n + j] += f64::from(terms[i]) * f64::from(terms[j]);
                }
            }
            let share = |i: usize, j: usize| sums[i * n + j].abs() / (sums[i * n + i] * sums[j * n + j]).sqrt();
            (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| share(i, j)).fold(0.0, f64::max)
        };
        let harmonics = worst(LightCoordinates::Hemisphere);
        assert!(harmonics < 2e-3, "{harmonics}");
        assert!(worst(LightCoordinates::Paraboloid) > 0.1);
    }
}
