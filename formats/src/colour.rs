//! Spectra to linear RGB.
