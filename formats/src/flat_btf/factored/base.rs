//! Base of a factored flat BTF: a diffuse and a glossy reflection under the normal of each texel, corrected by the sum
//! of components. It is evaluated for the exact view and light, so that the distance between sampled directions does
//! not blur highlights.

use super::header::{DIFFERENCE_ANGLES, HALF_ANGLES, MAX_BASE};
use super::maps::WeightRange;
use crate::FormatError;
use crate::container::half;

/// Maximum number in a table.
pub const MAX_ENTRY: f32 = half::MAX;
/// Maximum diffuse and glossy albedo.
const MAX_ALBEDO: f32 = 1024.0;
/// Minimum sum of cosines in the divisor of a glossy reflection.
const MIN_COSINES: f32 = 0.1;
/// Maximum paraboloid coordinate after filtering.
const MAX_FILTERED_SLOPE: f32 = 1024.0;
/// Maximum paraboloid coordinate of a normal. It allows overhangs down to a height of -15/17.
const MAX_SLOPE: f32 = 4.0;

/// Angle of the first axis of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Axis {
    /// Angle between normal and half vector.
    #[default]
    Half = 0,
    /// Half of the angle between the view and the light's mirror direction, in steps as large: for Phong lobes.
    Mirror = 1,
}

/// Table `T`: reflection for a gloss of 1, linear RGB by half or mirror angle and difference angle, without the cosine
/// factor.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseTable {
    axis: Axis,
    /// `48 x 8` entries, difference angle fastest.
    entries: Vec<[f32; 3]>,
}

/// A material of a surface: `diffuse A cos θi + T geometry`. From afar it is that of the whole relief within a texel.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseMaterial {
    /// Diffuse albedo, linear RGB.
    pub diffuse: [f32; 3],
    /// Tables over the same axis, one for each mipmap level; the last also for all coarser levels.
    pub tables: Vec<LevelTable>,
}

/// Table of a material for the texels of a mipmap level.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelTable {
    /// `T`.
    pub gloss: BaseTable,
    /// `A`, factor of the diffuse reflection: `48 x 8` numbers of 0 to [`MAX_ENTRY`].
    pub diffuse: Vec<f32>,
}

/// A place between the tables of two levels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TablePlace {
    /// The finer level of both.
    pub level: usize,
    /// Share of the next coarser level.
    pub blend: f32,
}

/// Values of the base at a texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseTexel {
    /// Diffuse albedo, linear RGB; with materials, the tint.
    pub diffuse: [f32; 3],
    /// Factor of the table; with two materials, the share of the second.
    pub gloss: f32,
    /// Unit normal, in the frame of the reference plane.
    pub normal: [f32; 3],
    /// Level of the tables.
    pub tables: TablePlace,
}

/// Angles of a view and a light relative to a normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseAngles {
    /// Cosine of the light's angle to the normal, above 0.
    pub cosine: f32,
    /// Cosine of the view's angle to the normal, 0 if it is behind the surface.
    pub outgoing: f32,
    /// Factor of a glossy reflection: `cos θi / max(cos θi + cos θo, 0.1)`.
    pub geometry: f32,
    /// Four table entries and their weights.
    pub taps: [(usize, f32); 4],
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl BaseAngles {
    /// Angles for unit vectors and tables with this axis; `None` if the light is behind the surface.
    #[inline]
    pub fn new(axis: Axis, normal: [f32; 3], view: [f32; 3], light: [f32; 3]) -> Option<Self> {
        let cosine = dot(normal, light).min(1.0);
        if cosine <= 0.0 {
            return None;
        }
        let outgoing = dot(normal, view).clamp(0.0, 1.0);
        let sum = [view[0] + light[0], view[1] + light[1], view[2] + light[2]];
        let length = dot(sum, sum).sqrt();
        // Opposite vectors have no half vector.
        let scale = if length > 1e-6 { 1.0 / length } else { 0.0 };
        let apart = match axis {
            Axis::Half => {
                let apart = [normal[0] - scale * sum[0], normal[1] - scale * sum[1], normal[2] - scale * sum[2]];
                0.5 * dot(apart, apart)
            }
            Axis::Mirror => {
                let twice = 2.0 * cosine;
                let mirror = [twice * normal[0] - light[0], twice * normal[1] - light[1], twice * normal[2] - light[2]];
                let apart = [view[0] - mirror[0], view[1] - mirror[1], view[2] - mirror[2]];
                0.25 * dot(apart, apart)
            }
        };
        let half = apart.min(1.0).sqrt().sqrt() * (HALF_ANGLES - 1) as f32;
        let difference = (1.0 - (0.5 * length).min(1.0)) * (DIFFERENCE_ANGLES - 1) as f32;
        let i = half.floor().min((HALF_ANGLES - 2) as f32);
        let j = difference.floor().min((DIFFERENCE_ANGLES - 2) as f32);
        let (across, along) = (half - i, difference - j);
        let first = i as usize * DIFFERENCE_ANGLES + j as usize;
        let taps = [
            (first, (1.0 - across) * (1.0 - along)),
            (first + 1, (1.0 - across) * along),
            (first + DIFFERENCE_ANGLES, across * (1.0 - along)),
            (first + DIFFERENCE_ANGLES + 1, across * along),
        ];
        Some(Self { cosine, outgoing, geometry: cosine / (cosine + outgoing).max(MIN_COSINES), taps })
    }
}

