//! Fallible allocation for sizes that a file declares: running out of memory is a [`FormatError`], not an abort.

use crate::FormatError;

/// An empty vector with room for `count` elements.
///
/// # Errors
/// Returns an error if the allocation fails; `field` names the data that needs it.
pub fn reserved<T>(field: &'static str, count: usize) -> Result<Vec<T>, FormatError> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(count).map_err(|_| missing::<T>(field, count))?;
    Ok(vector)
}

/// A vector of `count` elements, all `value`.
///
/// # Errors
/// Returns an error if the allocation fails; `field` names the data that needs it.
pub fn filled<T: Clone>(field: &'static str, count: usize, value: T) -> Result<Vec<T>, FormatError> {
    let mut vector = reserved(field, count)?;
    vector.resize(count, value);
    Ok(vector)
}

/// Appends an element to a vector of at most `most` elements.
///
/// # Errors
/// Returns an error if the vector already has `most` elements, or as [`reserved`].
pub fn push_within<T>(vector: &mut Vec<T>, element: T, most: usize, field: &'static str) -> Result<(), FormatError> {
    if vector.len() >= most {
        return Err(FormatError::whole(field, format!("more than {most}"), format!("at most {most}")));
    }
    vector.try_reserve(1).map_err(|_| missing::<T>(field, 2 * vector.len()))?;
    vector.push(element);
    Ok(())
}

fn missing<T>(field: &'static str, count: usize) -> FormatError {
    let size = summary((count as u64).saturating_mul(size_of::<T>() as u64));
    FormatError::whole(field, format!("{count} take {size}"), "a size that fits in memory").problem()
}

/// Formats a number of bytes with a binary unit.
pub fn summary(count: u64) -> String {
    const UNITS: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
    if count < 1024 {
        return format!("{count} B");
    }
    let power = (count.ilog2() / 10).min(UNITS.len() as u32);
    let digits = if power == 1 { 1 } else { 2 };
    format!("{:.digits$} {}", count as f64 / 1024f64.powi(power as i32), UNITS[power as usize - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failed_allocations_are_errors() {
        assert_eq!(filled("cells", 3, 1u8).unwrap(), [1; 3]);
        let error = filled("cells", 1 << 50, [0f32; 4]).unwrap_err().to_string();
        let expected = "cells: 1125899906842624 take 16.00 PiB; expected a size that fits in memory";
        assert_eq!(error, expected);
        assert!(reserved::<u64>("cells", usize::MAX).is_err());
        let mut vector = vec![0u8; 2];
        assert!(push_within(&mut vector, 7, 3, "rows").is_ok());
        let error = push_within(&mut vector, 7, 3, "rows").unwrap_err().to_string();
        assert_eq!((vector.len(), &*error), (3, "rows: found more than 3, expected at most 3"));
    }

    #[test]
    fn bytes_have_units() {
        for (count, words) in [
            (0, "0 B"),
            (1023, "1023 B"),
            (1536, "1.5 KiB"),
            (1 << 20, "1.00 MiB"),
            (2 << 30, "2.00 GiB"),
            (1_649_267_441_676, "1.50 TiB"),
            (u64::MAX, "16384.00 PiB"),
        ] {
            assert_eq!(summary(count), words);
        }
    }
}
