//! The curve of a factored pack: what of the logarithm depends on `θ_h` alone, as the distribution of half vectors in a
//! microfacet model does. Finer than the table's columns, it keeps narrow highlights. Layout: `spec.md`.

use crate::FormatError;
use crate::container::{TexelFormat, half, rgb10a2};
use crate::cursor::Cursor;
use std::f32::consts::FRAC_PI_2;

/// The entry of a curve.
pub(super) const CURVE_ENTRY: &str = "brdfc.table.curve";

/// Fewest and most nodes.
const NODES: std::ops::RangeInclusive<usize> = 2..=256;

/// A curve over `θ_h` that is added to the table: nodes stand at `θ_h = (k / (n - 1))² π/2`.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    span: [f32; 3],
    format: TexelFormat,
    texels: Vec<u8>,
}

impl Curve {
    /// A curve of values in `[0, 1]`, rounded to what texels of the table's format hold; `span` is what 1 adds to the
    /// logarithm.
    ///
    /// # Errors
    /// Fewer than 2 or more than 256 values, spans out of range.
    pub fn new(format: TexelFormat, span: [f32; 3], values: &[[f32; 3]]) -> Result<Self, FormatError> {
        let texels = packed(format, values.iter());
        let curve = Self { span, format, texels };
        curve.check()?;
        Ok(curve)
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.texels.len() / self.format.texel_bytes()
    }

    /// What a texel of 1 adds to the logarithm, not negative.
    pub fn span(&self) -> [f32; 3] {
        self.span
    }

    /// The texture's bytes: one row.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }

    /// Values in `[0, 1]`, grey ones three times.
    pub fn values(&self) -> Vec<[f32; 3]> {
        unpacked(self.format, &self.texels)
    }

    /// Where `θ_h` is, in units of nodes.
    pub fn position(nodes: usize, theta_half: f32) -> f32 {
        (theta_half / FRAC_PI_2).min(1.0).sqrt() * (nodes - 1) as f32
    }

    pub(super) fn check_format(&self, table: TexelFormat) -> Result<(), FormatError> {
        if self.format == table {
            return Ok(());
        }
        Err(FormatError::whole(CURVE_ENTRY, format!("{:?}", self.format), format!("{table:?}, as the table has")))
    }

    fn check(&self) -> Result<(), FormatError> {
        let refused = |field: &str, found: String, allowed: &str| {
            Err(FormatError::whole(format!("{CURVE_ENTRY} {field}"), found, allowed))
        };
        if !NODES.contains(&self.nodes()) {
            return refused("nodes", self.nodes().to_string(), "2 to 256");
        }
        if let Some(span) = self.span.into_iter().find(|span| !(0.0..=f32::MAX).contains(span)) {
            return refused("span", span.to_string(), "a number that is not negative");
        }
        if let Some([value, ..]) = self.values().into_iter().find(|value| !(0.0..=1.0).contains(&value[0])) {
            return refused("texel", value.to_string(), "0 to 1");
        }
        Ok(())
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let span = self.span.map(f32::to_le_bytes).concat();
        [&(self.nodes() as u32).to_le_bytes()[..], &span, &self.texels].concat()
    }

    pub(super) fn from_bytes(bytes: &[u8], format: TexelFormat) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(bytes);
        let nodes = cursor.u32(CURVE_ENTRY)? as usize;
        let mut span = [0.0; 3];
        for span in &mut span {
            *span = cursor.f32(CURVE_ENTRY)?;
        }
        let texels = bytes[16..].to_vec();
        if Some(texels.len()) != nodes.checked_mul(format.texel_bytes()) {
            let allowed = format!("{nodes} nodes of {} bytes, as it says", format.texel_bytes());
            return Err(FormatError::whole(CURVE_ENTRY, format!("{} bytes of texels", texels.len()), allowed));
        }
        let curve = Self { span, format, texels };
        curve.check()?;
        Ok(curve)
    }
}

/// Texels of values in `[0, 1]`.
pub(super) fn packed<'a>(format: TexelFormat, values: impl Iterator<Item = &'a [f32; 3]>) -> Vec<u8> {
    match format {
        TexelFormat::R16Float => {
            values.flat_map(|value| half::encode(value[0].clamp(0.0, 1.0)).to_le_bytes()).collect()
        }
        _ => values.flat_map(|value| rgb10a2::encode(*value).to_le_bytes()).collect(),
    }
}

/// Values of texels, grey ones three times.
pub(super) fn unpacked(format: TexelFormat, texels: &[u8]) -> Vec<[f32; 3]> {
    match format {
        TexelFormat::R16Float => {
            texels.as_chunks::<2>().0.iter().map(|bytes| [half::decode(u16::from_le_bytes(*bytes)); 3]).collect()
        }
        _ => texels.as_chunks::<4>().0.iter().map(|bytes| rgb10a2::decode(u32::from_le_bytes(*bytes))).collect(),
    }
}