impl BaseTable {
    /// Creates a table over half angles from `48 x 8` entries, difference angle fastest, rounded to half precision.
    ///
    /// # Errors
    /// Returns an error if the number of entries is wrong or a number is not in 0 to [`MAX_ENTRY`].
    pub fn new(entries: Vec<[f32; 3]>) -> Result<Self, FormatError> {
        let expected = HALF_ANGLES * DIFFERENCE_ANGLES;
        if entries.len() != expected {
            return Err(FormatError::whole("entries of the base", entries.len().to_string(), expected.to_string()));
        }
        let good = |entry: &[f32; 3]| entry.iter().all(|number| (0.0..=MAX_ENTRY).contains(number));
        match entries.iter().position(|entry| !good(entry)) {
            Some(at) => {
                let (i, j) = (at / DIFFERENCE_ANGLES, at % DIFFERENCE_ANGLES);
                let allowed = format!("numbers of 0 to {MAX_ENTRY}");
                Err(FormatError::whole(format!("entry ({i}, {j}) of the base"), format!("{:?}", entries[at]), allowed))
            }
            None => Ok(Self { axis: Axis::Half, entries: entries.iter().map(|entry| entry.map(rounded)).collect() }),
        }
    }

    /// Table of a base without glossy reflection: all entries are 0.
    pub fn black() -> Self {
        Self { axis: Axis::Half, entries: vec![[0.0; 3]; HALF_ANGLES * DIFFERENCE_ANGLES] }
    }

    /// The same entries over another axis.
    #[must_use]
    pub fn over(self, axis: Axis) -> Self {
        Self { axis, ..self }
    }

    /// Angle of the first axis.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// All entries, difference angle fastest.
    pub fn entries(&self) -> &[[f32; 3]] {
        &self.entries
    }

    /// Interpolates the table: the sum of four entries with their weights, linear RGB.
    #[inline]
    pub fn at(&self, taps: &[(usize, f32); 4]) -> [f32; 3] {
        taps.iter().fold([0.0f32; 3], |sum, (at, weight)| {
            let entry = self.entries[*at];
            [sum[0] + weight * entry[0], sum[1] + weight * entry[1], sum[2] + weight * entry[2]]
        })
    }

    /// Colour of a texel in a view under an unshadowed light, linear RGB relative to a white diffuser that faces the
    /// light: `diffuse cos θi + gloss T(half angle, difference angle) geometry`, 0 to [`MAX_BASE`].
    #[inline]
    pub fn colour(&self, texel: &BaseTexel, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        let Some(angles) = BaseAngles::new(self.axis, texel.normal, view, light) else { return [0.0; 3] };
        let table = self.at(&angles.taps);
        let gloss = texel.gloss * angles.geometry;
        [0, 1, 2].map(|c: usize| (texel.diffuse[c] * angles.cosine + gloss * table[c]).min(MAX_BASE))
    }
}

fn rounded(number: f32) -> f32 {
    half::decode(half::encode(number))
}

impl LevelTable {
    /// Creates a table from factors of the diffuse reflection, rounded to half precision.
    ///
    /// # Errors
    /// Returns an error for another number of factors, or one that is not in 0 to [`MAX_ENTRY`].
    pub fn new(gloss: BaseTable, diffuse: Vec<f32>) -> Result<Self, FormatError> {
        let wrong = |found: String, allowed| FormatError::whole("diffuse factors of a material", found, allowed);
        if diffuse.len() != gloss.entries.len() {
            return Err(wrong(diffuse.len().to_string(), gloss.entries.len().to_string()));
        }
        match diffuse.iter().find(|factor| !(0.0..=MAX_ENTRY).contains(*factor)) {
            Some(found) => Err(wrong(found.to_string(), format!("numbers of 0 to {MAX_ENTRY}"))),
            None => Ok(Self { gloss, diffuse: diffuse.into_iter().map(rounded).collect() }),
        }
    }

