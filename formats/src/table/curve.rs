//! The curve of a factored pack: what of the logarithm depends on `θ_h` alone, as the distribution of half vectors in a
//! microfacet model does. Finer than the table's columns, it keeps narrow highlights. Layout: `spec.md`.

use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture, half};
use std::f32::consts::FRAC_PI_2;

/// The binding of a curve.
pub(super) const CURVE: &str = "table_brdf_curve";

/// Fewest and most nodes.
const NODES: std::ops::RangeInclusive<usize> = 2..=256;
/// Most levels of detail besides the finest.
const MAX_LEVELS: u32 = 15;

/// A curve over `θ_h` that is added to the table: logarithms at nodes that stand at `θ_h = (k / (n - 1))² π/2`. A row for
/// each level of detail, the finest first. Halves are finest near 0, where a table's curve has what is seen most.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    levels: u32,
    format: TexelFormat,
    texels: Vec<u8>,
}

impl Curve {
    /// A curve for a pack of 1 or 3 channels, of finite values that are rounded to halves: `[row][node]`, a row for the
    /// finest level of detail and for each of `levels` coarser ones.
    ///
    /// # Errors
    /// Fewer than 2 or more than 256 nodes, more than 15 levels, rows of different lengths, values that no half holds.
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

    /// How texels are stored: one half, or four, of which the last is 1.
    pub fn texel_format(&self) -> TexelFormat {
        self.format
    }

    /// How many nodes a row has.
    pub fn nodes(&self) -> usize {
        self.texels.len() / self.format.texel_bytes() / (self.levels as usize + 1)
    }

    /// Levels of detail besides the finest; there is a row more.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The texture's bytes: rows from the finest level on.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }

    /// What is added to the logarithm, grey ones three times: `[row][node]`.
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

    /// Where `θ_h` is, in units of nodes.
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
        let refused = |field: &str, found: String, allowed: &str| {
            Err(FormatError::whole(format!("{CURVE} {field}"), found, allowed))
        };
        FormatError::check_range(format!("{CURVE} levels"), self.levels, 0..=MAX_LEVELS)?;
        let row = self.format.texel_bytes() * (self.levels as usize + 1);
        if !self.texels.len().is_multiple_of(row) {
            return refused("rows", format!("{} bytes", self.texels.len()), "rows of one length");
        }
        FormatError::check_range(format!("{CURVE} nodes"), self.nodes(), NODES)?;
        if let Some(value) = self.values().into_iter().flatten().find(|value| !value.is_finite()) {
            return refused("texel", value.to_string(), "a number");
        }
        Ok(())
    }

    /// Nodes, and rows.
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
