//! Decoded samples.

use brdfc_formats::FormatError;
use brdfc_formats::memory::reserved;

/// Type of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    U8,
    U16,
    F32,
}

/// Interleaved samples, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Raster {
    pub size: [usize; 2],
    /// 1 to 4; the second or fourth is alpha.
    pub channels: usize,
    pub samples: Samples,
}

/// Samples as stored; integers over their whole range.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// Elements of an iterator of known length.
///
/// # Errors
/// Returns an error if there is not enough memory.
pub(crate) fn collected<T>(values: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, FormatError> {
    let mut all = reserved("pixels", values.len())?;
    all.extend(values);
    Ok(all)
}
