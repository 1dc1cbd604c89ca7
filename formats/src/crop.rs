//! Range of directions that a pack covers, and the part of its texture that it stores.
//!
//! A pack for a scene with a limited range of directions need not store the others. Its cell or node counts remain
//! as in the full grid, and so do positions in the grid; a *window* gives the part that the texture holds. Look-ups
//! outside the window return the nearest value inside. Stored under `brdfc.crop` in table and wavelet packs:
//! `formats/src/container/spec.md`.

use crate::FormatError;
use crate::container::Texture;
use crate::container::entries::sized;
use crate::cursor::Cursor;
use crate::direction::{DirectionPair, Vector};

const CROP: &str = "brdfc.crop";

/// A range of elevations: angles above the surface, degrees, `0 <= from < to <= 90`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct Elevations {
    /// Lowest elevation above the surface, degrees.
    pub from: f32,
    /// Highest elevation above the surface, degrees.
    pub to: f32,
}

impl Elevations {
    /// From the horizon to the normal.
    pub const ALL: Self = Self { from: 0.0, to: 90.0 };

    /// Returns true if a unit vector is in the range, with a tolerance of 1e-5 so that rounding does not exclude an
    /// end.
    pub fn contain(self, direction: Vector) -> bool {
        let [low, high] = self.sines();
        (low - 1e-5..=high + 1e-5).contains(&direction[2])
    }

    /// Sines of both ends, which are z coordinates of unit vectors.
    pub fn sines(self) -> [f64; 2] {
        [self.from, self.to].map(|angle| f64::from(angle).to_radians().sin())
    }

    /// Angles to the normal, radians: the smallest and the largest.
    pub fn polar(self) -> [f64; 2] {
        [90.0 - self.to, 90.0 - self.from].map(|angle| f64::from(angle).to_radians())
    }

    /// Smallest range that contains both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { from: self.from.min(other.from), to: self.to.max(other.to) }
    }

    /// Returns true if `0 <= from < to <= 90`.
    pub fn is_valid(self) -> bool {
        0.0 <= self.from && self.from < self.to && self.to <= 90.0
    }
}

impl Default for Elevations {
    fn default() -> Self {
        Self::ALL
    }
}

/// Formats the range as `20° to 90°`.
impl std::fmt::Display for Elevations {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}° to {}°", self.from, self.to)
    }
}

/// Directions that a pack covers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct DirectionRange {
    /// Elevations of the directions to the light.
    pub light: Elevations,
    /// Elevations of the directions to the viewer.
    pub view: Elevations,
}

impl DirectionRange {
    /// All directions above the horizon.
    pub const ALL: Self = Self { light: Elevations::ALL, view: Elevations::ALL };

    /// Returns true if both directions of a pair are in range.
    pub fn contains(self, pair: DirectionPair) -> bool {
        self.light.contain(pair.incoming) && self.view.contain(pair.outgoing)
    }

    /// Returns true if the range covers all directions.
    pub fn is_all(self) -> bool {
        self == Self::ALL
    }

    /// Intersection of both ranges, or `None` if it is empty.
    pub fn common(self, other: Self) -> Option<Self> {
        let both = |a: Elevations, b: Elevations| Elevations { from: a.from.max(b.from), to: a.to.min(b.to) };
        let common = Self { light: both(self.light, other.light), view: both(self.view, other.view) };
        (common.light.is_valid() && common.view.is_valid()).then_some(common)
    }

    /// Smallest range that contains both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { light: self.light.with(other.light), view: self.view.with(other.view) }
    }
}

/// Formats the range as `light from 0° to 60°, seen from 20° to 90°`.
impl std::fmt::Display for DirectionRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "light from {}, seen from {}", self.light, self.view)
    }
}

/// Rectangle of a texture's first two axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// First stored column and row.
    pub first: [u32; 2],
    /// Number of stored columns and rows.
    pub size: [u32; 2],
}

impl Window {
    /// Window that covers a texture of `size`.
    pub fn whole(size: [u32; 2]) -> Self {
        Self { first: [0, 0], size }
    }

    /// Window from the first to the last column and row, inclusive.
    pub fn between(first: [u32; 2], last: [u32; 2]) -> Self {
        Self { first, size: [last[0] - first[0] + 1, last[1] - first[1] + 1] }
    }

    /// Bytes of the window, one row at a time, from the texels of a slice with `columns` columns.
    pub(crate) fn cut(self, texels: &[u8], columns: u32, texel_bytes: usize) -> impl Iterator<Item = &[u8]> {
        let [first_column, first_row] = self.first.map(|n| n as usize);
        let [width, height] = self.size.map(|n| n as usize);
        (first_row..first_row + height).map(move |row| {
            let start = (row * columns as usize + first_column) * texel_bytes;
            &texels[start..start + width * texel_bytes]
        })
    }

    /// Returns true if the window has at least `fewest` columns and rows and lies within a texture of `whole` texels.
    fn is_within(self, whole: [u32; 2], fewest: u32) -> bool {
        (0..2).all(|axis| {
            self.size[axis] >= fewest
                && self.first[axis].checked_add(self.size[axis]).is_some_and(|end| end <= whole[axis])
        })
    }
}

