//! Dimension, size and mipmap levels of textures.

use crate::FormatError;
use std::fmt;

/// Orientation of a 3D texture, as `KTXorientation` value: x right, y down, z inwards.
pub const ORIENTATION_3D: &str = "rdi";
/// Orientation of 2D textures and their arrays: x right, y down.
pub const ORIENTATION_2D: &str = "rd";
/// Faces of a cube map.
pub const CUBE_FACES: u32 = 6;
/// Maximum texels along an axis of a 3D texture, WebGPU's default limit, and of a face of a cube map, WebGL 2's guarantee.
pub const MAX_EXTENT: u32 = 2048;
/// Maximum texels along an axis of a 2D texture: WebGPU's default limit.
pub const MAX_EXTENT_2D: u32 = 8192;
/// Maximum layers of a 2D array, as desktop drivers support. WebGPU guarantees 256.
pub const MAX_LAYERS: u32 = 2048;
/// Dimension and size of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// A 2D texture: width and height, each 1 to [`MAX_EXTENT_2D`].
    D2([u32; 2]),
    /// An array of 2D textures: width and height, each 1 to [`MAX_EXTENT_2D`], and 1 to [`MAX_LAYERS`] layers.
    D2Array([u32; 3]),
    /// A 3D texture: width, height and depth, each 1 to [`MAX_EXTENT`].
    D3([u32; 3]),
    /// A cube map: texels along each side of its six faces, 1 to [`MAX_EXTENT`].
    Cube(u32),
}

impl Extent {
    /// Columns, rows, and slices, layers or faces (1 for a 2D texture).
    pub fn size(self) -> [u32; 3] {
        match self {
            Self::D2([width, height]) => [width, height, 1],
            Self::D2Array(size) | Self::D3(size) => size,
            Self::Cube(side) => [side, side, CUBE_FACES],
        }
    }

