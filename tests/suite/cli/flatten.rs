//! `brdfc flatten`, from every kind of input.

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use brdfc_flat_btf::encode::{FlatInput, FlattenRecipe, Form, MemoryScratch, ValueSource, encode};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatValues, IndirectionHeader};
use brdfc_jobs::flatten::{MesoOptions, material_list, open_appearance, open_asset, open_geometry};
use brdfc_source::flat_btf::{open_flat_btf, open_flat_mask};
use serde_json::Value;

/// Small enough for seconds: 7 views and lights.
const SMALL: [&str; 8] = ["--texels", "16", "--views", "grid:2x6@50", "--indirection", "4x6", "--oversampling", "1"];

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

#[test]
fn every_structure_and_every_part() {
    let folder = Folder::new();
    const WHOLE: [&str; 9] =
        ["position", "normal", "diffuse", "reference", "indirection", "mask", "directions", "flat.000", "flat.006"];
    const SMALLER: [&str; 7] = ["position", "normal", "diffuse", "reference", "displacement", "mask", "basis"];
    let whole = ["--uncompressed"];
    for (name, options, parts, count, limit) in [
        ("button", &whole[..], &WHOLE[..], 14, 12.0),
        ("folds", &[], &SMALLER, 10, 13.0),
        ("knit", &[], &SMALLER, 10, 7.5),
        ("sponge", &[], &SMALLER, 10, 15.0),
    ] {
        let surface = format!("synth:{name}?resolution=48");
        let report = report(flatten(&folder, &[&[&surface[..], "-o", name], options].concat()));
        for part in parts {
            let file = report["parts"][part]["file"].as_str().unwrap_or_else(|| panic!("{part}: {report}"));
            assert_eq!(file, format!("{name}.{part}.ktx2"));
            let length = std::fs::metadata(folder.path().join(name).join(file)).unwrap().len();
            assert_eq!(report["parts"][part]["bytes"], length);
        }
        // Factors have shadows where that takes fewer bytes.
        let found = report["parts"].as_object().unwrap().len();
        assert!((if options.is_empty() { count - 1..=count } else { count..=count }).contains(&found), "{report}");
        assert_eq!(report["report"]["factored"].is_object(), options.is_empty());
        assert_eq!(report["report"]["parameterisation"]["flipped"], 0);
        let errors = &report["report"]["errors"];
        // At 16 x 16 texels, few.
        assert!(number(&errors["at_samples"]["mean"]) < limit, "{name}: {errors}");
        let listed: Value =
            serde_json::from_slice(&std::fs::read(folder.path().join(name).join(format!("{name}.json"))).unwrap())
                .unwrap();
        conforms("flat-btf", &listed);
        assert_eq!(listed["parts"], report["parts"]);
    }
}

/// The list, each part alone, and `render` agree on what a GPU has to hold.
#[test]
fn graphics_memory_is_that_of_the_bindings() {
    let folder = Folder::new();
    let knit = ["synth:knit?resolution=24", "-o", "knit", "--lights", "grid:3x8@60"];
    let checked = |more: &[&str]| -> Value {
        let report = report(flatten(&folder, &[&knit[..], more].concat()));
        let parts = report["parts"].as_object().unwrap();
        for (part, listed) in parts {
            // Away from its list.
            let file = format!("knit.{part}.ktx2");
            folder.write(&file, folder.read(&format!("knit/{file}")));
            let facts = folder.run(&["info", &file, "--json"]).succeeded().json();
            assert_eq!(facts["gpu_bytes"], listed["gpu_bytes"], "{part}");
        }
        #[cfg(feature = "render")]
        if crate::common::has_adapter() {
            let total: u64 = parts.values().map(|part| part["gpu_bytes"].as_u64().unwrap()).sum();
            let drawn = folder.run(&["render", "knit", "--size", "16x16", "--json"]).succeeded().json();
            assert_eq!(drawn["parts"][0]["bytes_on_gpu"].as_u64(), Some(total), "{drawn}");
        }
        report
    };
    let of = |report: &Value, part: &str| report["parts"][part]["gpu_bytes"].as_u64().unwrap();
    let whole = checked(&["--uncompressed"]);
    assert_eq!([of(&whole, "position"), of(&whole, "mask"), of(&whole, "normal")], [0, 0, 8 * 16 * 16]);
    // 17 lights take 5 x 4 tiles.
    assert_eq!(of(&whole, "flat.000"), 4 * 20 * 16 * 16);
    // Of each texel 4 x 7 samples of two bytes, and their ranges.
    let smaller = checked(&[]);
    assert_eq!(of(&smaller, "displacement"), 16 * 16 * (4 * 7 * 2 + 8));
    let total = |report: &Value| report["parts"].as_object().unwrap().keys().map(|part| of(report, part)).sum::<u64>();
    assert!(2 * total(&smaller) < total(&whole), "{} {}", total(&smaller), total(&whole));
    let budget = checked(&["--max-bytes", "20KiB"]);
    let factors: u64 =
        ["basis", "weights", "shadow"].iter().filter_map(|p| budget["parts"][p]["gpu_bytes"].as_u64()).sum();
    assert!(factors <= 20 << 10 && budget["report"]["factored"]["gpu_bytes"] == factors, "{budget}");
    // What nothing meets is kept, and said.
    let missed = flatten(&folder, &[&knit[..], &["--max-delta-e", "0.00001"]].concat());
    assert!(missed.code == 1 && missed.stderr.contains("of 14 that were tried; allowed 0.00001"), "{}", missed.stderr);
    assert!(missed.json()["report"]["factored"]["errors"]["seen_mean"].as_f64().unwrap() > 1e-5);
    let refused = flatten(&folder, &[&knit[..], &["--max-bytes", "1KiB"]].concat());
    assert!(refused.code == 2 && refused.stderr.contains("--max-bytes: found 1024; allowed "), "{}", refused.stderr);
}

