//! Lists of directions at which BTFs and RTI captures are sampled.

use crate::FormatError;
use crate::direction::{Vector, dot, from_polar, normalize, subtract};

/// Maximum number of directions of a set, equal to the maximum number of layers of a flat BTF.
pub const MAX_DIRECTIONS: usize = crate::container::MAX_LAYERS as usize;
/// Unit vectors closer than this, 0.014 degrees, count as equal: [`crate::direction_mesh`] cannot blend between them.
pub const SAME_DIRECTION: f64 = 2.5e-4;

/// Rings of the Bonn database of 2003: polar angle, count, first azimuth; degrees. 81 directions (Sattler, Sarlette and
/// Klein 2003, "Efficient and realistic visualization of cloth").
const UBO2003_RINGS: [(f64, usize, f64); 6] =
    [(0.0, 1, 0.0), (15.0, 6, 0.0), (30.0, 12, 0.0), (45.0, 18, 0.0), (60.0, 20, 0.0), (75.0, 24, 0.0)];

/// Rings of the Bonn database of 2014: 151 directions (Weinmann, Gall and Klein 2014).
const UBO2014_RINGS: [(f64, usize, f64); 10] = [
    (0.0, 1, 0.0),
    (11.0, 6, 15.0),
    (23.5, 12, 0.0),
    (30.0, 12, 15.0),
    (37.5, 12, 0.0),
    (45.0, 18, 0.0),
    (52.5, 18, 7.5),
    (60.0, 24, 0.0),
    (67.5, 24, 7.5),
    (75.0, 24, 0.0),
];

/// Directions of the upper hemisphere, in a fixed order.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionSet {
    /// Name in reports.
    pub name: String,
    /// Polar angle to the normal and azimuth from the tangent, degrees.
    pub angles: Vec<[f64; 2]>,
}

impl DirectionSet {
    /// Creates a validated set.
    ///
    /// # Errors
    /// Returns an error if there is no direction or more than [`MAX_DIRECTIONS`], a polar angle is outside [0, 90), an
    /// azimuth is outside [-360, 360], or two directions are within [`SAME_DIRECTION`].
    pub fn new(name: impl Into<String>, angles: Vec<[f64; 2]>) -> Result<Self, FormatError> {
        let set = Self { name: name.into(), angles };
        let count = set.angles.len();
        FormatError::check_range("directions", count, 1..=MAX_DIRECTIONS)?;
        for (index, angles) in set.angles.iter().enumerate() {
            if let Some((field, found, allowed)) = wrong_angle(*angles) {
                return Err(FormatError::whole(format!("direction {index}, {field}"), found.to_string(), allowed));
            }
        }
        match first_pair_of_equals(&set.directions()) {
            Some((first, second)) => Err(FormatError::whole(
                format!("direction {second}"),
                format!("equal to direction {first}"),
                "directions that differ from each other",
            )
            .problem()),
            None => Ok(set),
        }
    }

    /// The 81 directions of the Bonn University BTF database, 2003.
    pub fn ubo2003() -> Self {
        Self::from_rings("ubo2003", &UBO2003_RINGS)
    }

    /// The 151 directions of the Bonn University BTF database, 2014.
    pub fn ubo2014() -> Self {
        Self::from_rings("ubo2014", &UBO2014_RINGS)
    }

    /// The normal and `zeniths - 1` rings of `azimuths` directions each, `1 + (zeniths - 1) * azimuths` directions in
    /// total. Polar angles are equally spaced up to `max_zenith_degrees`; azimuths start at 0.
    ///
    /// # Errors
    /// Returns an error if a count is 0, there are more than [`MAX_DIRECTIONS`] directions, the largest polar angle is
    /// outside (0, 90), or rings are so fine that directions coincide.
    pub fn grid(zeniths: usize, azimuths: usize, max_zenith_degrees: f64) -> Result<Self, FormatError> {
        for (field, count) in [("zeniths", zeniths), ("azimuths", azimuths)] {
            if count == 0 {
                return Err(FormatError::whole(field, "0", "1 or more"));
            }
        }
        let count = (zeniths - 1).saturating_mul(azimuths).saturating_add(1);
        if count > MAX_DIRECTIONS {
            return Err(FormatError::whole("directions", count.to_string(), format!("at most {MAX_DIRECTIONS}")));
        }
        if !(max_zenith_degrees > 0.0 && max_zenith_degrees < 90.0) {
            return Err(FormatError::whole(
                "largest polar angle",
                max_zenith_degrees.to_string(),
                "degrees above 0 and below 90",
            ));
        }
        let mut angles = ring(0.0, 1, 0.0);
        for k in 1..zeniths {
            angles.extend(ring(max_zenith_degrees * k as f64 / (zeniths - 1) as f64, azimuths, 0.0));
        }
        Self::new(format!("grid-{zeniths}x{azimuths}"), angles)
    }

