//! Header of a table pack: sizes, symmetry, node positions, range of texels. Layout: `spec.md`.

use super::coordinates::{Angles, Folded, Position, TableSymmetry};
use crate::FormatError;
use crate::container::entries::sized;
use crate::container::{MAX_EXTENT, TexelFormat};
use crate::cursor::Cursor;
use crate::direction::DirectionPair;

/// Key that identifies a table pack.
pub(super) const TABLE_ENTRY: &str = "brdfc.table";

const VERSION: u32 = 1;

/// Number of knots of the warp of `θ_h`, equally spaced in the square root of the angle.
pub const KNOTS: usize = 17;

/// Size of the uniform block, bytes, including the sizes of the curve.
pub(super) const UNIFORM_BYTES: usize = 144;

/// Number of nodes along each axis of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct Axes {
    /// Along `θ_h`, 2 to 256.
    pub half: u32,
    /// Along `θ_d`, 2 to 256.
    pub difference: u32,
    /// Along `φ_d`, 2 to 256.
    pub azimuth: u32,
    /// Along `φ_h`, 1 (isotropic materials) to 256.
    pub layers: u32,
}

/// Formats columns, rows and slices, and layers if there are several: `24x13x12`.
impl std::fmt::Display for Axes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { half, difference, azimuth, layers } = self;
        write!(f, "{half}x{difference}x{azimuth}")?;
        if *layers == 1 { Ok(()) } else { write!(f, "x{layers}") }
    }
}

/// Sizes and constants of a table pack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableHeader {
    /// 1 (grey) or 3 (linear RGB).
    pub channels: u32,
    /// Symmetry by which pairs share nodes.
    pub symmetry: TableSymmetry,
    /// Number of nodes along each axis.
    pub axes: Axes,
    /// `μ` of the logarithms, 1/sr, positive.
    pub mean: f32,
    /// `ε` of the logarithms, positive.
    pub bias: f32,
    /// `ln(f / μ + ε)` of a texel value of 0.
    pub low: [f32; 3],
    /// Difference between a texel value of 1 and `low`, not negative.
    pub span: [f32; 3],
    /// Change of row density from `θ_d = 0` to its maximum: `row ∝ t (1 + slope (1 - t))`, -0.95 to 0.95.
    pub slope: f32,
    /// Column positions: fraction of columns below `θ_h = (k / 16)² π/2`, rising from 0 to 1.
    pub knots: [f32; KNOTS],
}

impl TableHeader {
    /// Slices of a layer. If `φ_d` is periodic, a copy of the first slice follows the last.
    pub fn slices(&self) -> u32 {
        self.axes.azimuth + u32::from(!self.symmetry.mirror)
    }

    /// Size of the texture of an uncropped pack.
    pub fn extent(&self) -> [u32; 3] {
        [self.axes.half, self.axes.difference, self.slices() * self.axes.layers]
    }

    /// Number of texels of an uncropped pack.
    pub fn texels(&self) -> usize {
        self.extent().into_iter().map(|n| n as usize).product()
    }

    /// Texel format: one half, or three components of 10 bits.
    pub fn texel_format(&self) -> TexelFormat {
        if self.channels == 1 { TexelFormat::R16Float } else { TexelFormat::Rgb10A2Unorm }
    }

    /// Returns true if the material is invariant under rotation about the normal.
    pub fn isotropic(&self) -> bool {
        self.axes.layers == 1
    }

    /// Filtered table fetches of one look-up.
    pub(super) fn fetches(&self) -> u32 {
        if self.isotropic() { 1 } else { 2 }
    }

    /// Angles of a pair above the horizon; isotropic tables ignore `φ_h`.
    pub(super) fn angles(&self, pair: DirectionPair) -> Angles {
        if self.isotropic() { Angles::but_phi_half(pair).0 } else { Angles::of(pair) }
    }

    /// Position of a pair above the horizon in the texture.
    pub fn position(&self, pair: DirectionPair) -> Position {
        self.position_of(self.angles(pair))
    }

    /// Position of these angles in the texture.
    pub fn position_of(&self, angles: Angles) -> Position {
        self.place(Folded::new(angles, self.symmetry))
    }