/// The codec alone, with scratch storage in memory, makes what the program writes.
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
    let whole = FlattenRecipe {
        flat_texels: 16,
        indirection: IndirectionHeader {
            size: 16,
            zenith_samples: 4,
            azimuth_samples: 6,
            largest_angle: 80f64.to_radians() as f32,
        },
        oversampling: 1,
        views: set.clone(),
        lights: set,
        fill: FillMethod::Poisson,
        bounces: 0,
        rounds: 0,
        form: Form::Full,
        factor: None,
        compact: false,
    };
    let light = FlattenRecipe { form: Form::Light, compact: true, ..whole.clone() };
    let factored = FlattenRecipe { factor: Some(FactoredTarget::Error(0.7)), compact: true, ..whole.clone() };
    for (name, more, recipe) in
        [("factored", &[][..], factored), ("whole", &["--uncompressed"], whole), ("light", &["--form", "light"], light)]
    {
        let geometry = open_geometry(&options).unwrap();
        let materials = material_list(&options, &geometry).unwrap();
        let appearance = open_appearance(&options, &materials, &()).unwrap();
        let values = ValueSource::Computed(&appearance);
        let scratch = MemoryScratch::default();
        let input = FlatInput { mesh: geometry.mesh, repairs: None, values };
        let mut made = encode(input, &recipe, &scratch, &()).unwrap();
        if let Some(views) = &made.views {
            let views = (0..views.count()).map(|view| views.read(view, &scratch).unwrap());
            made.parts.values = FlatValues::Views(views.collect());
        }
        flatten(&folder, &[&["synth:button?resolution=24", "-o", name], more].concat()).succeeded();
        let path = folder.path().join(name);
        assert!(open_flat_btf(&path, recipe.form == Form::Full).unwrap() == made.parts, "{name}");
        assert_eq!(open_flat_mask(&path).unwrap(), Some(made.mask));
        assert_eq!(open_asset(&path).unwrap().expect("a list of parts").report, made.report);
    }
}

#[test]
fn a_matte_plane_is_exact() {
    let folder = Folder::new();
    folder.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let plane = ["plane.obj", "--material", "synth:lambert?kd=0.5", "-o", "plane"];
    let errors = |more: &[&str]| {
        let report = report(flatten(&folder, &[&plane[..], more].concat()));
        assert!((number(&report["report"]["seen"]) - 1.0).abs() < 1e-12);
        report["report"]["errors"].clone()
    };
    let [factored, whole] = [&[][..], &["--uncompressed"]].map(errors);
    for errors in [&factored, &whole] {
        for kind in ["at_samples", "light_form"] {
            assert!(number(&errors[kind]["max"]) < 0.25, "{errors}");
        }
    }
    // Views blend the cosines of lights that are 50 degrees apart; the base has that of the light itself.
    assert!((0.1..5.0).contains(&number(&whole["between_samples"]["mean"])), "{whole}");
    assert!(number(&factored["between_samples"]["max"]) < 0.5, "{factored}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for more in [&[][..], &["--uncompressed"]] {
        for (out, jobs) in [("one", "1"), ("three", "3")] {
            let input = ["flatten", "synth:folds?resolution=32", "--name", "folds", "-o", out, "-j", jobs];
            folder.run(&[&input[..], &SMALL, more].concat()).succeeded();
        }
        let (one, three) = (folder.files("one"), folder.files("three"));
        assert!(one.len() >= if more.is_empty() { 9 } else { 14 }, "{}", one.len());
        assert!(one.values().eq(three.values()) && one.len() == three.len());
    }
}

