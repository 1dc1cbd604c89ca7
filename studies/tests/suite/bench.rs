//! Studies that need no graphics driver.

use super::{conforms, folder};

#[test]
fn the_study_prints_nine_rows_with_the_papers_figures() {
    let folder = folder();
    let ran = folder.run(&["--json"]).succeeded();
    let report = ran.json();
    conforms(&report);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 9);
    for row in rows {
        let [relative, coarse] = ["relative", "relative_8_bit"].map(|key| row[key].as_f64().unwrap());
        assert!(relative > 0.0 && relative < 1.0 && coarse < relative + 0.001, "{row}");
        // Parameters are matched to the paper's figures.
        let factor = |key: &str| row[key].as_f64().unwrap() / row[format!("paper_{key}")].as_f64().unwrap();
        assert!((0.95..1.05).contains(&factor("mean")), "{row}");
        assert!((0.6..1.5).contains(&factor("rms")) && (0.6..1.5).contains(&factor("relative")), "{row}");
    }
}

/// Every stage is within its bound, and broken stages exceed it.
#[test]
fn the_study_of_stress_has_bounds_and_negative_controls() {
    let folder = folder();
    let ran = folder.run(&["--study", "stress", "--small", "--json"]).succeeded();
    conforms(&ran.json());
    let report = ran.json();
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.len() > 40, "{}", rows.len());
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for row in rows {
        assert!(row["holds"] == true && number(&row["error"]) <= number(&row["bound"]), "{row}");
        assert!(number(&row["control"]["error"]) > number(&row["bound"]), "{row}");
    }
    let ran = folder.run(&["--study", "stress", "synth:lewis"]);
    assert!(ran.code == 2 && ran.stderr.contains("INPUT: found with --study stress"), "{}", ran.stderr);
}

