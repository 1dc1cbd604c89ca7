//! Error norms that a pack stores about itself, measured against the source when the pack was made.

use crate::FormatError;
use crate::cursor::Cursor;

/// Error norms of a pack against its source, measured when the pack was made. Ratios are fractions, not per cent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct ErrorSummary {
    /// Number of samples compared.
    pub samples: u32,
    /// RMS of `f' - f`, 1/sr.
    pub rms: f32,
    /// `ε_r`, mean of `|f' - f| / f` over samples with `f >= 1e-3 μ`.
    pub relative_mean: f32,
    /// 95th percentile of the same ratio.
    pub relative_p95: f32,
    /// 99th percentile of the same ratio.
    pub relative_p99: f32,
    /// Maximum of the same ratio.
    pub relative_max: f32,
    /// RMS of `ln f' - ln f` over the same samples.
    pub log_rms: f32,
    /// RMS of `ln(1 + f' cos θi) - ln(1 + f cos θi)` over all samples.
    pub cosine_log_rms: f32,
    /// Largest difference in directional albedo over all incoming angles.
    pub albedo_max_difference: f32,
    /// Mean of `|f'(i, o) - f'(o, i)| / f` of the pack: its deviation from reciprocity.
    pub reciprocity: f32,
}

impl ErrorSummary {
    /// Size in a KTX2 value, bytes: `samples`, then the ratios in field order.
    pub(crate) const BYTES: usize = 40;

    pub(crate) fn to_bytes(self) -> [u8; Self::BYTES] {
        let ratios = [
            self.rms,
            self.relative_mean,
            self.relative_p95,
            self.relative_p99,
            self.relative_max,
            self.log_rms,
            self.cosine_log_rms,
            self.albedo_max_difference,
            self.reciprocity,
        ];
        in_bytes(std::iter::once(self.samples).chain(ratios.map(f32::to_bits)))
    }

    /// Reads the value that [`Self::to_bytes`] wrote under `key`.
    pub(crate) fn from_bytes(bytes: &[u8], key: &'static str) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(bytes);
        let samples = cursor.u32(key)?;
        let [
            rms,
            relative_mean,
            relative_p95,
            relative_p99,
            relative_max,
            log_rms,
            cosine_log_rms,
            albedo_max_difference,
            reciprocity,
        ] = not_negative(&mut cursor, key)?;
        Ok(Self {
            samples,
            rms,
            relative_mean,
            relative_p95,
            relative_p99,
            relative_max,
            log_rms,
            cosine_log_rms,
            albedo_max_difference,
            reciprocity,
        })
    }
}

/// Colour differences between renderings of a pack and of its source, measured when the pack was made: ΔE (CIE76)
/// over the pixels of spheres under fixed lights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct RenderingSummary {
    /// Mean ΔE over the pixels.
    pub mean: f32,
    /// 95th percentile of ΔE over the pixels.
    pub p95: f32,
    /// Maximum ΔE over the pixels.
    pub max: f32,
}

impl RenderingSummary {
    /// Size in a KTX2 value, bytes.
    pub(crate) const BYTES: usize = 12;

    pub(crate) fn to_bytes(self) -> [u8; Self::BYTES] {
        in_bytes([self.mean, self.p95, self.max].map(f32::to_bits).into_iter())
    }

    pub(crate) fn from_bytes(bytes: &[u8], key: &'static str) -> Result<Self, FormatError> {
        let [mean, p95, max] = not_negative(&mut Cursor::new(bytes), key)?;
        Ok(Self { mean, p95, max })
    }
}

/// Little-endian words.
fn in_bytes<const N: usize>(words: impl Iterator<Item = u32>) -> [u8; N] {
    let mut bytes = [0; N];
    for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
        target.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

fn not_negative<const N: usize>(cursor: &mut Cursor<'_>, key: &'static str) -> Result<[f32; N], FormatError> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = cursor.f32(key)?;
        if !(0.0..=f32::MAX).contains(value) {
            return Err(FormatError::whole(key, value.to_string(), "non-negative numbers"));
        }
    }
    Ok(values)
}