#[test]
fn meshes_written_by_synth_and_height_maps() {
    let folder = Folder::new();
    for kind in ["obj", "ply"] {
        let mesh = format!("folds.{kind}");
        folder.run(&["synth", "folds?resolution=32", "-o", &mesh]).succeeded();
        let report = report(flatten(&folder, &[&mesh, "-o", kind, "--material", "synth:lambert?kd=0.4"]));
        assert_eq!(report["report"]["mended"]["triangles"], 2 * 32 * 32);
        assert!(number(&report["report"]["mended"]["merged_vertices"]) > 60.0);
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
    let expected = "large.png: PNG: found 1025 x 1024 pixels; allowed 4 to 8192 per side, and at most 1048576";
    assert!(ran.code == 3 && ran.stderr.contains(expected), "{ran:?}");
    assert!(!folder.path().join("large").exists());
}

#[test]
fn an_ordinary_btf_goes_out_and_comes_in_again() {
    let folder = Folder::new();
    let sponge = "synth:sponge?resolution=48&height=0.6";
    let images = ["--write-images", "images", "--image-format", "exr", "--flat-texels", "32"];
    let first = report(flatten(&folder, &[&[sponge, "-o", "first"], &images[..]].concat()));
    assert_eq!(folder.files("images").len(), 49);
    let measured = |more: &[&str]| report(flatten(&folder, &[&["images"], more, &["--flat-texels", "32"]].concat()));
    let second = measured(&["--geometry", sponge, "-o", "second"]);
    assert_eq!(second["settings"]["views"][0], "of the images");
    assert_eq!(second["settings"]["views"][1], 7);
    let seen = |report: &Value| number(&report["report"]["seen"]);
    assert!((seen(&first) - seen(&second)).abs() < 1e-9);
    // Over a plane the same images keep their parallax in the texels: less of them fits together.
    let plane = measured(&["-o", "plane"]);
    assert_eq!(plane["source"], "images over the plane");
    assert_eq!(plane["report"]["heights"], serde_json::json!([0.0, 0.0]));
    assert!((seen(&plane) - 1.0).abs() < 1e-12);
    let error = |report: &Value| number(&report["report"]["errors"]["light_form"]["mean"]);
    assert!(error(&second) < error(&plane), "{} {}", error(&second), error(&plane));
}

#[test]
fn the_light_form_writes_no_views_and_the_same_colours() {
    let folder = Folder::new();
    for (out, form) in [("full", "full"), ("light", "light")] {
        flatten(&folder, &["synth:button?resolution=32", "-o", out, "--name", "b", "--form", form]).succeeded();
    }
    let (full, light) = (folder.files("full"), folder.files("light"));
    assert!(light.len() == 7 && full.len() > 8, "{} {}", light.len(), full.len());
    for part in ["b.diffuse.ktx2", "b.normal.ktx2", "b.displacement.ktx2"] {
        let find = |files: &std::collections::BTreeMap<String, Vec<u8>>| {
            files.iter().find(|(path, _)| path.ends_with(part)).map(|(_, bytes)| bytes.clone()).unwrap()
        };
        assert_eq!(find(&full), find(&light), "{part}");
    }
}

#[test]
fn fewer_views_leave_no_stale_files() {
    let folder = Folder::new();
    flatten(&folder, &["synth:knit?resolution=32", "-o", "knit", "--uncompressed"]).succeeded();
    let fewer = ["flatten", "synth:knit?resolution=32", "-o", "knit", "--texels", "8", "--views", "grid:2x3@40"];
    folder.run(&[&fewer[..], &["--indirection", "4x6", "--uncompressed"]].concat()).succeeded();
    assert_eq!(folder.files("knit").len(), 7 + 4 + 1);
    // Nor do factors, and views in their turn.
    flatten(&folder, &["synth:knit?resolution=32", "-o", "knit"]).succeeded();
    let parts: Vec<String> = folder.files("knit").into_keys().collect();
    assert!(!parts.iter().any(|part| part.contains(".flat.") || part.contains(".indirection.")), "{parts:?}");
    flatten(&folder, &["synth:knit?resolution=32", "-o", "knit", "--uncompressed"]).succeeded();
    assert_eq!(folder.files("knit").len(), 7 + 7 + 1);
}

#[test]
fn settings_are_recorded_as_they_were_given() {
    let folder = Folder::new();
    folder.write("sets/few.csv", "index,theta_deg,phi_deg\n0,0,0\n1,30,0\n2,30,120\n3,30,240\n");
    let more = ["--lights", "sets/few.csv", "--stretch-rounds", "3", "--no-supercompression"];
    let report = report(flatten(&folder, &[&["synth:knit?resolution=16", "-o", "a"], &more[..]].concat()));
    let settings = &report["settings"];
    assert_eq!((&settings["views"][0], &settings["lights"][0]), (&"grid:2x6@50".into(), &"few.csv".into()));
    assert_eq!((&settings["stretch_rounds"], &settings["supercompression"]), (&3.into(), &false.into()));
}

#[test]
fn options_change_what_they_say() {
    let folder = Folder::new();
    let mean = |report: &Value| number(&report["report"]["parameterisation"]["after"]["l2"]);
    let button = "synth:button?resolution=40";
    let plain = report(flatten(&folder, &[button, "-o", "a", "--uncompressed"]));
    let even = report(flatten(&folder, &[button, "-o", "b", "--stretch-rounds", "8"]));
    assert!(mean(&even) < 0.95 * mean(&plain), "{} {}", mean(&even), mean(&plain));
    let other = report(flatten(&folder, &[button, "-o", "c", "--fill", "push-pull", "--uncompressed"]));
    assert_eq!(other["settings"]["fill"], "push-pull");
    let view = |folder_name: &str| {
        folder.files(folder_name).into_iter().find(|(path, _)| path.ends_with("flat.003.ktx2")).unwrap().1
    };
    assert_ne!(view("a"), view("c"));
}

#[test]
fn light_of_one_bounce_brightens_and_does_not_depend_on_threads() {
    let folder = Folder::new();
    let sponge =
        ["flatten", "synth:sponge?resolution=32&height=1.5", "--name", "s", "--fill", "push-pull", "--uncompressed"];
    for (out, more) in
        [("direct", &[][..]), ("one", &["--bounces", "8", "-j", "1"]), ("three", &["--bounces", "8", "-j", "3"])]
    {
        folder.run(&[&sponge[..], &["-o", out], more, &SMALL].concat()).succeeded();
    }
    let files = |out: &str| folder.files(out);
    assert!(files("one").values().eq(files("three").values()));
    let listed: Value = serde_json::from_slice(&std::fs::read(folder.path().join("one/s.json")).unwrap()).unwrap();
    assert!(listed["report"]["errors"].as_object().unwrap().is_empty(), "the comparison knows direct light only");
    let brightness = |out: &str| {
        let parts = open_flat_btf(&folder.path().join(out), true).unwrap();
        let texels = || parts.values.views().iter().flat_map(|view| view.texels());
        let sum: f64 = texels().map(|texel| f64::from(rgb9e5::decode(*texel)[1])).sum();
        sum / texels().count() as f64
    };
    let (direct, bounced) = (brightness("direct"), brightness("one"));
    assert!(bounced > 1.02 * direct && bounced < 1.6 * direct, "{direct} {bounced}");
}

/// What fails after the first parts were made leaves the asset that was there as it was.
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
    // Nor does a new one appear.
    let ran = flatten(&folder, &["images", "-o", "other"]);
    assert_eq!(ran.code, 3, "{ran:?}");
    assert_eq!(folder.files("other").len(), 0);
}