    /// The table of a material close up: all of its diffuse reflection.
    pub fn close_up(gloss: BaseTable) -> Self {
        Self { diffuse: vec![1.0; gloss.entries.len()], gloss }
    }

    /// Interpolates `T` (three) and `A`.
    #[inline]
    fn at(&self, taps: &[(usize, f32); 4]) -> [f32; 4] {
        let [red, green, blue] = self.gloss.at(taps);
        [red, green, blue, taps.iter().fold(0.0f32, |sum, (at, weight)| sum + weight * self.diffuse[*at])]
    }
}

impl TablePlace {
    /// The place of a level of detail, a whole level and a share of the next, among `count` tables.
    #[inline]
    pub(super) fn new(level: u32, blend: f32, count: u32) -> Self {
        if level + 1 < count {
            Self { level: level as usize, blend }
        } else {
            Self { level: count as usize - 1, blend: 0.0 }
        }
    }
}

impl BaseMaterial {
    /// Axis of the tables.
    pub fn axis(&self) -> Axis {
        self.tables[0].gloss.axis
    }

    /// Value of a texel with a tint of 1 in a view under an unshadowed light, linear RGB.
    ///
    /// # Panics
    /// Panics if there is no table for the texel's level.
    #[inline]
    pub fn value(&self, texel: &BaseTexel, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        let Some(angles) = BaseAngles::new(self.axis(), texel.normal, view, light) else { return [0.0; 3] };
        let TablePlace { level, blend } = texel.tables;
        let mut entry = self.tables[level].at(&angles.taps);
        if blend > 0.0 {
            let coarse = self.tables[level + 1].at(&angles.taps);
            entry = [0, 1, 2, 3].map(|k: usize| entry[k] + blend * (coarse[k] - entry[k]));
        }
        let cosine = entry[3] * angles.cosine;
        [0, 1, 2].map(|c: usize| self.diffuse[c] * cosine + angles.geometry * entry[c])
    }
}

/// Colour of a texel of one or two materials, linear RGB, 0 to [`MAX_BASE`]: `tint ((1 - share) first + share second)`.
#[inline]
pub(super) fn blended_materials(
    materials: &[BaseMaterial],
    texel: &BaseTexel,
    view: [f32; 3],
    light: [f32; 3],
) -> [f32; 3] {
    let mut value = materials[0].value(texel, view, light);
    if let Some(second) = materials.get(1) {
        let second = second.value(texel, view, light);
        value = [0, 1, 2].map(|c: usize| (1.0 - texel.gloss) * value[c] + texel.gloss * second[c]);
    }
    [0, 1, 2].map(|c: usize| (texel.diffuse[c] * value[c]).clamp(0.0, MAX_BASE))
}

/// Decodes the components of the two base layers: `diffuse` red, green, blue, `gloss`; and the normal.
pub(super) fn base_texel(tables: TablePlace, [red, green, blue, gloss, x, x_low, y, y_low]: [f32; 8]) -> BaseTexel {
    // NaN becomes the minimum.
    let between = |number: f32, least: f32, most: f32| if number > least { number.min(most) } else { least };
    let albedo = |number: f32| between(number, 0.0, MAX_ALBEDO);
    let slope = |number: f32| between(number, -MAX_FILTERED_SLOPE, MAX_FILTERED_SLOPE);
    let (p, q) = (slope(x + x_low), slope(y + y_low));
    let scale = 2.0 / (1.0 + p * p + q * q);
    BaseTexel {
        diffuse: [red, green, blue].map(albedo),
        gloss: albedo(gloss),
        normal: [p * scale, q * scale, scale - 1.0],
        tables,
    }
}

/// Paraboloid coordinates of a unit normal, `(x, y) / (1 + z)`, as 16 bits each, in the form that the second base layer
/// holds with [`slope_ranges`].
pub fn slope_words([x, y, z]: [f32; 3]) -> [u16; 2] {
    let scale = 1.0 / (1.0 + z).max(1e-6);
    [x, y].map(|c| {
        let share = (c * scale / MAX_SLOPE).clamp(-1.0, 1.0) * 0.5 + 0.5;
        (share * 65535.0).round() as u16
    })
}

/// Unit normal of [`slope_words`].
pub fn slope_texel(words: [u16; 2]) -> [f32; 3] {
    let [high, low, ..] = slope_ranges();
    let [x, y] = words.map(|word| {
        let [higher, lower] = word.to_be_bytes();
        high.of_byte(higher) + low.of_byte(lower)
    });
    base_texel(TablePlace::default(), [0.0, 0.0, 0.0, 0.0, x, 0.0, y, 0.0]).normal
}

