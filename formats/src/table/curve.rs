//! Curve of a factored table pack: the part of the logarithm that depends only on `θ_h`, like the distribution of half
//! vectors in a microfacet model. It is finer than the table's columns and preserves narrow highlights. Layout:
//! `spec.md`.

use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture, half};
use std::f32::consts::FRAC_PI_2;

/// Name of the binding.
pub(super) const CURVE: &str = "table_brdf_curve";

/// Range of the number of nodes.
const NODES: std::ops::RangeInclusive<usize> = 2..=256;
/// Maximum number of coarser levels of detail.
const MAX_LEVELS: u32 = 15;

/// Curve over `θ_h` that is added to the table: logarithms at nodes `θ_h = (k / (n - 1))² π/2`, one row per level of
/// detail, the finest first. Halves are most precise near 0, where curves have the values of bright highlights.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    levels: u32,
    format: TexelFormat,
    texels: Vec<u8>,
}

impl Curve {
    /// Curve for a pack with 1 or 3 channels. `values` are finite, `[row][node]`, and are rounded to halves. There is a
    /// row for the finest level of detail and for each of `levels` coarser ones.
    ///
    /// # Errors
    /// Returns an error if there are fewer than 2 or more than 256 nodes, more than 15 levels, rows of different
    /// lengths, or values beyond the range of halves.
    pub fn new(channels: u32, levels: u32, values: &[[f32; 3]]) -> Result<Self, FormatError> {
        let half = |value: f32| half::encode(value).to_le_bytes();
        let texels = match format(channels) {
            TexelFormat::R16Float => values.iter().flat_map(|value| half(value[0])).collect(),
            _ => values.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0].map(half)).flatten().collect(),
        };
        let curve = Self { levels, format: format(channels), texels };
        curve.check()?;
        Ok(curve)
    }

    /// Texel format: one half, or four with the last set to 1.
    pub fn texel_format(&self) -> TexelFormat {
        self.format
    }

    /// Number of nodes in a row.
    pub fn nodes(&self) -> usize {
        self.texels.len() / self.format.texel_bytes() / (self.levels as usize + 1)
    }

    /// Number of coarser levels of detail; there is one more row.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Bytes of the texture: rows from the finest level.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }

    /// Values added to the logarithm, `[row][node]`; grey values are repeated three times.
    pub fn values(&self) -> Vec<[f32; 3]> {
        let half = |bytes: [u8; 2]| half::decode(u16::from_le_bytes(bytes));
        match self.format {
            TexelFormat::R16Float => self.texels.as_chunks::<2>().0.iter().map(|bytes| [half(*bytes); 3]).collect(),
            _ => {
                let colour = |[r, g, b, _]: &[[u8; 2]; 4]| [*r, *g, *b].map(half);
                self.texels.as_chunks::<2>().0.as_chunks::<4>().0.iter().map(colour).collect()
            }
        }
    }

    /// Position of `θ_h` in nodes.
    pub fn position(nodes: usize, theta_half: f32) -> f32 {
        (theta_half / FRAC_PI_2).min(1.0).sqrt() * (nodes - 1) as f32
    }

    pub(super) fn check_channels(&self, channels: u32) -> Result<(), FormatError> {
        let of_table = format(channels);
        if self.format == of_table {
            return Ok(());
        }
        let allowed = format!("{of_table:?}, as a table of {channels} channels has");
        Err(FormatError::whole(CURVE, format!("{:?}", self.format), allowed))
    }

    fn check(&self) -> Result<(), FormatError> {
        let rejected = |field: &str, found: String, allowed: &str| {
            Err(FormatError::whole(format!("{CURVE} {field}"), found, allowed))
        };
        FormatError::check_range(format!("{CURVE} levels"), self.levels, 0..=MAX_LEVELS)?;
        let row = self.format.texel_bytes() * (self.levels as usize + 1);
        if !self.texels.len().is_multiple_of(row) {
            return rejected("rows", format!("{} bytes", self.texels.len()), "rows of one length");
        }
        FormatError::check_range(format!("{CURVE} nodes"), self.nodes(), NODES)?;
        if let Some(value) = self.values().into_iter().flatten().find(|value| !value.is_finite()) {
            return rejected("texel", value.to_string(), "a number");
        }
        Ok(())
    }

    /// Nodes by rows.
    pub(super) fn extent(&self) -> Extent {
        Extent::D2([self.nodes() as u32, self.levels + 1])
    }

    pub(super) fn from_texture(texture: Texture, channels: u32) -> Result<Self, FormatError> {
        let Extent::D2([_, rows]) = texture.extent else {
            return Err(FormatError::whole(CURVE, texture.extent.to_string(), "a 2D texture"));
        };
        let curve = Self { levels: rows.saturating_sub(1), format: texture.format, texels: texture.texels };
        curve.check_channels(channels)?;
        curve.check()?;
        Ok(curve)
    }
}

fn format(channels: u32) -> TexelFormat {
    if channels == 1 { TexelFormat::R16Float } else { TexelFormat::Rgba16Float }
}