/// Directions that a pack covers and the part of its texture that it stores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crop {
    /// Directions that the pack covers.
    pub directions: DirectionRange,
    /// Stored part of the texture.
    pub window: Window,
}

impl Crop {
    /// Checks the elevations, and that the window has at least `fewest` columns and rows within a texture of `whole`
    /// texels.
    ///
    /// # Errors
    /// Returns an error that names the value out of range.
    pub fn check(&self, whole: [u32; 2], fewest: u32) -> Result<(), FormatError> {
        for (range, field) in [(self.directions.light, "light"), (self.directions.view, "view")] {
            if !range.is_valid() {
                let allowed = "rising elevations from 0 to 90 degrees";
                return Err(FormatError::whole(format!("{CROP} {field}"), range.to_string(), allowed));
            }
        }
        if !self.window.is_within(whole, fewest) {
            let Window { first: [column, row], size: [columns, rows] } = self.window;
            return Err(FormatError::whole(
                format!("{CROP} window"),
                format!("{columns} x {rows} from {column}, {row} on"),
                format!("{fewest} x {fewest} or more, within {} x {}", whole[0], whole[1]),
            ));
        }
        Ok(())
    }

    /// Key and value for a file.
    pub(crate) fn entry(&self) -> (String, Vec<u8>) {
        let Self { directions: DirectionRange { light, view }, window } = self;
        let numbers = [light.from, light.to, view.from, view.to].map(f32::to_bits);
        let words = window.first.into_iter().chain(window.size).chain(numbers);
        (CROP.to_owned(), words.flat_map(u32::to_le_bytes).collect())
    }

    /// Reads the crop of a texture, if it has one.
    pub(crate) fn of(texture: &Texture, whole: [u32; 2], fewest: u32) -> Result<Option<Self>, FormatError> {
        let Some(bytes) = texture.entries.get(CROP) else { return Ok(None) };
        let mut cursor = Cursor::new(sized(bytes, CROP, 32)?);
        let [first_column, first_row, columns, rows] =
            [cursor.u32(CROP)?, cursor.u32(CROP)?, cursor.u32(CROP)?, cursor.u32(CROP)?];
        let [light_from, light_to, view_from, view_to] =
            [cursor.f32(CROP)?, cursor.f32(CROP)?, cursor.f32(CROP)?, cursor.f32(CROP)?];
        let crop = Self {
            directions: DirectionRange {
                light: Elevations { from: light_from, to: light_to },
                view: Elevations { from: view_from, to: view_to },
            },
            window: Window { first: [first_column, first_row], size: [columns, rows] },
        };
        crop.check(whole, fewest)?;
        Ok(Some(crop))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::from_polar;

    #[test]
    fn elevations_are_above_the_surface() {
        let low = Elevations { from: 0.0, to: 30.0 };
        let at = |elevation: f64| from_polar((90.0 - elevation).to_radians(), 0.7);
        for (elevation, within) in [(0.0, true), (29.9, true), (30.0, true), (30.1, false), (90.0, false)] {
            assert_eq!(low.contain(at(elevation)), within, "{elevation}");
        }
        let polar = low.polar().map(f64::to_degrees);
        assert!((polar[0] - 60.0).abs() < 1e-9 && (polar[1] - 90.0).abs() < 1e-9, "{polar:?}");
        let both = low.with(Elevations { from: 50.0, to: 60.0 });
        assert_eq!(both, Elevations { from: 0.0, to: 60.0 });
        let range = DirectionRange { light: low, view: Elevations::ALL };
        assert!(range.contains(DirectionPair::new(at(10.0), at(80.0))));
        assert!(!range.contains(DirectionPair::new(at(80.0), at(10.0))));
        assert!(DirectionRange::default().is_all() && !range.is_all());
    }

    #[test]
    fn errors_name_the_value_out_of_range() {
        let good = Crop { directions: DirectionRange::ALL, window: Window { first: [1, 2], size: [3, 2] } };
        assert!(good.check([4, 4], 2).is_ok());
        let field = |crop: Crop| crop.check([4, 4], 2).unwrap_err().field;
        let falling = Elevations { from: 40.0, to: 40.0 };
        let not_a_number = Elevations { from: f32::NAN, to: 40.0 };
        assert_eq!(
            field(Crop { directions: DirectionRange { light: falling, ..DirectionRange::ALL }, ..good }),
            "brdfc.crop light"
        );
        assert_eq!(
            field(Crop { directions: DirectionRange { view: not_a_number, ..DirectionRange::ALL }, ..good }),
            "brdfc.crop view"
        );
        for window in [
            Window { first: [2, 2], size: [3, 2] },
            Window { first: [0, 0], size: [1, 2] },
            Window { first: [u32::MAX, 0], size: [2, 2] },
        ] {
            assert_eq!(field(Crop { window, ..good }), "brdfc.crop window");
        }
    }
}
