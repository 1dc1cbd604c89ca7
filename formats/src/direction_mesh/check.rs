//! Validation of the words of a mesh.

use super::build::{HEADER_WORDS, MAX_GRID};
use crate::FormatError;
use crate::direction_set::MAX_DIRECTIONS;

const FIELD: &str = "directions";
/// Maximum number of triangles and segments per direction: n points have fewer than 2 n triangles and 2 n segments.
const MAX_TRIANGLES: usize = 4;

fn wrong(what: &str, found: impl ToString, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("{FIELD}, {what}"), found.to_string(), allowed)
}

/// Number of words of the mesh at the start of a list.
///
/// # Errors
/// Returns an error if counts are out of range or there are fewer words than the counts require.
pub(super) fn length(words: &[u32]) -> Result<usize, FormatError> {
    let Some(&[grid, directions, triangles, candidates]) = words.first_chunk::<HEADER_WORDS>() else {
        return Err(wrong("words", words.len(), format!("{HEADER_WORDS} or more")));
    };
    let [grid, directions, triangles, candidates] =
        [grid, directions, triangles, candidates].map(|word| usize::try_from(word).unwrap_or(usize::MAX));
    let cells = grid.saturating_mul(grid);
    let most_triangles = MAX_TRIANGLES * directions.min(MAX_DIRECTIONS);
    for (what, found, range) in [
        ("side of the grid", grid, 1..=MAX_GRID),
        ("number", directions, 1..=MAX_DIRECTIONS),
        ("triangles and segments", triangles, 1..=most_triangles),
        ("candidates", candidates, 0..=cells.saturating_mul(triangles)),
    ] {
        if !range.contains(&found) {
            return Err(wrong(what, found, format!("{} to {}", range.start(), range.end())));
        }
    }
    let length = HEADER_WORDS + cells + 1 + candidates + 3 * triangles + 2 * directions;
    if words.len() < length {
        return Err(wrong("words", words.len(), format!("{length}, as its counts require")));
    }
    Ok(length)
}

/// Checks that all indices of a mesh are in range. `words` has the length that [`length`] returns.
///
/// # Errors
/// Returns an error that names the first word out of range.
pub(super) fn check(words: &[u32]) -> Result<(), FormatError> {
    let (cells, rest) = words[HEADER_WORDS..].split_at((words[0] * words[0]) as usize + 1);
    let (candidates, rest) = rest.split_at(words[3] as usize);
    let (corners, coordinates) = rest.split_at(3 * words[2] as usize);
    let rising = cells.windows(2).all(|pair| pair[0] <= pair[1]);
    if cells[0] != 0 || cells[cells.len() - 1] != words[3] || !rising {
        let allowed = "numbers that rise from 0 to the number of candidates";
        return Err(wrong("cells", "first candidates out of order", allowed).problem());
    }
    for (what, numbers, end) in [("candidate", candidates, words[2]), ("corner", corners, words[1])] {
        if let Some(k) = numbers.iter().position(|number| *number >= end) {
            return Err(wrong(&format!("{what} {k}"), numbers[k], format!("below {end}")));
        }
    }
    let coordinates: Vec<f32> = coordinates.iter().map(|bits| f32::from_bits(*bits)).collect();
    match coordinates.iter().position(|coordinate| !(-1.0..=1.0).contains(coordinate)) {
        Some(k) => Err(wrong(&format!("coordinate {k}"), coordinates[k], "-1 to 1")),
        None => Ok(()),
    }
}
