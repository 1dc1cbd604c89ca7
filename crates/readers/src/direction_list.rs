//! Direction sets as CSV. Layout: `crates/readers/src/btf_stack.md`, section "Direction lists".

use crate::scan_csv::Table;
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::{DirectionSet, MAX_DIRECTIONS, first_pair_of_equals, wrong_angle};

/// Columns of a set; angles in degrees, `index` counts from 0.
pub const COLUMNS: [&str; 3] = ["index", "theta_deg", "phi_deg"];

/// Parses a CSV with the columns [`COLUMNS`]: `index` counts the records from 0.
///
/// # Errors
/// Returns an error for sets that [`DirectionSet::new`] rejects, with the line, for a wrong header or index, and for
/// text that is not a number.
pub fn from_csv(bytes: &[u8]) -> Result<DirectionSet, FormatError> {
    let mut table = Table::open(bytes)?;
    let columns = table.find(&COLUMNS)?;
    let mut angles = Vec::new();
    let mut lines = Vec::new();
    while let Some((line, numbers)) = table.next_numbers(&columns)? {
        if numbers[0] != angles.len() as f64 {
            return Err(FormatError::at_line(line, "index", numbers[0].to_string(), angles.len().to_string()));
        }
        if angles.len() == MAX_DIRECTIONS {
            let allowed = format!("at most {MAX_DIRECTIONS} directions");
            return Err(FormatError::at_line(line, "record", "too many directions", allowed).problem());
        }
        let found = [numbers[1], numbers[2]];
        if let Some((field, number, allowed)) = wrong_angle(found) {
            return Err(FormatError::at_line(line, field, number.to_string(), allowed));
        }
        angles.push(found);
        lines.push(line);
    }
    if angles.is_empty() {
        return Err(FormatError::whole("directions", "no directions", "at least one record after the header").problem());
    }
    let set = DirectionSet { name: "list".to_owned(), angles };
    if let Some((first, second)) = first_pair_of_equals(&set.directions()) {
        let found = format!("equal to the direction of line {}", lines[first]);
        return Err(FormatError::at_line(lines[second], "direction", found, "directions that differ").problem());
    }
    Ok(set)
}

/// Formats a set as CSV, which [`from_csv`] reads back to the same bits.
pub fn to_csv(set: &DirectionSet) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for (index, [theta, phi]) in set.angles.iter().enumerate() {
        text += &format!("{index},{theta},{phi}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_round_trip() {
        let set = DirectionSet::grid(7, 9, 80.0).unwrap();
        assert_eq!(from_csv(to_csv(&set).as_bytes()).unwrap().angles, set.angles);
    }

    #[test]
    fn errors_name_the_line() {
        let head = "index,theta_deg,phi_deg\n";
        let text = |rows: &str| from_csv(format!("{head}{rows}").as_bytes()).unwrap_err().to_string();
        assert_eq!(text("0,90,0\n"), "line 2, theta_deg: found 90, expected 0 to less than 90");
        assert!(text("0,0,0\n1,-1,0\n").starts_with("line 3, theta_deg: found -1"));
        assert!(text("0,0,361\n").contains("phi_deg: found 361"));
        assert!(text("0,0,x\n").contains("line 2, phi_deg: found \"x\""));
        assert!(text("0,0,0\n2,10,0\n").contains("line 3, index: found 2, expected 1"));
        assert!(text("0,0,0\n1,10,0\n2,0,90\n").contains("line 4, direction: equal to the direction of line 2"));
        assert!(text("0,10,0\n1,10,360\n").contains("line 3, direction"));
        assert!(text("").contains("at least one record"));
        let many: String = (0..2049).map(|k| format!("{k},{},{}\n", k as f64 * 0.04, k % 360)).collect();
        assert!(text(&many).starts_with("line 2050, record: too many directions; expected at most 2048"));
        let error = from_csv(b"index,theta,phi\n").unwrap_err().to_string();
        assert!(error.contains("column theta_deg"), "{error}");
        // Just far enough apart to be valid.
        let near = format!("{head}0,10,0\n1,10.015,0\n");
        assert_eq!(from_csv(near.as_bytes()).unwrap().len(), 2);
    }
}
