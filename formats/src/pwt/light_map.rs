//! Learned functions of the light: a small texture over the paraboloid of its direction.

use super::basis::paraboloid;
use crate::FormatError;
use crate::container::half;
use crate::tap::Tap;
use std::ops::RangeInclusive;

/// Range of the texels per side.
pub const MAP_SIDES: RangeInclusive<u32> = 4..=64;

/// RGB of each learned term under any light. The centre of texel `(column, row)` is at the paraboloid coordinates
/// `((column + ½) 2 / side - 1, (row + ½) 2 / side - 1)`: +x right, +y down.
#[derive(Debug, Clone, PartialEq)]
pub struct LightMap {
    side: u32,
    /// Term by term, row by row; rounded to half floats.
    texels: Vec<[f32; 3]>,
}

impl LightMap {
    /// Largest value of a texel.
    pub const LARGEST: f32 = half::MAX;

    /// Creates a map from the texels of all terms, row by row. Rounds them to half floats.
    ///
    /// # Errors
    /// Returns an error if the side is out of range, the number of texels is not a multiple of its square, or a number is
    /// not finite or beyond the range of half floats.
    pub fn new(side: u32, texels: &[[f32; 3]]) -> Result<Self, FormatError> {
        FormatError::check_range("side of the light map", side, MAP_SIDES)?;
        let of_term = (side * side) as usize;
        if texels.is_empty() || !texels.len().is_multiple_of(of_term) {
            let allowed = format!("a positive multiple of {of_term}");
            return Err(FormatError::whole("texels of the light map", texels.len().to_string(), allowed));
        }
        if let Some(texel) = texels.iter().find(|texel| texel.iter().any(|c| !c.is_finite() || c.abs() > half::MAX)) {
            let allowed = format!("-{0} to {0}", half::MAX);
            return Err(FormatError::whole("texel of the light map", format!("{texel:?}"), allowed));
        }
        let rounded = |texel: &[f32; 3]| texel.map(|c| half::decode(half::encode(c)));
        Ok(Self { side, texels: texels.iter().map(rounded).collect() })
    }

    /// Texels per side.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Number of terms.
    pub fn terms(&self) -> usize {
        self.texels.len() / (self.side * self.side) as usize
    }

    /// Leaves out all but the first terms.
    pub fn truncate(&mut self, terms: usize) {
        self.texels.truncate(terms * (self.side * self.side) as usize);
    }

