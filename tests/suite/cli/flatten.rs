//! `brdfc flatten`, from every kind of input.

mod reflectance;
mod trees;
mod vdim;

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use brdfc_flat_btf::encode::{FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ReliefForm, ValueSource, encode};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_formats::flat_btf::factored::FactoredHeader;
use brdfc_jobs::flatten::{MesoOptions, material_list, open_appearance, open_asset, open_geometry};
use serde_json::Value;

/// Small enough for seconds: 7 views and lights.
const SMALL: [&str; 4] = ["--texels", "16", "--views", "grid:2x6@50"];
/// Components of views and lights, also for known materials.
const FACTORS: [&str; 2] = ["--reflectance", "factors"];

fn flatten(folder: &Folder, arguments: &[&str]) -> Ran {
    // Images have their own views.
    let small: Vec<&str> = match arguments.first() {
        Some(&"images") => {
            SMALL.iter().filter(|option| !["--views", "grid:2x6@50"].contains(option)).copied().collect()
        }
        _ => SMALL.to_vec(),
    };
    folder.run(&[&["flatten"], arguments, &small, &["--json", "-j", "2"]].concat())
}

fn report(ran: Ran) -> Value {
    let report = ran.succeeded().json();
    conforms("flatten", &report);
    report
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// The file of a flat BTF.
fn file(folder: &Folder, name: &str) -> FlatBtfFile {
    let files = folder.files(name);
    assert_eq!(files.len(), 1, "{:?}", files.keys());
    FlatBtfFile::from_bytes(files.values().next().unwrap()).unwrap()
}

#[test]
fn every_structure_is_one_file() {
    let folder = Folder::new();
    for (name, sheets, limit) in [("button", 3, 10.0), ("folds", 3, 14.0), ("knit", 1, 6.0), ("sponge", 1, 7.5)] {
        let surface = format!("synth:{name}?resolution=48");
        let report = report(flatten(&folder, &[&surface, "-o", name]));
        let length = std::fs::metadata(folder.path().join(name).join(format!("{name}.ktx2"))).unwrap().len();
        assert_eq!(report["bytes"], length);
        assert_eq!(report["report"]["parameterisation"]["flipped"], 0);
        let layers = &report["report"]["layers"];
        assert_eq!((&layers["sheets"], &layers["open"]), (&sheets.into(), &0.into()), "{name}: {layers}");
        let errors = &report["report"]["errors"];
        // With 16 x 16 texels there are few.
        assert!(number(&errors["from_surface"]["mean"]) < limit, "{name}: {errors}");
        assert!(errors.get("from_images").is_none(), "{name}: {errors}");
        let within: Value = serde_json::from_str(&file(&folder, name).report).unwrap();
        assert_eq!(within["report"], report["report"]);
        let mut output = report.clone();
        output.as_object_mut().unwrap().remove("seconds");
        conforms("flat-btf", &output);
        assert_eq!(folder.run(&["info", name, "--json"]).succeeded().json(), output);
    }
}

#[test]
fn texels_are_a_power_of_two() {
    let folder = Folder::new();
    for (option, value) in
        [("--texels", "24"), ("--texels", "2"), ("--texels", "4096"), ("--flat-texels", "24"), ("--flat-texels", "x")]
    {
        let ran = folder.run(&["flatten", "synth:knit?resolution=24", "-o", "never", option, value]);
        let words = [format!("brdfc: {option}: found "), "expected a power of two from 4 to 2048".to_owned()];
        assert!(ran.code == 2 && words.iter().all(|words| ran.stderr.contains(words)), "{option} {value}: {ran:?}");
    }
    assert!(folder.files(".").is_empty());
    for texels in ["4", "8"] {
        let ran = folder.run(&["flatten", "synth:knit?resolution=24", "-o", "knit", "--texels", texels, "--json"]);
        let settings = &report(ran)["settings"];
        assert_eq!([&settings["texels"], &settings["flat_texels"]].map(Value::to_string), [texels; 2]);
    }
}

/// A ridge along y over the tile, whose profile has these x and z.
fn ridge(profile: &[[f64; 2]]) -> String {
    let vertices = |y: f64| profile.iter().map(move |[x, z]| format!("v {x} {y} {z}\n"));
    let count = profile.len();
    let faces = (0..2 * count).filter(|k| k % count < count - 1).map(|k| {
        let (first, next) = (k + 1, k + 1 + count);
        format!("f {first} {} {} {next}\n", first + 1, next + 1)
    });
    [0.0, 0.5, 1.0].into_iter().flat_map(vertices).chain(faces).collect()
}

#[test]
fn walls_and_overhangs() {
    let folder = Folder::new();
    let slope = ridge(&[[0.0, 0.0], [0.25, 0.0], [0.4, 0.2], [0.6, 0.2], [0.75, 0.0], [1.0, 0.0]]);
    let wall = ridge(&[[0.0, 0.0], [0.25, 0.0], [0.25, 0.2], [0.75, 0.2], [0.75, 0.0], [1.0, 0.0]]);
    let ledge = ridge(&[[0.0, 0.0], [0.45, 0.0], [0.25, 0.15], [0.5, 0.25], [0.75, 0.15], [0.55, 0.0], [1.0, 0.0]]);
    for (name, mesh, sheets, limit) in [("slope", slope, 1, 1.5), ("wall", wall, 1, 5.0), ("ledge", ledge, 3, 6.5)] {
        folder.write(&format!("{name}.obj"), mesh);
        for form in ["auto", "factors"] {
            let input = format!("{name}.obj");
            let matte = [input.as_str(), "-o", name, "--material", "synth:lambert?kd=0.4", "--reflectance", form];
            let report = &report(flatten(&folder, &matte))["report"];
            let (layers, errors) = (&report["layers"], &report["errors"]["from_surface"]);
            assert_eq!(layers["sheets"], sheets, "{name}");
            // Each line cuts the surface as often as sheets are stored.
            assert_eq!((&layers["simplified"], &layers["open"]), (&0.into(), &0.into()), "{name}: {layers}");
            for figure in ["mean", "p95", "max"] {
                assert!(number(&errors[figure]).is_finite(), "{name}, {form}: {errors}");
            }
            assert!(number(&errors["mean"]) < limit, "{name}, {form}: {errors}");
            assert_eq!(report["parameterisation"]["flipped"], 0, "{name}");
        }
    }
}

/// The report, `info` and `render` agree on the bytes on a GPU.
#[test]
fn graphics_memory_is_that_of_the_bindings() {
    let folder = Folder::new();
    let knit = ["synth:knit?resolution=24", "-o", "knit", "--lights", "grid:3x8@60"];
    let checked = |more: &[&str]| -> Value {
        let report = report(flatten(&folder, &[&knit[..], more].concat()));
        let total = report["gpu_bytes"].as_u64().unwrap();
        let images = report["images"].as_object().unwrap();
        assert_eq!(images.values().map(|bytes| bytes.as_u64().unwrap()).sum::<u64>(), total);
        assert_eq!(file(&folder, "knit").gpu_bytes(), total);
        #[cfg(feature = "render")]
        if crate::common::has_adapter() {
            let drawn = folder.run(&["render", "knit", "--size", "16x16", "--json"]).succeeded().json();
            assert_eq!(drawn["parts"][0]["bytes_on_gpu"].as_u64(), Some(total), "{drawn}");
        }
        report
    };
    let of = |report: &Value, image: &str| report["images"][image].as_u64().unwrap();
    let smaller = checked(&[]);
    // Texels of all mipmap levels of 16 x 16: one byte; from 8 x 8 on four for two halves.
    let texels = (0..5).map(|level| (16u64 >> level).pow(2)).sum::<u64>();
    let halves = 4 * (texels - 16 * 16);
    assert_eq!((of(&smaller, "flat_btf_heights"), of(&smaller, "flat_btf_displacements")), (texels, halves));
    // A sheet of what hangs over and one of its underside.
    let folds = report(flatten(&folder, &["synth:folds?resolution=24", "-o", "folds"]));
    assert_eq!((of(&folds, "flat_btf_heights"), of(&folds, "flat_btf_displacements")), (4 * texels, 3 * halves));
    let budget = checked(&[&FACTORS[..], &["--max-bytes", "20KiB"]].concat());
    let factors: u64 = ["factored_basis", "factored_tables", "factored_weights", "factored_residual"]
        .iter()
        .filter_map(|image| budget["images"][image].as_u64())
        .sum();
    assert!(factors <= 20 << 10 && budget["report"]["factored"]["gpu_bytes"] == factors, "{budget}");
    // If no factorisation meets the limit, the best one is selected and reported.
    let missed = flatten(&folder, &[&knit[..], &FACTORS, &["--max-delta-e", "0.00001"]].concat());
    assert!(
        missed.code == 1
            && missed.stderr.contains("--max-delta-e: found a mean ΔE of ")
            && missed.stderr.contains(" after 7 trials, expected at most 0.00001"),
        "{}",
        missed.stderr
    );
    assert!(missed.json()["report"]["factored"]["errors"]["seen_mean"].as_f64().unwrap() > 1e-5);
    let refused = flatten(&folder, &[&knit[..], &FACTORS, &["--max-bytes", "1KiB"]].concat());
    assert!(refused.code == 2 && refused.stderr.contains("--max-bytes: found 1024, expected "), "{}", refused.stderr);
}

/// The codec alone, with scratch storage in memory, makes the same file as the program.
#[test]
fn files_hold_what_the_codec_makes() {
    let folder = Folder::new();
    let options = MesoOptions {
        geometry: Some("synth:button?resolution=24".into()),
        tile: 1.0,
        height_scale: 0.1,
        height_offset: 0.0,
        materials: Vec::new(),
        colour: None,
        weights: None,
    };
    let set = DirectionSet::grid(2, 6, 50.0).unwrap();
    let recipe = |reflectance| FlattenRecipe {
        relief: ReliefForm::Layers,
        texels: 16,
        flat_texels: 16,
        views: set.clone(),
        lights: set.clone(),
        fill: FillMethod::Poisson,
        bounces: 0,
        reflectance,
        target: FactoredTarget::Error(0.7),
    };
    for (name, reflectance) in
        [("auto", Reflectance::Auto), ("brdf", Reflectance::Brdf), ("factors", Reflectance::Factors)]
    {
        let geometry = open_geometry(&options).unwrap();
        let materials = material_list(&options, &geometry).unwrap();
        let appearance = open_appearance(&options, &materials, &()).unwrap();
        let values = ValueSource::Computed(&appearance);
        let scratch = MemoryScratch::default();
        let input = FlatInput { mesh: geometry.mesh, repairs: None, values };
        let made = encode(input, &recipe(reflectance), &scratch, &()).unwrap();
        flatten(&folder, &["synth:button?resolution=24", "-o", name, "--reflectance", name]).succeeded();
        let (file, asset) = open_asset(folder.path().join(name)).unwrap();
        assert!(file.decoder == made.decoder, "{name}");
        assert_eq!(file.directions.is_some(), reflectance == Reflectance::Factors, "{name}");
        assert_eq!(asset.about.report, made.report);
    }
}

#[test]
fn a_matte_plane_is_exact() {
    let folder = Folder::new();
    folder.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let plane = ["plane.obj", "--material", "synth:lambert?kd=0.5", "-o", "plane"];
    for form in ["brdf", "factors"] {
        let report = report(flatten(&folder, &[&plane[..], &["--reflectance", form]].concat()));
        let errors = &report["report"]["errors"]["from_surface"];
        assert!(number(&errors["max"]) < 0.25, "{form}: {errors}");
        assert_eq!(report["report"]["layers"]["sheets"], 1, "{form}");
        if form == "factors" {
            assert!((number(&report["report"]["seen"]) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    let mut forms = Vec::new();
    for form in ["brdf", "factors"] {
        for (out, jobs) in [("one", "1"), ("three", "3")] {
            let input = ["flatten", "synth:folds?resolution=32", "--name", "folds", "-o", out, "-j", jobs];
            folder.run(&[&input[..], &SMALL, &["--reflectance", form]].concat()).succeeded();
        }
        let (one, three) = (folder.files("one"), folder.files("three"));
        assert!(one.len() == 1 && one.values().eq(three.values()), "{form}: {}", one.len());
        forms.push(one);
    }
    assert!(forms[0] != forms[1]);
}

#[test]
fn meshes_written_by_synth_and_height_maps() {
    let folder = Folder::new();
    for kind in ["obj", "ply"] {
        let mesh = format!("folds.{kind}");
        folder.run(&["synth", "folds?resolution=32", "-o", &mesh]).succeeded();
        let report = report(flatten(&folder, &[&mesh, "-o", kind, "--material", "synth:lambert?kd=0.4"]));
        assert_eq!(report["report"]["repaired"]["triangles"], 2 * 32 * 32);
        assert!(number(&report["report"]["repaired"]["merged_vertices"]) > 60.0);
        assert_eq!(report["source"], mesh);
    }
    let mut bytes = Vec::new();
    let heights: Vec<u8> = (0..24 * 24).map(|i| if (i % 24) < 12 { 0 } else { 255 }).collect();
    image::write_buffer_with_format(
        &mut std::io::Cursor::new(&mut bytes),
        &heights,
        24,
        24,
        image::ColorType::L8,
        image::ImageFormat::Png,
    )
    .unwrap();
    folder.write("step.png", bytes);
    let report = report(flatten(&folder, &["step.png", "-o", "step", "--height-scale", "0.2"]));
    let heights = &report["report"]["heights"];
    assert!((number(&heights[0])).abs() < 1e-9 && (number(&heights[1]) - 0.2).abs() < 1e-9, "{heights}");
}

#[test]
fn height_maps_of_too_many_pixels_are_refused_before_any_work() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    image::write_buffer_with_format(
        &mut std::io::Cursor::new(&mut bytes),
        &vec![0; 1025 * 1024],
        1025,
        1024,
        image::ColorType::L8,
        image::ImageFormat::Png,
    )
    .unwrap();
    folder.write("large.png", bytes);
    let ran = flatten(&folder, &["large.png", "-o", "large"]);
    let expected = "large.png: PNG: found 1025 x 1024 pixels, expected 4 to 8192 per side, and at most 1048576";
    assert!(ran.code == 3 && ran.stderr.contains(expected), "{ran:?}");
    assert!(!folder.path().join("large").exists());
}

#[test]
fn an_ordinary_btf_goes_out_and_comes_in_again() {
    let folder = Folder::new();
    let sponge = "synth:sponge?resolution=48&height=0.6";
    let images = ["--write-images", "images", "--image-format", "exr", "--flat-texels", "32"];
    let first = report(flatten(&folder, &[&[sponge, "-o", "first"], &images[..], &FACTORS].concat()));
    assert_eq!(folder.files("images").len(), 49);
    let measured = |more: &[&str]| report(flatten(&folder, &[&["images"], more, &["--flat-texels", "32"]].concat()));
    let second = measured(&["--geometry", sponge, "-o", "second"]);
    assert_eq!(second["settings"]["views"][0], "of the images");
    assert_eq!(second["settings"]["views"][1], 7);
    let seen = |report: &Value| number(&report["report"]["seen"]);
    assert!((seen(&first) - seen(&second)).abs() < 1e-9);
    assert_eq!(second["report"]["reflectance"], "factors");
    let plane = measured(&["-o", "plane"]);
    assert_eq!(plane["source"], "images over the plane");
    assert_eq!(plane["report"]["heights"], serde_json::json!([0.0, 0.0]));
    assert!((seen(&plane) - 1.0).abs() < 1e-12);
    for (name, made) in [("second", &second), ("plane", &plane)] {
        let errors = &made["report"]["errors"];
        assert!(number(&errors["from_images"]["mean"]) < 2.0, "{name}: {errors}");
        assert!(errors.get("from_surface").is_none(), "{name}: {errors}");
    }
    // Over a plane the same images keep their parallax in the texels, so between the views they are less similar.
    let error = |other: &str| {
        let compared = folder.run(&["compare", "first", other, "--json"]).succeeded().json();
        number(&compared["errors"]["mean"])
    };
    assert!(error("second") < 0.7 * error("plane"), "{} {}", error("second"), error("plane"));
}

#[test]
fn settings_are_recorded_as_they_were_given() {
    let folder = Folder::new();
    folder.write("sets/few.csv", "index,theta_deg,phi_deg\n0,0,0\n1,30,0\n2,30,120\n3,30,240\n");
    let knit = ["synth:knit?resolution=16", "-o", "a", "--lights", "sets/few.csv", "--no-supercompression"];
    let settings = |more: &[&str]| report(flatten(&folder, &[&knit[..], more].concat()))["settings"].clone();
    let given = settings(&["--max-delta-e", "2"]);
    assert_eq!((&given["views"][0], &given["lights"][0]), (&"grid:2x6@50".into(), &"few.csv".into()));
    assert_eq!((&given["views"][1], &given["lights"][1]), (&7.into(), &4.into()));
    assert_eq!((&given["reflectance"], &given["supercompression"]), (&"auto".into(), &false.into()));
    assert_eq!(given["target"], serde_json::json!({ "error": 2.0 }));
    let other = settings(&["--max-bytes", "30KiB", "--reflectance", "factors", "--flat-texels", "8"]);
    assert_eq!(other["target"], serde_json::json!({ "bytes": 30 << 10 }));
    assert_eq!((&other["reflectance"], &other["flat_texels"]), (&"factors".into(), &8.into()));
    assert_eq!(settings(&[])["target"], serde_json::json!({ "error": 0.7 }));
}

#[test]
fn options_change_what_they_say() {
    let folder = Folder::new();
    let parts = |name: &str, more: &[&str]| {
        let button = ["synth:button?resolution=40", "-o", name];
        let report = report(flatten(&folder, &[&button[..], &FACTORS, more].concat()));
        (report, file(&folder, name).decoder.into_parts())
    };
    let (_, plain) = parts("a", &[]);
    let (filled, other) = parts("b", &["--fill", "push-pull"]);
    assert_eq!(filled["settings"]["fill"], "push-pull");
    assert!(plain.reflectance != other.reflectance && plain.relief == other.relief);
    let (_, coarse) = parts("c", &["--flat-texels", "8"]);
    assert_eq!((plain.reflectance.size(), coarse.reflectance.size()), (16, 8));
    assert!(plain.relief == coarse.relief);
    let (_, lit) = parts("d", &["--lights", "grid:2x4@50"]);
    let directions = |header: &FactoredHeader| (header.views.len(), header.lights.len());
    assert_eq!(directions(plain.reflectance.factors().unwrap().header()), (7, 7));
    assert_eq!(directions(lit.reflectance.factors().unwrap().header()), (7, 5));
}

/// Images of a raw flat BTF that do not fit into memory are an error before any work.
#[test]
fn a_raw_flat_btf_may_be_too_large() {
    let folder = Folder::new();
    let sets = ["--views", "grid:32x64@80", "--lights", "grid:32x64@80", "--flat-texels", "1024"];
    let flatten =
        ["flatten", "synth:button?resolution=16", "-o", "out", "--reflectance", "brdf", "--write-flat", "raw"];
    let refused = folder.run(&[&flatten[..], &sets].concat());
    assert!(refused.code == 2 && refused.stderr.contains("memory: found"), "{refused:?}");
    assert!(!folder.path().join("raw").exists() && !folder.path().join("out").exists());
}

/// The raw flat BTF: texels that a view sees hold the surface's values, and a displaced reference leads to what it sees.
#[test]
fn the_raw_flat_btf_goes_out() {
    let folder = Folder::new();
    let knit = ["synth:knit?resolution=48", "-o", "knit", "--write-flat", "raw", "--fill", "push-pull"];
    flatten(&folder, &[&knit[..], &FACTORS].concat()).succeeded();
    let files: Vec<String> = folder.files("raw").into_keys().collect();
    let of = |kind: &str| files.iter().filter(|name| name.starts_with(kind)).cloned().collect::<Vec<_>>();
    assert_eq!([of("flat/").len(), of("masks/").len(), of("displacements/").len(), files.len()], [49, 7, 7, 64]);
    let channels = |name: &str| -> Vec<Vec<f32>> {
        use exr::prelude::{ReadChannels, ReadLayers};
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        let image =
            reader.first_valid_layer().all_attributes().from_file(folder.path().join("raw").join(name)).unwrap();
        image.layer_data.channel_data.list.iter().map(|channel| channel.sample_data.values_as_f32().collect()).collect()
    };
    // The view along the normal sees its own reference; it sees all texels of a height field.
    let above = of("displacements/").into_iter().find(|name| name.contains("tv000_pv000")).unwrap();
    assert!(channels(&above).iter().flatten().all(|moved| *moved == 0.0));
    assert!(channels(&above.replace("displacements", "masks")).iter().flatten().all(|seen| *seen == 1.0));
    // The control: slanted views are displaced, and see less.
    let slanted = of("displacements/").pop().unwrap();
    assert!(channels(&slanted).iter().flatten().any(|moved| moved.abs() > 0.01));
    let hidden = of("masks/").iter().map(|mask| channels(mask)[0].iter().filter(|seen| **seen == 0.0).count()).max();
    assert!(hidden > Some(0), "{hidden:?}");
    // Parameters of the reference cover the tile.
    let reference = channels("reference.exr");
    assert_eq!(reference.len(), 2);
    assert!(reference.iter().flatten().all(|c| (-0.5..1.5).contains(c)));
    let lit = of("flat/").iter().filter(|image| channels(image).iter().flatten().any(|value| *value > 0.0)).count();
    assert_eq!(lit, 49);
}

/// A failure after the first parts were made leaves the existing asset unchanged.
#[test]
fn a_failed_run_leaves_the_asset_as_it_was() {
    let folder = Folder::new();
    let sponge = "synth:sponge?resolution=48&height=0.6";
    flatten(&folder, &[sponge, "-o", "first", "--write-images", "images"]).succeeded();
    flatten(&folder, &["images", "-o", "asset"]).succeeded();
    let before = folder.files("asset");
    let image = folder.files("images").into_keys().next_back().unwrap();
    let path = folder.path().join("images").join(image);
    let whole = std::fs::read(&path).unwrap();
    // The header of the image is read before the work, its pixels in the middle of it.
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let ran = flatten(&folder, &["images", "-o", "asset", "--geometry", "synth:knit?resolution=32"]);
    assert!(ran.code == 3 && ran.stderr.contains(".png"), "{ran:?}");
    assert!(folder.files("asset") == before);
    // A new one does not appear either.
    let ran = flatten(&folder, &["images", "-o", "other"]);
    assert_eq!(ran.code, 3, "{ran:?}");
    assert_eq!(folder.files("other").len(), 0);
}

/// The file has a name that packs have, too.
#[test]
fn inputs_are_not_written_over() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("knit")).unwrap();
    folder
        .run(&["encode", "synth:lambert", "-o", "knit/knit.ktx2", "--codec", "table", "--max-bytes", "1KiB"])
        .succeeded();
    let pack = std::fs::read(folder.path().join("knit/knit.ktx2")).unwrap();
    let ran = folder.run(&["flatten", "synth:knit", "--material", "knit/knit.ktx2", "-o", "knit"]);
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("--out: would overwrite the input knit/knit.ktx2; choose"), "{}", ran.stderr);
    assert!(std::fs::read(folder.path().join("knit/knit.ktx2")).unwrap() == pack);
}

#[test]
fn directions_are_checked_before_the_work() {
    let folder = Folder::new();
    // Azimuths of any sign, and a full turn, are directions.
    folder.write("turns.csv", "index,theta_deg,phi_deg\n0,0,0\n1,40,-90\n2,40,360\n3,30,200\n");
    let knit = ["flatten", "synth:knit?resolution=16", "--texels", "8"];
    folder.run(&[&knit[..], &FACTORS, &["-o", "turns", "--views", "turns.csv"]].concat()).succeeded();
    folder.write("steep.csv", "index,theta_deg,phi_deg\n0,0,0\n1,89.99,0\n");
    folder.write("near.csv", "index,theta_deg,phi_deg\n0,0,0\n1,40,10\n2,40,10.001\n");
    for (set, words) in [
        ("steep.csv", "polar angle: found 89.99"),
        ("near.csv", "direction: equal to the direction of line 3"),
        ("grid:64x64@80", "2048"),
    ] {
        // Also for a brdf, which has none.
        for form in ["brdf", "factors"] {
            let ran = folder.run(&[&knit[..], &["-o", "never", "--reflectance", form, "--views", set]].concat());
            assert!((2..=3).contains(&ran.code) && ran.stderr.contains(words), "{set}: {ran:?}");
            assert!(!folder.path().join("never").exists(), "{set}");
        }
    }
    let ran = folder.run(&[&knit[..], &["-o", "never", "--flat-texels", "1024", "--bounces", "1024"]].concat());
    assert!(ran.code == 2 && ran.stderr.contains("memory: found "), "{ran:?}");
}

#[test]
fn reliefs_that_rays_cannot_follow_are_refused() {
    let folder = Folder::new();
    let plane =
        |apex: &str| format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv {apex}\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    for (apex, words) in [("0.5 0.5 50", "expected at most 16 tiles above"), ("300 0.5 1", "an extent of 300 tiles")] {
        folder.write("spike.obj", plane(apex));
        let ran = flatten(&folder, &["spike.obj", "-o", "spike", "--material", "synth:lambert"]);
        assert!(ran.code == 3 && ran.stderr.contains("spike.obj: ") && ran.stderr.contains(words), "{ran:?}");
    }
}