    /// WebGPU name of the view dimension: `2d`, `2d-array`, `3d` or `cube`.
    pub fn dimension(self) -> &'static str {
        match self {
            Self::D2(_) => "2d",
            Self::D2Array(_) => "2d-array",
            Self::D3(_) => "3d",
            Self::Cube(_) => "cube",
        }
    }

    /// Extent with this [`Self::dimension`] and [`Self::size`], or `None` if packs cannot have it.
    pub fn from_dimension(dimension: &str, [width, height, depth]: [u32; 3]) -> Option<Self> {
        let extent = match dimension {
            "2d" if depth == 1 => Self::D2([width, height]),
            "2d-array" => Self::D2Array([width, height, depth]),
            "3d" => Self::D3([width, height, depth]),
            "cube" if height == width && depth == CUBE_FACES => Self::Cube(width),
            _ => return None,
        };
        // A depth of 0 reads as another dimension.
        (Self::from_fields(extent.fields()) == Ok(extent)).then_some(extent)
    }

    /// Number of texels over all axes, layers and faces.
    pub fn texels(self) -> u64 {
        self.size().into_iter().map(u64::from).product()
    }

    /// Extent of a mipmap level, 0 the finest: each side is halved `level` times, rounded down, at least 1.
    pub fn level(self, level: u32) -> Self {
        let side = |side: u32| side.checked_shr(level).unwrap_or(0).max(1);
        match self {
            Self::D2(sides) => Self::D2(sides.map(side)),
            Self::D2Array([width, height, layers]) => Self::D2Array([side(width), side(height), layers]),
            Self::D3(sides) => Self::D3(sides.map(side)),
            Self::Cube(length) => Self::Cube(side(length)),
        }
    }

    /// Number of mipmap levels down to a single texel.
    pub fn most_levels(self) -> u32 {
        let largest = match self {
            Self::D2(sides) => sides.into_iter().max(),
            Self::D2Array([width, height, _]) => Some(width.max(height)),
            Self::D3(sides) => sides.into_iter().max(),
            Self::Cube(side) => Some(side),
        };
        largest.unwrap_or(1).max(1).ilog2() + 1
    }

    /// Total number of texels in the finest `levels` levels.
    pub fn texels_of_levels(self, levels: u32) -> u64 {
        (0..levels).map(|level| self.level(level).texels()).sum()
    }

    /// Width, height, depth, layer and face count as in the KTX2 header; depth and layer count are 0 if they do not apply.
    pub(super) fn fields(self) -> [u32; 5] {
        match self {
            Self::D2([width, height]) => [width, height, 0, 0, 1],
            Self::D2Array([width, height, layers]) => [width, height, 0, layers, 1],
            Self::D3([width, height, depth]) => [width, height, depth, 0, 1],
            Self::Cube(side) => [side, side, 0, 0, CUBE_FACES],
        }
    }

    pub(super) fn from_fields(fields: [u32; 5]) -> Result<Self, FormatError> {
        let [width, height, depth, layers, faces] = fields;
        let wrong = |axis: usize, field: &'static str, allowed: String| {
            Err(FormatError::at_byte(20 + 4 * axis as u64, field, fields[axis].to_string(), allowed))
        };
        if faces == CUBE_FACES {
            return match [width, height, depth, layers] {
                [side, ..] if !(1..=MAX_EXTENT).contains(&side) => {
                    wrong(0, "pixelWidth", format!("1 to {MAX_EXTENT} for a cube map"))
                }
                [side, height, ..] if side != height => {
                    wrong(1, "pixelHeight", format!("{side}, the pixelWidth of a cube map"))
                }
                [_, _, depth, _] if depth > 0 => wrong(2, "pixelDepth", "0 for a cube map".to_owned()),
                [.., layers] if layers > 0 => wrong(3, "layerCount", "0 for a cube map".to_owned()),
                _ => Ok(Self::Cube(width)),
            };
        }
        if faces != 1 {
            return wrong(4, "faceCount", format!("1, or {CUBE_FACES} for a cube map"));
        }
        let side = if depth == 0 { MAX_EXTENT_2D } else { MAX_EXTENT };
        for (axis, (field, range)) in [
            ("pixelWidth", 1..=side),
            ("pixelHeight", 1..=side),
            ("pixelDepth", 0..=MAX_EXTENT),
            // KTX2 allows arrays of 3D textures, but hardly any reader supports them.
            ("layerCount", 0..=if depth == 0 { MAX_LAYERS } else { 0 }),
        ]
        .into_iter()
        .enumerate()
        {
            if !range.contains(&fields[axis]) {
                let (first, last) = (range.start(), range.end());
                let allowed = if first == last { first.to_string() } else { format!("{first} to {last}") };
                return wrong(axis, field, allowed);
            }
        }
        Ok(match (depth, layers) {
            (0, 0) => Self::D2([width, height]),
            (0, _) => Self::D2Array([width, height, layers]),
            _ => Self::D3([width, height, depth]),
        })
    }

    pub(super) fn orientation(self) -> &'static str {
        match self {
            Self::D2(_) | Self::D2Array(_) | Self::Cube(_) => ORIENTATION_2D,
            Self::D3(_) => ORIENTATION_3D,
        }
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::D2([width, height]) => write!(f, "{width} x {height}"),
            Self::D2Array([width, height, layers]) => write!(f, "{layers} layers of {width} x {height}"),
            Self::D3([width, height, depth]) => write!(f, "{width} x {height} x {depth}"),
            Self::Cube(side) => write!(f, "{CUBE_FACES} faces of {side} x {side}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_halved_and_rounded_down() {
        let chain = |extent: Extent| -> Vec<Extent> { (0..extent.most_levels()).map(|n| extent.level(n)).collect() };
        let flat = [[7, 5], [3, 2], [1, 1]];
        assert_eq!(chain(Extent::D2([7, 5])), flat.map(Extent::D2));
        // All levels have the same number of layers.
        assert_eq!(chain(Extent::D2Array([7, 5, 9])), flat.map(|[width, height]| Extent::D2Array([width, height, 9])));
        // Depth is halved, and may be the largest side.
        assert_eq!(chain(Extent::D3([2, 1, 8])), [[2, 1, 8], [1, 1, 4], [1, 1, 2], [1, 1, 1]].map(Extent::D3));
        assert_eq!(chain(Extent::D2([1, 4])), [[1, 4], [1, 2], [1, 1]].map(Extent::D2));
        assert_eq!(chain(Extent::D2Array([1, 1, 5])), [Extent::D2Array([1, 1, 5])]);
        assert_eq!(chain(Extent::Cube(4)), [4, 2, 1].map(Extent::Cube));
    }

    #[test]
    fn dimensions_have_sizes_within_limits() {
        let largest =
            [Extent::D2([8192, 1]), Extent::D2Array([3, 2, 2048]), Extent::D3([1, 2048, 1]), Extent::Cube(2048)];
        for extent in largest {
            assert_eq!(Extent::from_dimension(extent.dimension(), extent.size()), Some(extent));
        }
        for (dimension, size) in [
            ("2d", [4, 4, 2]),
            ("2d", [8193, 1, 1]),
            ("2d-array", [1, 1, 0]),
            ("2d-array", [1, 1, 2049]),
            ("3d", [1, 1, 0]),
            ("3d", [2049, 1, 1]),
            ("3d", [u32::MAX; 3]),
            ("cube", [4, 2, 6]),
            ("cube", [4, 4, 1]),
            ("cube", [0, 0, 6]),
            ("cube", [2049, 2049, 6]),
            ("1d", [1; 3]),
        ] {
            assert_eq!(Extent::from_dimension(dimension, size), None, "{dimension} {size:?}");
        }
    }

    #[test]
    fn levels_end_at_a_single_texel() {
        for (side, levels) in [(1, 1), (2, 2), (3, 2), (4, 3), (255, 8), (256, 9), (8191, 13), (8192, 14)] {
            for extent in [Extent::D2([side, 1]), Extent::D2([1, side]), Extent::D2Array([side, 1, 64])] {
                assert_eq!(extent.most_levels(), levels, "{extent}");
            }
            assert_eq!(Extent::D3([1, 1, side]).most_levels(), levels);
        }
        // Levels beyond the last stay there, even past the bits of a side.
        for level in [3, 31, 32, u32::MAX] {
            assert_eq!(Extent::D3([7, 5, 4]).level(level), Extent::D3([1, 1, 1]), "{level}");
        }
    }

    #[test]
    fn texels_of_levels_are_added() {
        assert_eq!(Extent::D2([7, 5]).texels_of_levels(1), 35);
        assert_eq!(Extent::D2([7, 5]).texels_of_levels(3), 35 + 6 + 1);
        assert_eq!(Extent::D2Array([7, 5, 9]).texels_of_levels(3), 9 * (35 + 6 + 1));
        assert_eq!(Extent::D3([4, 4, 4]).texels_of_levels(3), 64 + 8 + 1);
        assert_eq!(Extent::Cube(4).texels_of_levels(3), 6 * (16 + 4 + 1));
        // The largest extent does not overflow.
        let largest = Extent::D2Array([MAX_EXTENT_2D, MAX_EXTENT_2D, MAX_LAYERS]);
        assert_eq!(largest.texels_of_levels(14), u64::from(MAX_LAYERS) * ((1 << 28) - 1) / 3);
    }
}
