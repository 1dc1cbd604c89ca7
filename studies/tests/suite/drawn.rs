//! The studies that draw.

use super::{conforms, folder, has_adapter};
use brdfc_testing::program::Folder;
use brdfc_wavelet::recipe::Recipe;

#[test]
fn the_studies_that_draw() {
    if !has_adapter() {
        return;
    }
    let folder = folder();
    let recipe = Recipe { levels: 2, stored_levels: 2, ..Recipe::default() };
    let source = brdfc_core::address::parse_model("ward").unwrap();
    let encoded = brdfc_wavelet::encode::encode(source.as_ref(), &recipe, &()).unwrap();
    folder.write("small.ktx2", encoded.bytes);
    let study = |more: &[&str]| {
        let ran = folder.run(&[&["--json", "--study"][..], more].concat()).succeeded();
        conforms(&ran.json());
        ran.json()
    };
    let throughput = study(&["throughput", "small.ktx2"]);
    assert_eq!(throughput["rows"].as_array().unwrap().len(), 6);
    assert!(throughput["rows"].as_array().unwrap().iter().all(|row| row["shader"].as_f64().unwrap() > 1e4));
    let images = study(&["images", "synth:lewis?kd=0.5&ks=0.1&n=4", "--out", "cloth"]);
    let row = &images["rows"][0];
    let mean = |key: &str| row[key][0].as_f64().unwrap();
    assert!(mean("table") < mean("shader") && mean("shader") < 1.3, "{row}");
    let drawn: Vec<String> = folder.files("cloth").into_keys().collect();
    assert_eq!(drawn, ["cloth-1-pack.png", "cloth-1-pixels.png", "cloth-1-vertices.png"]);
    let detail = study(&["level-of-detail", "small.ktx2", "--small", "--out", "frames"]);
    assert_eq!(detail["levels"].as_array().unwrap().len(), 3);
    let variance = |key: &str| detail[key]["variance"].as_f64().unwrap();
    assert!(variance("by_distance") < variance("finest"), "{detail}");
    assert_eq!(folder.files("frames").len(), 18);
    let frame = study(&["frame-time", "synth:lambert", "synth:ggx?alpha=0.3", "--small"]);
    assert!(frame["surface"].as_u64().unwrap() > 1000 && frame["look_ups"].as_array().unwrap().len() == 4, "{frame}");
    let times = frame["forward"].as_array().unwrap().iter().map(|row| &row["seconds"]);
    assert!(times.chain([&frame["points"], &frame["lobes"]]).all(|time| time.as_f64() > Some(0.0)), "{frame}");
    let reliefs = frame["reliefs"]["rows"].as_array().unwrap();
    assert_eq!(reliefs.len(), 10);
    assert!(
        reliefs.iter().all(|row| row["seconds"].as_f64() > Some(0.0) && row["bytes"].as_u64() > Some(0)),
        "{frame}"
    );
}