    /// Position of these angles, already folded by the table's symmetry, in the texture.
    #[inline]
    pub fn place(&self, folded: Folded) -> Position {
        let Folded { root, ratio, half_share, difference_share } = folded;
        let Axes { azimuth, layers, .. } = self.axes;
        let slices = if self.symmetry.mirror { azimuth - 1 } else { azimuth };
        let mut position = Position {
            column: self.column_share(root) * (self.axes.half - 1) as f32,
            row: ratio * (1.0 + self.slope * (1.0 - ratio)) * (self.axes.difference - 1) as f32,
            slice: difference_share * slices as f32,
            layers: [0, 0],
            layer_weight: 0.0,
        };
        if layers > 1 {
            let steps = if self.symmetry.reflected { layers - 1 } else { layers };
            let at = half_share * steps as f32;
            let lower = (at as u32).min(steps - 1);
            position.layers = [lower, (lower + 1) % layers];
            position.layer_weight = at - lower as f32;
        }
        position
    }

    /// Fraction of columns below the `θ_h` with this square root.
    #[inline]
    fn column_share(&self, root: f32) -> f32 {
        let at = root * (KNOTS - 1) as f32;
        let lower = (at as usize).min(KNOTS - 2);
        self.knots[lower] + (at - lower as f32) * (self.knots[lower + 1] - self.knots[lower])
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let rejected = |field: &str, found: String, allowed: &str| {
            Err(FormatError::whole(format!("{TABLE_ENTRY} {field}"), found, allowed))
        };
        if self.channels != 1 && self.channels != 3 {
            return rejected("channels", self.channels.to_string(), "1 or 3");
        }
        let Axes { half, difference, azimuth, layers } = self.axes;
        for (count, field) in [(half, "θ_h nodes"), (difference, "θ_d nodes"), (azimuth, "φ_d nodes")] {
            FormatError::check_range(format!("{TABLE_ENTRY} {field}"), count, 2..=256)?;
        }
        FormatError::check_range(format!("{TABLE_ENTRY} layers"), layers, 1..=256)?;
        if self.isotropic() && (self.symmetry.half_turn || self.symmetry.reflected) {
            return rejected("symmetry", self.symmetry.bits().to_string(), "0 to 3 with one layer");
        }
        if self.extent()[2] > MAX_EXTENT {
            return rejected("depth", self.extent()[2].to_string(), "1 to 2048, the limit of 3D textures");
        }
        for (value, field) in [(self.mean, "mean"), (self.bias, "bias")] {
            if !value.is_normal() || value < 0.0 {
                return rejected(field, value.to_string(), "a positive number");
            }
        }
        for (low, span) in self.low.into_iter().zip(self.span) {
            if !low.is_finite() {
                return rejected("low", low.to_string(), "a number");
            }
            if !(0.0..=f32::MAX).contains(&span) {
                return rejected("span", span.to_string(), "a non-negative number");
            }
        }
        FormatError::check_range(format!("{TABLE_ENTRY} slope"), self.slope, -0.95..=0.95)?;
        let rising = self.knots.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || self.knots[0] != 0.0 || self.knots[KNOTS - 1] != 1.0 {
            return rejected("knots", format!("{:?}", self.knots), "numbers rising from 0 to 1");
        }
        Ok(())
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let Axes { half, difference, azimuth, layers } = self.axes;
        let words = [VERSION, self.channels, self.symmetry.bits(), half, difference, azimuth, layers];
        let numbers = [self.mean, self.bias].into_iter().chain(self.low).chain(self.span).chain([self.slope]);
        let numbers = numbers.chain(self.knots).map(f32::to_bits);
        words.into_iter().chain(numbers).flat_map(u32::to_le_bytes).collect()
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(sized(bytes, TABLE_ENTRY, 4 * (16 + KNOTS))?);
        let rejected = |field: &str, found: u32, allowed: &str| {
            Err(FormatError::whole(format!("{TABLE_ENTRY} {field}"), found.to_string(), allowed))
        };
        let version = cursor.u32("version")?;
        if version != VERSION {
            return rejected("version", version, "1");
        }
        let channels = cursor.u32("channels")?;
        let bits = cursor.u32("symmetry")?;
        let Some(symmetry) = TableSymmetry::from_bits(bits) else { return rejected("symmetry", bits, "0 to 15") };
        let axes = Axes {
            half: cursor.u32("θ_h nodes")?,
            difference: cursor.u32("θ_d nodes")?,
            azimuth: cursor.u32("φ_d nodes")?,
            layers: cursor.u32("layers")?,
        };
        let mut numbers = [0.0; 9 + KNOTS];
        for number in &mut numbers {
            *number = cursor.f32("constants")?;
        }
        let [mean, bias, low_r, low_g, low_b, span_r, span_g, span_b, slope, knots @ ..] = numbers;
        let (low, span) = ([low_r, low_g, low_b], [span_r, span_g, span_b]);
        let header = Self { channels, symmetry, axes, mean, bias, low, span, slope, knots };
        header.check()?;
        Ok(header)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn header(slope: f32, symmetry: u32, layers: u32) -> TableHeader {
        let mut knots = std::array::from_fn(|k| (k as f32 / 16.0).powi(2));
        knots[KNOTS - 1] = 1.0;
        TableHeader {
            channels: 3,
            symmetry: TableSymmetry::from_bits(symmetry).unwrap(),
            axes: Axes { half: 9, difference: 5, azimuth: 4, layers },
            mean: 1.0,
            bias: 1e-4,
            low: [0.0; 3],
            span: [1.0; 3],
            slope,
            knots,
        }
    }

    /// Axis ends map to the first and the last node; known values lie between.
    #[test]
    fn positions_are_known() {
        let at = |header: TableHeader, theta_half: f32, ratio: f32, phi_difference: f32, phi_half: f32| {
            header.position_of(Angles { theta_half, phi_half, ratio, phi_difference })
        };
        let mirror = header(0.0, 2, 1);
        let first = at(mirror, 0.0, 0.0, 0.0, 0.0);
        assert_eq!([first.column, first.row, first.slice], [0.0; 3]);
        let last = at(mirror, FRAC_PI_2, 1.0, -std::f32::consts::PI, 0.0);
        assert_eq!([last.column, last.row, last.slice], [8.0, 4.0, 3.0]);
        // Knots that rise by squares undo the square root of the angle.
        let middle = at(mirror, 0.25 * FRAC_PI_2, 0.5, FRAC_PI_2, 0.0);
        assert!(
            (middle.column - 2.0).abs() < 1e-4 && (middle.row - 2.0).abs() < 1e-5 && (middle.slice - 1.5).abs() < 1e-5
        );
        // A slope moves rows, but not the ends.
        let sloped = at(header(0.5, 2, 1), 0.0, 0.5, 0.0, 0.0);
        assert!((sloped.row - 0.5 * 1.25 * 4.0).abs() < 1e-5, "{sloped:?}");
        assert_eq!(at(header(0.5, 2, 1), 0.0, 1.0, 0.0, 0.0).row, 4.0);
        // Without mirror symmetry the circle has four nodes and a copy of the first slice.
        let open = at(header(0.0, 0, 1), 0.0, 0.5, -FRAC_PI_2, 0.0);
        assert!((open.slice - 3.0).abs() < 1e-5 && header(0.0, 0, 1).slices() == 5);
        // Layers wrap around, or are clamped if they are reflected.
        let around = at(header(0.0, 0, 3), 0.3, 0.5, 0.0, -0.1);
        assert!(around.layers == [2, 0] && around.layer_weight > 0.9, "{around:?}");
        let reflected = at(header(0.0, 8, 3), 0.3, 0.5, 0.0, std::f32::consts::PI);
        assert!(reflected.layers == [1, 2] && (reflected.layer_weight - 1.0).abs() < 1e-5, "{reflected:?}");
    }

    #[test]
    fn ranges_are_checked() {
        assert!(header(0.0, 15, 3).check().is_ok());
        let changed = |change: &dyn Fn(&mut TableHeader)| {
            let mut header = header(0.0, 3, 1);
            change(&mut header);
            header.check().unwrap_err().field
        };
        assert_eq!(changed(&|h| h.axes.half = 1), "brdfc.table θ_h nodes");
        assert_eq!(changed(&|h| h.axes.azimuth = 257), "brdfc.table φ_d nodes");
        assert_eq!(changed(&|h| h.axes.layers = 0), "brdfc.table layers");
        assert_eq!(changed(&|h| h.axes = Axes { azimuth: 200, layers: 20, ..h.axes }), "brdfc.table depth");
        assert_eq!(changed(&|h| h.symmetry.half_turn = true), "brdfc.table symmetry");
        assert_eq!(changed(&|h| h.bias = 0.0), "brdfc.table bias");
        assert_eq!(changed(&|h| h.span[1] = f32::NAN), "brdfc.table span");
        assert_eq!(changed(&|h| h.slope = 1.0), "brdfc.table slope");
        assert_eq!(changed(&|h| h.knots[3] = h.knots[2]), "brdfc.table knots");
    }
}
