//! `brdfc bench`.

use super::schemas::conforms;
use crate::common::cli::Folder;

#[test]
fn the_study_prints_nine_rows_with_the_papers_figures_beside() {
    let folder = Folder::new();
    let ran = folder.run(&["bench", "--json"]).succeeded();
    let report = ran.json();
    conforms("bench", &report);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 9);
    for row in rows {
        let [relative, coarse] = ["relative", "relative_8_bit"].map(|key| row[key].as_f64().unwrap());
        assert!(relative > 0.0 && relative < 1.0 && coarse < relative + 0.001, "{row}");
    }
}
