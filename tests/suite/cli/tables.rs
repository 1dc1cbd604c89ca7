//! Tables in the program's output.

use brdfc_terminal::table::{apart, plain};

#[test]
fn columns_are_as_wide_as_their_widest_cell() {
    let rows = [["paint", "1.00"], ["é漢", "12.50"]].map(|row| row.map(str::to_owned).to_vec());
    assert_eq!(plain(&["name", "ΔE"], &rows), "name      ΔE\npaint   1.00\né漢    12.50\n");
}

#[test]
fn numbers_near_a_limit_have_enough_digits() {
    assert_eq!(apart(3.2468, 3.0), "3.25");
    assert_eq!(apart(0.3012, 0.301), "0.3012");
    assert_eq!(apart(0.301, 0.301), "0.301");
    assert_eq!(apart(27.9996, 28.0), "27.9996");
}