/// Comparison of codecs, with a script instead of Python whose compressor copies its input and whose networks are files of
/// weights.
#[cfg(unix)]
#[test]
fn the_study_of_codecs() {
    use std::os::unix::fs::PermissionsExt;
    if !has_adapter() {
        return;
    }
    let folder = folder();
    let script = folder.path().join("python");
    let text = "#!/bin/sh\nif [ \"$1\" = -c ]; then [ -z \"$3\" ] || cat \"$3\"; exit; fi\ncp \"$2\" \"$3/copy.f32\"\necho zfp 0.1 4321 0.25 copy.f32\n";
    std::fs::write(&script, text).unwrap();
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).unwrap();
    let python = script.to_str().unwrap();
    let material = "synth:ggx?kd=0.3,0.1,0.05&alpha=0.2";
    let bench = ["--study", "codecs", material];
    // Any weights, so that the study compares its shader with the network.
    let weights: Vec<f32> = (0..675).map(|k| 0.3 * (1.7 * k as f32).sin()).collect();
    std::fs::create_dir(folder.path().join("nets")).unwrap();
    folder.write(&format!("nets/{material}.h5"), weights.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>());
    let with = ["--json", "--out", "figures", "--peers", python, "--networks", "nets"];
    let ran = folder.run(&[&bench[..], &with].concat()).succeeded();
    let study = ran.json();
    conforms(&study);
    let rows = study["materials"][0]["rows"].as_array().unwrap();
    let of = |codec: &str| -> Vec<&serde_json::Value> { rows.iter().filter(|row| row["codec"] == codec).collect() };
    let least =
        |codec: &str| of(codec).iter().map(|row| row["delta_e"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!([of("table").len(), of("factored").len(), of("wavelet").len()], [10, 10, 3]);
    assert_eq!([of("bc6h").len(), of("bc7").len(), of("zfp").len(), of("ggx").len()], [8, 4, 5, 1]);
    let [network] = of("neural")[..] else { panic!("one network") };
    assert_eq!([&network["bytes_on_gpu"], &network["fetches"]], [2700, 0]);
    let error = network["delta_e"].as_f64().unwrap();
    assert!(error > 1.0 && network["shader"].as_f64().unwrap() > 1e4, "{network}");
    assert!(of("table").iter().any(|row| row["bytes_on_gpu"].as_u64().unwrap() <= 1350));
    // A model of the kind that is fitted is found; nodes that lost nothing are as close as tables.
    assert!(least("ggx") < 0.01 && least("zfp") < 1.1 * least("table"), "{} {}", least("ggx"), least("zfp"));
    assert!(least("bc6h") < 1.0 && least("bc7") < 1.0);
    assert!(of("table").iter().all(|row| row["shader"].as_f64().unwrap() > 1e4 && row["sampled"] == true));
    assert!(of("zfp").iter().all(|row| row["bytes_on_disk"] == 4321 && row["sampled"] == false));
    let figure = std::fs::read_to_string(folder.path().join("figures/codecs.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.contains("factored") && figure.contains("alpha=0.2"));
    for (name, expected) in [("nets", "found 674 weights, expected 675"), ("none", "no network of any material")] {
        folder.write(&format!("nets/{material}.h5"), vec![0u8; 2696]);
        let wrong = folder.run(&[&bench[..], &["--peers", python, "--networks", name]].concat());
        assert!(wrong.code == 3 && wrong.stderr.contains(expected), "{} {}", wrong.code, wrong.stderr);
    }
    let alone = folder.run(&[&bench[..], &["--networks", "nets"]].concat());
    assert!(alone.code == 2 && alone.stderr.contains("--networks needs --peers"), "{}", alone.stderr);
    let wrong = folder.run(&[&bench[..], &["--peers", "no-such-python"]].concat());
    assert!(wrong.code == 2 && wrong.stderr.contains("--peers no-such-python: "), "{} {}", wrong.code, wrong.stderr);
}

/// Stripes around the sky, bright above.
fn sky(folder: &Folder, name: &str) {
    let image = image::Rgb32FImage::from_fn(64, 32, |x, y| {
        let stripe = if (x / 4) % 2 == 0 { 1.0 } else { 0.2 };
        image::Rgb([stripe, 0.8 * stripe, if y < 16 { 1.5 } else { 0.1 }])
    });
    image::DynamicImage::ImageRgb32F(image).save(folder.path().join(name)).unwrap();
}

#[test]
fn studies_of_adaptive_shading() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let study = |name: &str, more: &[&str]| {
        let small = ["--study", name, "synth:ggx?alpha=0.2", "--pixels", "64", "--truth", "64"];
        let small = [&small[..], &["--environment", "sky.exr"], more].concat();
        let report = folder.run(&[&small[..], &["--json"]].concat()).succeeded().json();
        conforms(&report);
        let text = folder.run(&small).succeeded().stdout;
        assert!(text.contains("synth:ggx?alpha=0.2") && text.lines().count() > 3, "{text}");
        report["rows"].clone()
    };
    let fourier = study("pixel-bandwidth", &["--out", "maps"]);
    assert!(fourier[0]["windows"].as_u64() > Some(3), "{fourier}");
    assert!(fourier[0]["deviation"]["points"].as_u64() > Some(3), "{fourier}");
    // Figure 12: six maps side by side.
    let maps = image::open(folder.path().join("maps/bandwidth-synth-ggx-alpha-0.2.png")).unwrap();
    assert!(maps.height() == 64 && maps.width() > 6 * 64, "{} x {}", maps.width(), maps.height());
    // Figure 6: the rendering, the maximum and the mean. A maximum demands more.
    let combining = image::open(folder.path().join("maps/combining-synth-ggx-alpha-0.2.png")).unwrap();
    assert!(combining.height() == 64 && combining.width() > 3 * 64, "{} x {}", combining.width(), combining.height());
    for of in ["mean_and_maximum", "at_full_resolution"] {
        let [mean, maximum] = [0, 1].map(|k| fourier[0][of][k].as_f64().unwrap());
        assert!(maximum > 1.2 * mean && mean > 0.0, "{of}: {mean}, {maximum}");
    }
    let directions = study("bandwidth-directions", &[]);
    let errors: Vec<f64> =
        directions[0]["rows"].as_array().unwrap().iter().map(|row| row["psnr"].as_f64().unwrap()).collect();
    // Figure 13: within 0.3 dB.
    assert!(errors.len() == 4 && errors.iter().all(|psnr| (psnr - errors[3]).abs() < 0.3), "{errors:?}");
    let antialiasing = study("antialiasing", &[]);
    assert_eq!(antialiasing[1]["rows"][2]["points"], 16);
    // Figure 10.
    for row in antialiasing.as_array().unwrap() {
        assert!(["shaded", "samples"].iter().all(|cost| row["exponents"][cost].as_f64().unwrap() < 0.7), "{row}");
        let samples: Vec<u64> =
            row["budgets"].as_array().unwrap().iter().map(|budget| budget["samples"].as_u64().unwrap()).collect();
        assert!(samples.windows(2).all(|pair| pair[0] < pair[1]) && row["line"].is_object(), "{row}");
    }
    for (arguments, expected) in [
        (&["--study", "adaptive", "--pixels", "8"][..], "--pixels: found 8, expected 32 to 2048"),
        (&["--study", "adaptive", "--truth", "8"], "--truth: found 8, expected 16 to 65536"),
        (&["--study", "rays", "--truth", "64"], "--truth: found with another study, expected with --study adaptive"),
    ] {
        let ran = folder.run(arguments);
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}

/// Methods under an environment: all reports conform, errors fall with cost, and needed costs are within the curves.
#[test]
fn the_study_of_shading_methods() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let study = |material: &str| {
        let arguments =
            ["--study", "adaptive", material, "--environment", "sky.exr", "--small", "--json", "--out", "sheets"];
        let report = folder.run(&arguments).succeeded().json();
        conforms(&report);
        report
    };
    let report = study("synth:ggx?alpha=0.3");
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2, "{report}");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for row in rows {
        assert!(number(&row["truth_psnr"]) > 35.0, "{row}");
        for method in row["methods"].as_array().unwrap() {
            let points = method["curves"].as_array().unwrap().iter().flat_map(|c| c["points"].as_array().unwrap());
            let most = points.clone().map(|point| number(&point["samples"])).fold(0.0, f64::max);
            assert!(most > 0.0 && most <= 32.0, "{method}");
            let best = points.map(|point| number(&point["psnr"])).fold(0.0, f64::max);
            assert_eq!(best, number(&method["best"][1]), "{method}");
            let needed = &method["needed"][1];
            assert_eq!(needed.is_null(), best < 30.0, "{method}");
            assert!(needed.is_null() || number(&needed["samples"]) <= most, "{method}");
        }
        let of = |name: &str| row["methods"].as_array().unwrap().iter().find(|m| m["method"] == name).unwrap();
        // Filtered samples need fewer than others for the smaller PSNR.
        let samples = |name: &str| of(name)["needed"][0]["samples"].as_f64().unwrap_or(f64::INFINITY);
        assert!(samples("filtered") < samples("forward"), "{row}");
        // Figure 14: at its own time, adaptive shading has the error, or a smaller one of another caution.
        for (at, target) in [25.0, 30.0].into_iter().enumerate() {
            let (needed, error) = (&of("adaptive")["needed"][at], &of("adaptive")["at_equal_time"][at]);
            assert_eq!(needed.is_null(), error.is_null(), "{row}");
            assert!(error.is_null() || number(error) > target - 1e-6, "{row}");
        }
        // More Gaussians are no worse for a lobe with tails.
        let gaussians = of("gaussians")["curves"][0]["points"].as_array().unwrap();
        let [first, last] = [&gaussians[0], &gaussians[gaussians.len() - 1]].map(|point| number(&point["psnr"]));
        assert!(last > first - 0.5 && first > 20.0, "{gaussians:?}");
    }
    assert!(std::fs::read_dir(folder.path().join("sheets")).unwrap().count() > 0);
    let summary = report["summary"].as_array().unwrap();
    let wins: f64 = summary.iter().map(|method| number(&method["targets"][0]["fewest_samples"])).sum();
    assert_eq!((summary.len(), wins), (12, 2.0), "{report}");
    // Anisotropic materials have lobes, too.
    let velvet = study("synth:velvet");
    for row in velvet["rows"].as_array().unwrap() {
        let lobes = row["methods"].as_array().unwrap().iter().find(|m| m["method"] == "lobes").unwrap();
        assert!(!lobes["curves"][0]["points"].as_array().unwrap().is_empty(), "{lobes}");
    }
    let text = folder.run(&["--study", "adaptive", "synth:velvet", "--small"]).succeeded().stdout;
    for expected in
        ["synth:velvet", "forward", "Gaussians", "quarter, filt.", "FLIP 0.15", "gain in time", "equal time"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}
