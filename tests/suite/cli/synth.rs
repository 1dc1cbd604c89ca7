//! `brdfc synth`.

use crate::common::cli::Folder;

#[test]
fn every_kind_of_file_reads_back_near_the_model() {
    let folder = Folder::new();
    for (model, name, more, allowed) in [
        ("lewis?kd=0.6,0.3,0.1&n=4", "a.binary", &["--dimensions", "30x30x60"][..], 0.01),
        ("lewis?kd=0.6,0.3,0.1&n=4", "a.brdf", &["--rows", "1000"], 0.05),
        ("ggx?alpha=0.5", "a.csv", &["--rows", "1000"], 0.05),
        ("synth:lambert?kd=0.8,0.4,0.2", "b.brdf", &["--rows", "100"], 0.001),
    ] {
        let ran = folder.run(&[&["synth", model, "-o", name][..], more].concat()).succeeded();
        assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
        let address = format!("synth:{}", model.trim_start_matches("synth:"));
        let ran = folder.run(&["compare", &address, name, "--directions", "1000", "--json"]).succeeded();
        let error = ran.json()["norms"]["relative_mean"].as_f64().unwrap();
        assert!(error < allowed, "{name} of {model}: {error}");
    }
    let ran = folder.run(&["compare", "synth:lambert", "b.brdf", "--directions", "100", "--max-error", "0.05"]);
    assert_eq!(ran.code, 1, "another model is far");
}

#[test]
fn dimensions_rows_and_duplicates_are_as_asked() {
    let folder = Folder::new();
    folder.run(&["synth", "ggx", "-o", "a.binary", "--dimensions", "5x6x7"]).succeeded();
    assert_eq!(folder.read("a.binary").len(), 12 + 24 * 5 * 6 * 7);
    let more = ["--rows", "200", "--duplicates", "0.25", "--noise", "0.1"];
    folder.run(&[&["synth", "ggx", "-o", "a.csv"][..], &more].concat()).succeeded();
    let info = folder.run(&["info", "a.csv", "--json"]).succeeded().json();
    assert_eq!(info["rows"], 200);
    assert!(
        info["distinct"].as_u64().unwrap() <= 150 && info["largest_disagreement"].as_f64().unwrap() > 0.01,
        "{info}"
    );
}