/// Ranges of the bytes of [`slope_words`], the higher byte of each first.
pub fn slope_ranges() -> [WeightRange; 4] {
    let unit = 2.0 * MAX_SLOPE / 65535.0;
    let [high, low] =
        [WeightRange { scale: 65280.0 * unit, low: -MAX_SLOPE }, WeightRange { scale: 255.0 * unit, low: 0.0 }];
    [high, low, high, low]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit([x, y, z]: [f32; 3]) -> [f32; 3] {
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    /// Without gloss the base is Lambertian.
    #[test]
    fn without_gloss_it_is_diffuse() {
        let table = BaseTable::new(vec![[9.0; 3]; HALF_ANGLES * DIFFERENCE_ANGLES]).unwrap();
        let texel =
            BaseTexel { diffuse: [0.5, 0.25, 1.0], gloss: 0.0, normal: [0.0, 0.6, 0.8], tables: TablePlace::default() };
        assert_eq!(table.colour(&texel, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), [0.4, 0.2, 0.8]);
        assert_eq!(table.colour(&texel, [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]), [0.0; 3]);
        let glossy = BaseTexel { gloss: 0.5, ..texel };
        assert!(table.colour(&glossy, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0])[0] > 2.0);
    }

    /// Compares positions of entries with angles in double precision.
    #[test]
    fn places_are_angles() {
        for (half, difference) in [(0.02f64, 0.0f64), (0.3, 0.4), (1.0, 0.2), (0.0, 1.2)] {
            let polar = |angle: f64| [angle.sin() as f32, 0.0, angle.cos() as f32];
            let across = difference.sin() as f32;
            // A pair around the half vector, across the plane of normal and half vector.
            let pair = |sign: f32| {
                let [x, _, z] = polar(half).map(|c| c * difference.cos() as f32);
                [x, sign * across, z]
            };
            let angles = BaseAngles::new(Axis::Half, [0.0, 0.0, 1.0], pair(1.0), pair(-1.0)).unwrap();
            let found = |of: fn(usize) -> usize| {
                angles.taps.iter().map(|(at, weight)| of(*at) as f64 * f64::from(*weight)).sum::<f64>()
            };
            let expected = 47.0 * (1.0 - half.cos()).powf(0.25);
            assert!((found(|at| at / DIFFERENCE_ANGLES) - expected).abs() < 2e-2, "{half}: {expected}");
            assert!((found(|at| at % DIFFERENCE_ANGLES) - 7.0 * (1.0 - difference.cos())).abs() < 1e-3);
        }
    }

    #[test]
    fn tables_out_of_range_are_rejected() {
        let mut entries = vec![[0.5; 3]; HALF_ANGLES * DIFFERENCE_ANGLES];
        assert!(BaseTable::new(entries[1..].to_vec()).is_err());
        for number in [f32::NAN, f32::INFINITY, -0.1, 7e4] {
            entries[19][1] = number;
            let rejected = BaseTable::new(entries.clone()).unwrap_err().to_string();
            assert!(rejected.contains("entry (2, 3) of the base"), "{rejected}");
        }
    }

    proptest! {
        #[test]
        fn normals_round_trip(x in -1.0f32..1.0, y in -1.0f32..1.0, z in -0.8f32..1.0) {
            prop_assume!(x * x + y * y + z * z > 0.01);
            let normal = unit([x, y, z]);
            prop_assume!(normal[2] > -0.85);
            let bytes = slope_words(normal).map(|word| [word >> 8, word & 255]).concat();
            let number = |k: usize| slope_ranges()[k].low + slope_ranges()[k].scale * f32::from(bytes[k]) / 255.0;
            let numbers = [0.0, 0.0, 0.0, 0.0, number(0), number(1), number(2), number(3)];
            let found = base_texel(TablePlace::default(), numbers).normal;
            for k in 0..3 {
                prop_assert!((found[k] - normal[k]).abs() < 2e-4, "{normal:?} {found:?}");
            }
        }

        /// The base is finite for any file contents and at the ends of filters.
        #[test]
        fn bases_are_numbers(numbers in prop::array::uniform8(prop::num::f32::NORMAL | prop::num::f32::INFINITE | prop::num::f32::ZERO)) {
            let texel = base_texel(TablePlace::default(), numbers);
            let table = BaseTable::new(vec![[MAX_ENTRY; 3]; HALF_ANGLES * DIFFERENCE_ANGLES]).unwrap();
            let colour = table.colour(&texel, [0.0, 0.6, 0.8], [0.28, 0.0, 0.96]);
            prop_assert!(colour.iter().all(|c| (0.0..=MAX_BASE).contains(c)), "{texel:?} {colour:?}");
        }
    }
}