#[test]
fn the_study_of_rays_counts_rays_and_writes_them() {
    let folder = folder();
    let study = ["--study", "rays", "synth:button?resolution=16", "--texels", "2"];
    let ran = folder.run(&[&study[..], &["--json", "--out", "dump"]].concat()).succeeded();
    let report = ran.json();
    conforms(&report);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows[0]["rays"], 2 * 2 * 256);
    assert!(rows.iter().all(|row| row["one"].as_f64() > Some(0.0) && row["repeated_all"].as_f64() > Some(0.0)));
    let rays: u64 = rows.iter().map(|row| row["rays"].as_u64().unwrap()).sum();
    assert_eq!(std::fs::metadata(folder.path().join("dump/rays.bin")).unwrap().len(), 8 + 32 * rays);
    assert!(folder.path().join("dump/mesh.ply").exists());
    conforms(&folder.run(&[&study[..], &["--json"]].concat()).succeeded().json());
    for (arguments, code, expected) in [
        (&["synth:buton"][..], 3, "did you mean button?"),
        (&["--adapter", "x"], 2, "--adapter: found with another study, expected with --study throughput"),
        (&["button.obj"], 2, "INPUT: found button.obj"),
        (&["--texels", "0"], 2, "--texels: found 0, expected 1 to 512"),
        (&["--small"], 2, "--small: found with another study, expected with --study pareto, stress, level-of-detail"),
    ] {
        let ran = folder.run(&[&["--study", "rays"][..], arguments].concat());
        assert_eq!(ran.code, code, "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}

/// Parallax of images is explained by the surface: factors of images are nearly as good as the materials.
#[test]
fn the_study_of_measured_btfs_compares_images_with_materials() {
    let folder = folder();
    let study =
        ["--study", "measured-btf", "synth:knit?resolution=32", "--texels", "32", "--directions", "grid:3x8@60"];
    let report = folder.run(&[&study[..], &["--json"]].concat()).succeeded().json();
    conforms(&report);
    let rows = report["rows"].as_array().unwrap();
    let number = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    assert_eq!((rows.len(), &rows[0]["from"], &rows[1]["from"]), (2, &"images".into(), &"materials".into()));
    assert_eq!(rows[0]["images"], 17 * 17);
    for row in 0..2 {
        assert!(number(row, "psnr") > 20.0 && number(row, "delta_e") < 5.0, "{rows:?}");
        assert!(number(row, "file_bytes") < number(row, "gpu_bytes") + 20_000.0, "{rows:?}");
    }
    let printed = folder.run(&study).succeeded().stdout;
    assert!(
        printed.contains("289 images of 32 x 32 pixels per structure") && printed.contains("materials"),
        "{printed}"
    );
    let refused = folder.run(&["--study", "measured-btf", "--texels", "48"]);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
}

fn is_image(file: &std::path::Path) {
    let image = image::open(file).unwrap().into_rgb8();
    let first = image.get_pixel(0, 0);
    assert!(image.pixels().any(|pixel| pixel != first), "{}", file.display());
}

/// Blended shadows are not as good as rays, and fewer sheets not as good as more.
#[test]
fn the_study_of_reliefs_compares_methods() {
    let folder = folder();
    let study = ["--study", "relief", "synth:button?resolution=64", "--texels", "64", "--pixels", "120"];
    let report = folder.run(&[&study[..], &["--json", "--out", "sheets"]].concat()).succeeded().json();
    conforms(&report);
    is_image(&folder.path().join("sheets/relief-button-resolution-64.png"));
    let methods = report["rows"][0]["methods"].as_array().unwrap();
    let of = |name: &str| methods.iter().find(|row| row["method"] == name).unwrap_or_else(|| panic!("{name}"));
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let plane = |name: &str| number(&of(name)["plane"]["delta_e"]);
    assert_eq!(methods.len(), 8);
    let order = ["layers", "height field", "normal map"].map(plane);
    assert!(1.5 * order[0] < order[1] && 1.5 * order[1] < order[2], "{order:?}");
    assert!(2.0 * plane("exact rays") < plane("exact rays, sampled shadows"), "{methods:?}");
    assert!(plane("exact rays, sampled shadows") < plane("sampled indirections and shadows"), "{methods:?}");
    for (name, is_bound) in [("layers", false), ("exact rays", true)] {
        let row = of(name);
        assert_eq!(
            row["bytes"].is_null() && row["fetches"].is_null() && row["nanoseconds"].is_null(),
            is_bound,
            "{row}"
        );
        assert_eq!(row["angles"].as_array().unwrap().len(), 6);
        assert!(number(&row["jumps"]) < 0.2 && (0.5..1.5).contains(&number(&row["far"]["brightness"])), "{row}");
    }
    // Outlines and curvature: on objects layers are nearer than rays that know of neither.
    let vase = |name: &str| number(&of(name)["objects"][0]["rendering"]["delta_e"]);
    assert!(vase("layers") < vase("exact rays"), "{methods:?}");
    let text = folder.run(&study).succeeded().stdout;
    for words in ["layers", "height field", "16 x 16 tiles", "75°", "jumps", "vase", "teapot"] {
        assert!(text.contains(words), "no {words} in {text}");
    }
    for (arguments, expected) in [
        (&["--texels", "60"][..], "--texels: found 60, expected a power of two from 8 to 512"),
        (&["--pixels", "10"], "--pixels: found 10, expected 64 to 2048"),
        (&["button.obj"], "INPUT: found button.obj"),
    ] {
        let ran = folder.run(&[&["--study", "relief"][..], arguments].concat());
        assert_eq!(ran.code, 2, "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}

#[test]
fn the_study_of_flat_btfs_has_the_papers_tables() {
    let folder = folder();
    let small = ["--texels", "16", "--flat-texels", "64", "--directions", "grid:3x6@70"];
    let both = ["--study", "flat-btf", "synth:folds?resolution=48", "synth:sponge?resolution=48"];
    let others = ["synth:button?resolution=48", "synth:knit?resolution=48"];
    let report = folder.run(&[&both[..], &others, &small, &["--json"]].concat()).succeeded().json();
    conforms(&report);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let variance = |kind: &str| number(&row["coherency"][kind]["mean"]);
        // The paper's factors, 1.8 and 3, are reached with enough texels; overhangs need the most.
        let (filled, seen) = if row["paper_model"] == "Button" { (1.5, 2.0) } else { (1.8, 3.0) };
        assert!(variance("poisson") < variance("push_pull"), "{row}");
        assert!(variance("btf") > filled * variance("push_pull"), "{row}");
        assert!(variance("btf") > seen * variance("visible"), "{row}");
        // At so few texels; the paper's own are 3 and more. The map costs about as much as the rest.
        let rebuilt = &row["reconstruction"];
        let [mean, exact] = ["through_map", "exact_rays"].map(|kind| number(&rebuilt[kind]["mean"]));
        assert!((0.1..4.5).contains(&exact) && mean > 1.2 * exact && mean < 8.0, "{row}");
        // Polar angles 0, 35 and 70: from above nothing is blended, and both see about the same; from the side they do not.
        let angles = rebuilt["angles"].as_array().unwrap();
        let of = |kind: &str| angles.iter().map(|angle| number(&angle[kind])).collect::<Vec<_>>();
        assert_eq!((of("polar_angle"), of("views")), (vec![0.0, 35.0, 70.0], vec![1.0, 6.0, 6.0]));
        let (map, unblended, exact) = (of("through_map"), of("unblended"), of("exact_rays"));
        assert!((map[0] - unblended[0]).abs() < 0.01 && (map[0] - exact[0]).abs() < 1.5, "{row}");
        assert!(map[2] > 1.4 * exact[2] && map[2] > 1.4 * map[1], "{row}");
        let weighted = |means: &[f64]| (means[0] + 6.0 * (means[1] + means[2])) / 13.0;
        assert!((weighted(&map) - mean).abs() < 1e-6, "{row}");
        // 16 x 16 views against 8 x 32.
        let [coarse, fine] = row["grids"].as_array().unwrap().as_slice() else { panic!("{row}") };
        assert_eq!([&coarse["polar_angles"], &fine["polar_angles"]], [8, 16]);
        assert!(number(&fine["mean"]) < number(&coarse["mean"]), "{row}");
    }
    let out = ["synth:knit?resolution=32&height=0", "--out", "figures"];
    let text = folder.run(&[&both[..4], &out, &small].concat()).succeeded().stdout;
    for words in ["through the map", "exact rays", "Table 2", "JPEG", "Figure 10", "Isba", "16 x 16", "knit", "70°"] {
        assert!(text.contains(words), "no {words} in {text}");
    }
    for figure in ["variance", "apparent", "parameterisation", "holes", "displacements", "layout", "reconstruction"] {
        is_image(&folder.path().join(format!("figures/{figure}-folds-resolution-48.png")));
    }
    // Of a plane, at the texels of the flat BTF, nothing is lost either way.
    let plane = ["--study", "flat-btf", "synth:knit?resolution=32&height=0", "--texels", "16", "--flat-texels", "16"];
    let finer = ["--directions", "grid:2x4@60", "--indirection", "4x8", "--largest-angle", "70", "--json"];
    let report = folder.run(&[&plane[..], &finer].concat()).succeeded().json();
    assert_eq!(report["settings"]["indirection"], serde_json::json!([4, 8]));
    for kind in ["through_map", "exact_rays"] {
        let largest = report["rows"][0]["reconstruction"][kind]["largest_image"].as_f64().unwrap();
        // Values are rounded to 9 bits.
        assert!(largest < 0.3, "{kind} {largest}");
    }
    let wrong = folder.run(&["--study", "flat-btf", "synth:lambert"]);
    assert!(wrong.code == 3 && wrong.stderr.contains("button, folds, knit or sponge"), "{wrong:?}");
}

#[test]
fn the_study_of_btfs_has_every_method_for_both_kinds() {
    let folder = folder();
    let small = ["--study", "btf", "synth:folds?resolution=32", "--texels", "8", "--directions", "grid:3x4@60"];
    let run = |more: &[&str]| folder.run(&[&small[..], more].concat()).succeeded();
    let report = run(&["--json", "--out", "figures"]).json();
    conforms(&report);
    assert_eq!(report["settings"]["held_out"].as_array().unwrap().len(), 1);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let model = &report["models"][0];
    for kind in ["classic", "flat"] {
        let row = |method: &str| {
            let rows = model[kind]["rows"].as_array().unwrap();
            rows.iter().find(|row| row["method"] == method).unwrap_or_else(|| panic!("no {method} of {kind}: {rows:?}"))
        };
        let (plain, map, tree) = (row("uncompressed"), row("PTM"), row("PWT at PTM's ΔE"));
        // 9 views, 8 lights that are fitted, 85 texels with mipmaps.
        assert_eq!((&map["bytes"], &plain["bytes"]), (&(18 * 9 * 85).into(), &(4 * 9 * 8 * 85).into()));
        assert_eq!((&map["share"], &map["fetches"], &plain["fetches"]), (&1.0.into(), &15.0.into(), &9.0.into()));
        assert!(number(&plain["delta_e"]) == 0.0 && number(&plain["held_out_delta_e"]) > 0.1, "{plain}");
        assert_eq!(tree["met"] == true, number(&tree["delta_e"]) <= number(&map["delta_e"]), "{tree} {map}");
        let coarse = row("PWT of light and view, order 3");
        assert!(number(&row("PWT of light and view, order 5")["bytes"]) > number(&coarse["bytes"]));
        assert_eq!(row("factored, 32 components")["met"], serde_json::Value::Null);
        // Half of the coefficients, or a quarter of the texels and none of the finest level.
        assert_eq!(row("PTM, LRGB")["bytes"], 9 * 9 * 85);
        let harmonics = ["HSH, order 3, at half size", "HSH, order 3"].map(|way| number(&row(way)["bytes"]));
        assert!(2.0 * harmonics[0] < harmonics[1], "{harmonics:?}");
        for way in ["PWT at ΔE 1", "PWT of light and view at ΔE 1", "factored at ΔE 1"] {
            assert_eq!(row(way)["met"] == true, number(&row(way)["delta_e"]) <= 1.0, "{}", row(way));
        }
    }
    assert_eq!(model["classic"]["seen"], 1.0);
    assert!(number(&model["flat"]["seen"]) < 1.0);
    assert!(std::fs::read_to_string(folder.path().join("figures/btf.svg")).unwrap().contains("factored"));
    // All but the time is the same on any number of threads.
    let timeless = |mut report: serde_json::Value| {
        for kind in ["classic", "flat"] {
            let rows = report["models"][0][kind]["rows"].as_array_mut().unwrap();
            rows.iter_mut().for_each(|row| row["seconds"] = 0.into());
        }
        report
    };
    let one = timeless(run(&["--json", "--jobs", "1"]).json());
    assert_eq!(one, timeless(run(&["--json", "--jobs", "3"]).json()));
    assert!(run(&[]).stdout.contains("PWT at PTM's ΔE, flat BTF: "));
    for (arguments, code, expected) in [
        (&["--texels", "48"][..], 2, "--texels: found 48, expected a power of two from 8 to 256"),
        (&["--directions", "grid:2x3@50"], 2, "--directions: directions: found 4, expected 5 or more"),
        (&["synth:lambert"], 3, "button, folds, knit or sponge"),
        (&["button.obj"], 2, "INPUT: found button.obj, expected synth:"),
        (&["--flat-texels", "8"], 2, "--flat-texels: found with another study"),
    ] {
        let ran = folder.run(&[&["--study", "btf"][..], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {ran:?}");
    }
}

#[test]
fn the_study_of_run_time_against_error_marks_the_front() {
    let folder = folder();
    let study = ["--study", "pareto", "synth:ggx?alpha=0.3", "--small"];
    let ran = folder.run(&[&study[..], &["--json", "--out", "figures"]].concat()).succeeded();
    let report = ran.json();
    conforms(&report);
    assert!(ran.stderr.contains("1 of 1: synth:ggx?alpha=0.3, 100 %"), "{}", ran.stderr);
    let rows = report["materials"][0]["rows"].as_array().unwrap();
    for front in ["bytes", "seconds"] {
        let cost = |row: &serde_json::Value| {
            row[if front == "bytes" { "bytes_on_gpu" } else { "encode_seconds" }].as_f64().unwrap()
        };
        let error = |row: &serde_json::Value| row["delta_e"].as_f64().unwrap();
        for row in rows {
            let beaten = rows.iter().any(|other| {
                let no_worse = cost(other) <= cost(row) && error(other) <= error(row);
                no_worse && (cost(other) < cost(row) || error(other) < error(row))
            });
            assert_eq!(row[format!("on_{front}_front")], !beaten, "{row}");
        }
    }
    // Each codec and number of bits is there.
    let with = |key: &str, value: serde_json::Value| rows.iter().any(|row| row["wavelet"][key] == value);
    assert!(["table", "factored", "wavelet"].iter().all(|codec| rows.iter().any(|row| row["codec"] == *codec)));
    assert!(with("bits", 8.into()) && with("bits", 12.into()));
    assert!(with("visible", false.into()));
    let drawn = std::fs::read_to_string(folder.path().join("figures/pareto.svg")).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.contains("seconds of encoding"));
    let text = folder.run(&study).succeeded().stdout;
    assert!(text.contains("front of") && text.contains(&format!("of {} settings", rows.len())), "{text}");
}
