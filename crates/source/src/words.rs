//! Numbers as people read them.

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

/// Bytes with a binary unit.
pub fn bytes(count: u64) -> String {
    match count {
        0..1024 => format!("{count} B"),
        1024..1_048_576 => format!("{:.1} KiB", count as f64 / 1024.0),
        _ => format!("{:.2} MiB", count as f64 / 1_048_576.0),
    }
}
