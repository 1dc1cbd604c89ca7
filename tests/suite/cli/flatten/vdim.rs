//! `brdfc flatten --relief vdim`.

use super::{file, flatten, number, report};
use crate::common::cli::Folder;
use brdfc_formats::flat_btf::{FlatBtfFile, Relief, ShadowMap, VdimHeader};

const BUTTON: &str = "synth:button?resolution=40";

/// Header of the map of a file, and the number of its lights with shadows.
fn map_of(file: &FlatBtfFile) -> (VdimHeader, usize) {
    match &file.decoder.parts().relief {
        Relief::Vdim(map, shadows) => (*map.header(), shadows.as_ref().map_or(0, |map: &ShadowMap| map.lights().len())),
        Relief::Layers(_) => panic!("layers"),
    }
}

#[test]
fn options_set_the_views_and_the_shadows() {
    let folder = Folder::new();
    let made = |name: &str, more: &[&str]| {
        let report = report(flatten(&folder, &[&[BUTTON, "-o", name, "--relief", "vdim"], more].concat()));
        let (header, lights) = map_of(&file(&folder, name));
        (report, header, lights)
    };
    let (report, header, lights) = made("plain", &[]);
    let expected = VdimHeader {
        size: 16,
        block: 1,
        polar_angles: 16,
        azimuth_rows: 16,
        largest_angle: 80f32.to_radians(),
        levels: 5,
        lights: 7,
    };
    assert!((header.largest_angle - expected.largest_angle).abs() < 1e-6);
    assert_eq!((VdimHeader { largest_angle: expected.largest_angle, ..header }, lights), (expected, 7));
    let settings = &report["settings"]["relief"];
    assert_eq!((&settings["form"], &settings["polar_angles"]), (&"vdim".into(), &16.into()));
    assert!(report["report"].get("layers").is_none(), "{}", report["report"]);
    let texels = 256 + 64 + 16 + 4 + 1;
    assert_eq!(report["images"]["flat_btf_vdim"], 8 * 16 * 16 * texels);
    assert_eq!(
        (&report["images"]["flat_btf_reference"], report["images"].get("flat_btf_heights")),
        (&(4 * texels).into(), None)
    );
    let (_, header, lights) = made(
        "other",
        &["--indirection", "8x32", "--largest-angle", "90", "--lights", "grid:2x4@50", "--oversampling", "1"],
    );
    assert_eq!(([header.polar_angles, header.azimuth_rows], lights), ([8, 32], 5));
    assert!((header.largest_angle - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    let (bare, header, lights) = made("bare", &["--shadows", "none"]);
    assert_eq!((header.lights, lights, bare["images"].get("flat_btf_shadows")), (0, 0, None));
    assert!(file(&folder, "bare").directions.is_none());
    // Shadows change the error.
    let error = |report: &serde_json::Value| number(&report["report"]["errors"]["from_surface"]["mean"]);
    assert!(error(&bare) != error(&report), "{} {}", error(&bare), error(&report));
}

/// Two bytes for each view; the error is nearly the same. Blocks of several texels begin at 256.
#[test]
fn compact_maps_take_fewer_bytes() {
    let folder = Folder::new();
    let [plain, compact] = [&[][..], &["--compact"]].map(|more| {
        let name = if more.is_empty() { "plain" } else { "compact" };
        report(flatten(&folder, &[&[BUTTON, "-o", name, "--relief", "vdim"], more].concat()))
    });
    let bytes = |report: &serde_json::Value, image: &str| number(&report["images"][image]);
    assert_eq!(4.0 * bytes(&compact, "flat_btf_vdim"), bytes(&plain, "flat_btf_vdim"));
    let texels = 256.0 + 64.0 + 16.0 + 4.0 + 1.0;
    assert_eq!(bytes(&compact, "flat_btf_heights"), texels);
    assert_eq!(bytes(&compact, "flat_btf_displacements"), 8.0 * texels);
    let error = |report: &serde_json::Value| number(&report["report"]["errors"]["from_surface"]["mean"]);
    assert!((error(&compact) - error(&plain)).abs() < 0.5, "{} {}", error(&compact), error(&plain));
    let info = folder.run(&["info", "compact"]).succeeded();
    assert!(info.stdout.contains("16 x 16 compact views up to 80°"), "{}", info.stdout);
    folder.run(&["view", "compact", "-o", "compact.html"]).succeeded();
    let differs = folder.run(&["compare", "plain", "compact", "--json"]).succeeded().json();
    assert!(number(&differs["errors"]["mean"]) < 3.0, "{differs}");
}

/// The commands for flat BTFs take the file. Blended views of a map are less exact than layers.
#[test]
fn all_commands_take_the_file() {
    let folder = Folder::new();
    for (name, more) in [("layers", &[][..]), ("map", &["--relief", "vdim"])] {
        flatten(&folder, &[&[BUTTON, "-o", name], more].concat()).succeeded();
    }
    let info = folder.run(&["info", "map"]).succeeded();
    assert!(info.stdout.contains("16 x 16 views up to 80°, shadows of 7 lights"), "{}", info.stdout);
    let differs = folder.run(&["compare", "layers", "map", "--json"]).succeeded().json();
    let mean = |json: &serde_json::Value| number(&json["errors"]["mean"]);
    assert!((0.5..12.0).contains(&mean(&differs)), "{differs}");
    assert_eq!(mean(&folder.run(&["compare", "map", "map", "--json"]).succeeded().json()), 0.0);
    // The page has the texels of the map.
    let [of_layers, of_map] = ["layers", "map"].map(|name| {
        let page = format!("{name}.html");
        folder.run(&["view", name, "-o", &page]).succeeded();
        std::fs::metadata(folder.path().join(page)).unwrap().len()
    });
    assert!(of_map > of_layers + 200_000, "{of_map} {of_layers}");
    folder.run(&["report", "map", "-o", "report.html"]).succeeded();
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for threads in ["1", "3"] {
        let base = ["flatten", BUTTON, "-o", threads, "--name", "map", "--texels", "16", "--relief", "vdim"];
        folder.run(&[&base[..], &["--lights", "grid:2x6@50", "-j", threads]].concat()).succeeded();
    }
    assert_eq!(folder.files("1"), folder.files("3"));
}

#[test]
fn wrong_settings_fail_before_any_work() {
    let folder = Folder::new();
    for (options, words) in [
        (&["--indirection", "8x8"][..], "--indirection does not apply to --relief layers, only to --relief vdim"),
        (&["--shadows", "none"], "--shadows"),
        (&["--compact"], "--compact does not apply to --relief layers, only to --relief vdim"),
        (&["--relief", "vdim", "--indirection", "1x16"], "2 to 256 polar angles x 4 to 256 rows of azimuths"),
        (&["--relief", "vdim", "--indirection", "16"], "such as 16x16"),
        (&["--relief", "vdim", "--largest-angle", "0"], "--largest-angle: found 0, expected 1 to 90 degrees"),
        (&["--relief", "vdim", "--largest-angle", "nan"], "--largest-angle: found NaN"),
        (&["--relief", "vdim", "--oversampling", "17"], "--oversampling"),
        (&["--relief", "vdim", "--texels", "1024"], "16384 x 16384, expected at most 8192 on each side"),
        (&["--relief", "cloth"], "layers, vdim"),
    ] {
        let ran = folder.run(&[&["flatten", BUTTON, "-o", "never"], options].concat());
        assert!(ran.code == 2 && ran.stderr.contains(words), "{options:?}: {} {}", ran.code, ran.stderr);
        assert!(!folder.path().join("never").exists());
    }
}
