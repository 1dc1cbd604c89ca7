//! Whole numbers of flags.

use std::ops::RangeInclusive;

/// Returns a parser of whole numbers in a range. Errors give the range, also for negative numbers.
pub fn whole_number<T: TryFrom<u64>>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let allowed = || match (*range.start(), *range.end()) {
            (least, u64::MAX) => format!("expected {least} or more"),
            (least, most) => format!("expected {least} to {most}"),
        };
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(allowed)
    }
}

/// Returns a parser of whole numbers whose range is checked elsewhere; `allowed` describes it.
pub fn any_whole_number<T: TryFrom<u64>>(allowed: &'static str) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| format!("expected {allowed}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_range() {
        let parse = whole_number::<u8>(1..=300);
        assert_eq!(parse("255"), Ok(255));
        for text in ["0", "-1", "301", "256", "1.5", "x", "", "99999999999999999999999"] {
            assert_eq!(parse(text), Err("expected 1 to 300".to_owned()), "{text}");
        }
        assert_eq!(whole_number::<u64>(1..=u64::MAX)("-1"), Err("expected 1 or more".to_owned()));
        assert_eq!(any_whole_number::<u32>("a power of two")("-4"), Err("expected a power of two".to_owned()));
        assert_eq!(any_whole_number::<u32>("a power of two")("3"), Ok(3));
    }
}