    /// Unit vectors, in the order of `angles`.
    pub fn directions(&self) -> Vec<Vector> {
        self.angles.iter().map(|[theta, phi]| from_polar(theta.to_radians(), phi.to_radians())).collect()
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.angles.len()
    }

    /// Returns true if the set is empty.
    pub fn is_empty(&self) -> bool {
        self.angles.is_empty()
    }

    /// Index of the direction at the smallest angle to `direction` (any non-zero length), the first of several. Returns
    /// 0 for an empty set.
    pub fn nearest(&self, direction: Vector) -> usize {
        let target = normalize(direction);
        let mut best = (0, f64::INFINITY);
        for (index, found) in self.directions().into_iter().enumerate() {
            let difference = subtract(found, target);
            let distance = dot(difference, difference);
            if distance < best.1 {
                best = (index, distance);
            }
        }
        best.0
    }

    fn from_rings(name: &str, rings: &[(f64, usize, f64)]) -> Self {
        let angles = rings.iter().flat_map(|&(theta, count, first)| ring(theta, count, first)).collect();
        Self { name: name.to_owned(), angles }
    }
}

/// `count` directions at polar angle `theta`, equally spaced in azimuth from `first`; degrees.
fn ring(theta: f64, count: usize, first: f64) -> Vec<[f64; 2]> {
    (0..count).map(|k| [theta, first + 360.0 * k as f64 / count as f64]).collect()
}

/// Returns the field, the value and the expected range of the first angle that is out of range.
pub fn wrong_angle([theta, phi]: [f64; 2]) -> Option<(&'static str, f64, &'static str)> {
    if !(0.0..90.0).contains(&theta) {
        return Some(("theta_deg", theta, "0 to less than 90"));
    }
    (!(-360.0..=360.0).contains(&phi)).then_some(("phi_deg", phi, "-360 to 360"))
}

/// Returns the first pair of equal directions: the earlier index, then the later.
pub fn first_pair_of_equals(directions: &[Vector]) -> Option<(usize, usize)> {
    let same = |a: Vector, b: Vector| {
        let difference = subtract(a, b);
        dot(difference, difference) < SAME_DIRECTION * SAME_DIRECTION
    };
    (1..directions.len()).find_map(|second| {
        (0..second).find(|first| same(directions[*first], directions[second])).map(|first| (first, second))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sets_of_bonn() {
        let set = DirectionSet::ubo2003();
        assert_eq!(set.len(), 81);
        assert_eq!(set.angles[..3], [[0.0, 0.0], [15.0, 0.0], [15.0, 60.0]]);
        for (theta, step) in [(15.0, 60.0), (30.0, 30.0), (45.0, 20.0), (60.0, 18.0), (75.0, 15.0)] {
            let ring: Vec<f64> = set.angles.iter().filter(|a| a[0] == theta).map(|a| a[1]).collect();
            assert!(ring.iter().enumerate().all(|(k, phi)| (phi - step * k as f64).abs() < 1e-12), "{ring:?}");
            assert_eq!(ring.len() as f64 * step, 360.0);
        }
        assert_eq!(DirectionSet::ubo2014().len(), 151);
        for set in [set, DirectionSet::ubo2014()] {
            assert_eq!(DirectionSet::new(set.name.clone(), set.angles.clone()), Ok(set));
        }
    }

    #[test]
    fn a_grid_has_one_pole() {
        let set = DirectionSet::grid(4, 8, 75.0).unwrap();
        assert_eq!(set.len(), 25);
        assert_eq!((set.angles[0], set.angles[1], set.angles[24]), ([0.0, 0.0], [25.0, 0.0], [75.0, 315.0]));
        assert_eq!(DirectionSet::grid(1, 8, 75.0).unwrap().len(), 1);
        let text = |z, a, t| DirectionSet::grid(z, a, t).unwrap_err().to_string();
        assert!(text(0, 8, 75.0).contains("zeniths: found 0"));
        assert!(text(4, 0, 75.0).contains("azimuths: found 0"));
        assert!(text(4, 8, 90.0).contains("found 90"));
        assert!(text(4, 8, f64::NAN).contains("NaN"));
        assert!(text(usize::MAX, 8, 75.0).contains("at most 2048"));
        assert!(text(2, 8, 1e-7).contains("differ"));
    }

    #[test]
    fn directions_are_unit_vectors_and_nearest_to_themselves() {
        let set = DirectionSet::ubo2014();
        for (index, d) in set.directions().into_iter().enumerate() {
            assert!((dot(d, d) - 1.0).abs() < 1e-14 && d[2] > 0.0);
            assert_eq!(set.nearest([2.0 * d[0], 2.0 * d[1], 2.0 * d[2]]), index);
        }
        let [theta, phi] = [75.0f64, 345.0f64].map(f64::to_radians);
        assert!((set.directions()[150][0] - theta.sin() * phi.cos()).abs() < 1e-14);
        assert_eq!(set.nearest([0.0, 0.05, 1.0]), 0);
        assert!(set.nearest([0.0, 0.0, -1.0]) >= 127, "one of the outer ring");
    }
}
