//! Spectra to linear RGB.
use crate::FormatError;
/// stub, replaced by the models branch
pub fn rgb_weights(w: &[f64]) -> Result<Vec<[f64; 3]>, FormatError> {
    Ok(vec![[1.0 / w.len() as f64; 3]; w.len()])
}
