//! The commands of the studies on the pages under docs/ work, and their output is that on the pages.

use super::PROGRAM;
use brdfc_testing::pages::{Program, run_pages};

/// Studies that draw.
const DRAW: [&str; 9] = [
    "throughput",
    "codecs",
    "level-of-detail",
    "images",
    "frame-time",
    "adaptive",
    "pixel-bandwidth",
    "bandwidth-directions",
    "antialiasing",
];

#[test]
fn every_command_of_the_studies_works() {
    #[cfg(feature = "render")]
    let can_draw = super::has_adapter();
    #[cfg(not(feature = "render"))]
    let can_draw = false;
    let counts = run_pages(&Program {
        name: "brdfc-bench",
        path: PROGRAM,
        starts: &["cargo run --release -p brdfc-studies -- ", "brdfc-bench "],
        others: &["cargo run --release -- ", "cargo run --release --features render -- ", "brdfc "],
        draws: |command| DRAW.iter().any(|study| command.contains(&format!("--study {study}"))),
        renders: cfg!(feature = "render"),
        can_draw,
    });
    let bless = std::env::var_os("BRDFC_BLESS").is_some();
    assert!(counts.run >= 2 && counts.parsed >= 10 && (bless || counts.compared >= 1), "{counts:?}");
}

#[test]
fn the_schema_of_the_studies_is_valid() {
    brdfc_testing::schema::check(super::schema());
    assert!(super::schema()["required"].as_array().unwrap().contains(&"version".into()));
}
