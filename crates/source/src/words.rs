//! Numbers as people read them.

pub use brdfc_formats::memory::in_words as bytes;

/// A fraction as per cent with enough digits.
pub fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    if value >= 1e5 {
        format!("{value:.2e} %")
    } else if value >= 0.01 || value == 0.0 {
        format!("{value:.3} %")
    } else {
        format!("{value:.1e} %")
    }
}
