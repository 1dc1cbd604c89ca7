//! Limit of the memory of photographs, and errors about inputs out of range.

use crate::error::Error;
use brdfc_formats::FormatError;
use brdfc_readers::pixels::Pixels;
use brdfc_source::InputError;

/// Maximum bytes of all photographs together: 6 GiB.
pub(super) const MAX_BYTES: u64 = 6 << 30;

/// Error about a field of an input.
pub(super) fn refused(input: &impl std::fmt::Display, field: &'static str, found: &str, allowed: &str) -> Error {
    let error = FormatError::whole(field, found.to_owned(), allowed);
    InputError::Format { name: input.to_string(), error }.into()
}

/// Checks the bytes of images, which are all held in memory.
pub(super) fn check_amount(
    input: &impl std::fmt::Display,
    size: [usize; 2],
    lights: usize,
    bytes: u64,
) -> Result<(), Error> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let found = format!("{lights} of {} x {} pixels, {:.1} GiB", size[0], size[1], gib(bytes));
    Err(refused(input, "photographs", &found, &format!("at most {} GiB in all", gib(MAX_BYTES))))
}

/// [`check_amount`] of images with linear values.
pub(super) fn check_linear(input: &impl std::fmt::Display, size: [usize; 2], lights: usize) -> Result<(), Error> {
    let pixels: u64 = size.map(|side| side as u64).iter().product();
    check_amount(input, size, lights, Pixels::BYTES_OF_LINEAR * pixels * lights as u64)
}