#[test]
fn directions_are_checked_before_the_work() {
    let folder = Folder::new();
    // Azimuths of any sign, and a full turn, are directions.
    folder.write("turns.csv", "index,theta_deg,phi_deg\n0,0,0\n1,40,-90\n2,40,360\n3,30,200\n");
    let knit = ["flatten", "synth:knit?resolution=16", "--texels", "8", "--indirection", "4x6"];
    folder.run(&[&knit[..], &["-o", "turns", "--views", "turns.csv"]].concat()).succeeded();
    folder.write("steep.csv", "index,theta_deg,phi_deg\n0,0,0\n1,89.99,0\n");
    folder.write("near.csv", "index,theta_deg,phi_deg\n0,0,0\n1,40,10\n2,40,10.001\n");
    for (set, words) in [
        ("steep.csv", "polar angle: found 89.99"),
        ("near.csv", "found the direction of line 3"),
        ("grid:64x64@80", "2048"),
    ] {
        let ran = folder.run(&[&knit[..], &["-o", "never", "--views", set]].concat());
        assert!((2..=3).contains(&ran.code) && ran.stderr.contains(words), "{set}: {ran:?}");
        assert!(!folder.path().join("never").exists(), "{set}");
    }
    let ran = folder.run(&[&knit[..], &["-o", "never", "--flat-texels", "1024", "--bounces", "1024"]].concat());
    assert!(ran.code == 2 && ran.stderr.contains("memory: found "), "{ran:?}");
}

#[test]
fn reliefs_that_rays_cannot_follow_are_refused() {
    let folder = Folder::new();
    let plane =
        |lifted: &str| format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv {lifted}\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    for (lifted, words) in [("0.5 0.5 50", "allowed 16 tiles above"), ("300 0.5 1", "reaches over 300 tiles")] {
        folder.write("spike.obj", plane(lifted));
        let ran = flatten(&folder, &["spike.obj", "-o", "spike", "--material", "synth:lambert"]);
        assert!(ran.code == 3 && ran.stderr.contains("spike.obj: ") && ran.stderr.contains(words), "{ran:?}");
    }
}
