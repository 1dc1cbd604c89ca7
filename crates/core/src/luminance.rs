//! Luminance of linear RGB.

/// Weights of linear RGB in relative luminance (Rec. 709).
pub const LUMINANCE_WEIGHTS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Relative luminance of linear RGB.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    let [r, g, b] = LUMINANCE_WEIGHTS;
    r * rgb[0] + g * rgb[1] + b * rgb[2]
}
