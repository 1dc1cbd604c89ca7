//! The studies that draw.

use super::schemas::conforms;
use crate::common::cli::Folder;
use crate::common::has_adapter;

#[test]
fn the_studies_that_draw() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    folder.run(&["encode", "synth:ward", "-o", "small.ktx2", "--grid", "4"]).succeeded();
    let study = |more: &[&str]| {
        let ran = folder.run(&[&["bench", "--json", "--study"][..], more].concat()).succeeded();
        conforms("bench", &ran.json());
        ran.json()
    };
    let throughput = study(&["throughput", "small.ktx2"]);
    assert_eq!(throughput["rows"].as_array().unwrap().len(), 6);
    assert!(throughput["rows"].as_array().unwrap().iter().all(|row| row["shader"].as_f64().unwrap() > 1e4));
    let images = study(&["images", "synth:lewis?kd=0.5&ks=0.1&n=4"]);
    let row = &images["rows"][0];
    let mean = |key: &str| row[key][0].as_f64().unwrap();
    assert!(mean("table") < mean("shader") && mean("shader") < 1.3, "{row}");
    let detail = study(&["level-of-detail", "small.ktx2", "--small", "--out", "frames"]);
    assert_eq!(detail["levels"].as_array().unwrap().len(), 3);
    let variance = |key: &str| detail[key]["variance"].as_f64().unwrap();
    assert!(variance("by_distance") < variance("finest"), "{detail}");
    assert_eq!(folder.files("frames").len(), 18);
}

/// Codecs beside each other; in the place of Python a script whose compressor keeps everything.
#[cfg(unix)]
#[test]
fn the_study_of_codecs() {
    use std::os::unix::fs::PermissionsExt;
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let script = folder.path().join("python");
    let text = "#!/bin/sh\n[ \"$1\" = -c ] && exit\ncp \"$2\" \"$3/kept.f32\"\necho zfp 0.1 4321 0.25 kept.f32\n";
    std::fs::write(&script, text).unwrap();
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).unwrap();
    let python = script.to_str().unwrap();
    let material = "synth:ggx?kd=0.3,0.1,0.05&alpha=0.2";
    let bench = ["bench", "--study", "codecs", material];
    let ran = folder.run(&[&bench[..], &["--json", "--out", "figures", "--peers", python]].concat()).succeeded();
    let study = ran.json();
    conforms("bench", &study);
    let rows = study["materials"][0]["rows"].as_array().unwrap();
    let of = |codec: &str| -> Vec<&serde_json::Value> { rows.iter().filter(|row| row["codec"] == codec).collect() };
    let least =
        |codec: &str| of(codec).iter().map(|row| row["delta_e"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!([of("table").len(), of("factored").len(), of("wavelet").len()], [8, 8, 3]);
    assert_eq!([of("bc6h").len(), of("bc7").len(), of("zfp").len(), of("ggx").len()], [8, 4, 5, 1]);
    // A model of the kind that is fitted is found; nodes that lost nothing are as close as tables.
    assert!(least("ggx") < 0.01 && least("zfp") < 1.1 * least("table"), "{} {}", least("ggx"), least("zfp"));
    assert!(least("bc6h") < 1.0 && least("bc7") < 1.0);
    assert!(of("table").iter().all(|row| row["shader"].as_f64().unwrap() > 1e4 && row["sampled"] == true));
    assert!(of("zfp").iter().all(|row| row["bytes_on_disk"] == 4321 && row["sampled"] == false));
    let figure = std::fs::read_to_string(folder.path().join("figures/codecs.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.contains("factored") && figure.contains("alpha=0.2"));
    let wrong = folder.run(&[&bench[..], &["--peers", "no-such-python"]].concat());
    assert!(wrong.code == 2 && wrong.stderr.contains("--peers no-such-python: "), "{} {}", wrong.code, wrong.stderr);
}