    /// Bytes on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        Self::bytes_of(self.side, self.terms())
    }

    /// Bytes on a GPU of a map of `terms` terms.
    pub fn bytes_of(side: u32, terms: usize) -> u64 {
        8 * u64::from(side * side) * terms as u64
    }

    /// Directions of the texel centres, row by row: unit vectors, at the horizon beyond the unit circle.
    pub fn directions(side: u32) -> Vec<[f32; 3]> {
        let at = |k: u32| (k as f32 + 0.5) * 2.0 / side as f32 - 1.0;
        let direction = |(u, v): (f32, f32)| {
            let shrink = (u * u + v * v).sqrt().max(1.0);
            let (u, v) = (u / shrink, v / shrink);
            let z = (1.0 - u * u - v * v).max(0.0) / (1.0 + u * u + v * v);
            [u * (1.0 + z), v * (1.0 + z), z]
        };
        (0..side).flat_map(|row| (0..side).map(move |column| (at(column), at(row)))).map(direction).collect()
    }

    /// The four texels around a light, as indices within a term, and their weights.
    pub fn taps(side: u32, light: [f32; 3]) -> [(usize, f32); 4] {
        let [column, row] = paraboloid(light).map(|c| Tap::new((c * 0.5 + 0.5) * side as f32, side, false));
        let corner = |k: usize| {
            let weight = |tap: Tap, second: bool| if second { tap.weight } else { 1.0 - tap.weight };
            let (x, y) = (k % 2, k / 2);
            let at = (row.samples[y] * side + column.samples[x]) as usize;
            (at, weight(column, x == 1) * weight(row, y == 1))
        };
        [0, 1, 2, 3].map(corner)
    }

    /// RGB of a term under a light, filtered along columns first.
    ///
    /// # Panics
    /// Panics if the term does not exist.
    pub fn value(&self, term: usize, light: [f32; 3]) -> [f32; 3] {
        let side = self.side;
        let [column, row] = paraboloid(light).map(|c| Tap::new((c * 0.5 + 0.5) * side as f32, side, false));
        let texels = &self.texels[term * (side * side) as usize..];
        let along = |y: u32| {
            let [left, right] = column.samples.map(|x| texels[(y * side + x) as usize]);
            [0, 1, 2].map(|c| left[c] + column.weight * (right[c] - left[c]))
        };
        let [upper, lower] = row.samples.map(along);
        [0, 1, 2].map(|c| upper[c] + row.weight * (lower[c] - upper[c]))
    }

    /// Texels of a texture of four half floats, one layer per term.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let halves = |[r, g, b]: &[f32; 3]| [*r, *g, *b, 0.0].map(half::encode);
        self.texels.iter().flat_map(halves).flat_map(u16::to_le_bytes).collect()
    }

    /// Reads the texels of [`Self::to_bytes`].
    pub(super) fn from_bytes(side: u32, bytes: &[u8]) -> Result<Self, FormatError> {
        let halves = bytes.as_chunks::<8>().0;
        let number = |texel: &[u8; 8], c: usize| half::decode(u16::from_le_bytes([texel[2 * c], texel[2 * c + 1]]));
        if let Some(texel) = halves.iter().find(|texel| texel[6..] != [0; 2]) {
            return Err(FormatError::whole("fourth component of the light map", number(texel, 3).to_string(), "+0"));
        }
        let texels: Vec<[f32; 3]> = halves.iter().map(|texel| [0, 1, 2].map(|c| number(texel, c))).collect();
        Self::new(side, &texels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers: a map that is linear in the paraboloid is exact between its texels, and files return it.
    #[test]
    fn linear_maps_are_exact() {
        for side in [4, 32] {
            let of = |[x, y, z]: [f32; 3]| [x / (1.0 + z), 0.5 * y / (1.0 + z), 0.25];
            let at = |k: u32| (k as f32 + 0.5) * 2.0 / side as f32 - 1.0;
            let inside = (0..side).flat_map(|row| (0..side).map(move |column| [at(column), 0.5 * at(row), 0.25]));
            let texels: Vec<[f32; 3]> = inside.chain(vec![[2.0; 3]; (side * side) as usize]).collect();
            let map = LightMap::new(side, &texels).unwrap();
            assert_eq!((map.terms(), &LightMap::from_bytes(side, &map.to_bytes()).unwrap()), (2, &map));
            for light in [[0.0, 0.0, 1.0], [0.48, -0.6, 0.64], [-0.36, 0.48, 0.8]] {
                let found = map.value(0, light);
                assert!(found.iter().zip(of(light)).all(|(a, b)| (a - b).abs() < 1e-3), "{light:?} {found:?}");
                let sum =
                    |c: usize| LightMap::taps(side, light).iter().map(|(at, w)| w * map.texels[*at][c]).sum::<f32>();
                assert!([0, 1, 2].iter().all(|c| (sum(*c) - found[*c]).abs() < 1e-6));
                assert_eq!(map.value(1, light), [2.0; 3]);
            }
        }
    }

    #[test]
    fn texel_directions_are_those_of_their_centres() {
        let side = 16;
        for (at, direction) in LightMap::directions(side).into_iter().enumerate() {
            let length: f32 = direction.iter().map(|c| c * c).sum();
            assert!((length - 1.0).abs() < 1e-5 && direction[2] >= 0.0);
            if direction[2] > 0.01 {
                let nearest = LightMap::taps(side, direction).into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
                assert_eq!(nearest.map(|(at, _)| at), Some(at));
            }
        }
    }

    #[test]
    fn wrong_maps_are_refused() {
        for (side, texels) in
            [(3, vec![[0.0; 3]; 9]), (4, vec![[0.0; 3]; 15]), (4, vec![]), (4, vec![[f32::NAN; 3]; 16])]
        {
            assert!(LightMap::new(side, &texels).is_err());
        }
        let mut bytes = LightMap::new(4, &[[1.0; 3]; 16]).unwrap().to_bytes();
        bytes[7] = 0x80;
        let error = LightMap::from_bytes(4, &bytes).unwrap_err().to_string();
        assert_eq!(error, "fourth component of the light map: found -0, expected +0");
    }
}
