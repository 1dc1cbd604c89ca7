//! `brdfc flatten`, from every kind of input.

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use brdfc_flat_btf::encode::{FlatInput, FlattenRecipe, MemoryScratch, ValueSource, encode};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatBtfFile, FlatValues, IndirectionHeader};
use brdfc_jobs::flatten::{MesoOptions, material_list, open_appearance, open_asset, open_geometry};
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

/// The file of a flat BTF.
fn file(folder: &Folder, name: &str) -> FlatBtfFile {
    let files = folder.files(name);
    assert_eq!(files.len(), 1, "{:?}", files.keys());
    FlatBtfFile::from_bytes(files.values().next().unwrap()).unwrap()
}

#[test]
fn every_structure_is_one_file() {
    let folder = Folder::new();
    for (name, limit) in [("button", 12.5), ("folds", 13.0), ("knit", 7.5), ("sponge", 15.0)] {
        let surface = format!("synth:{name}?resolution=48");
        let report = report(flatten(&folder, &[&surface, "-o", name]));
        let length = std::fs::metadata(folder.path().join(name).join(format!("{name}.ktx2"))).unwrap().len();
        assert_eq!(report["bytes"], length);
        assert!(report["report"]["factored"].is_object());
        assert_eq!(report["report"]["parameterisation"]["flipped"], 0);
        let errors = &report["report"]["errors"];
        // With 16 x 16 texels there are few.
        assert!(number(&errors["at_samples"]["mean"]) < limit, "{name}: {errors}");
        // Views that are not factored were limited to this when files contained them.
        assert!(name != "button" || number(&errors["views_at_samples"]["mean"]) < 12.0, "{errors}");
        let within: Value = serde_json::from_str(&file(&folder, name).report).unwrap();
        assert_eq!(within["report"], report["report"]);
        let mut output = report.clone();
        output.as_object_mut().unwrap().remove("seconds");
        conforms("flat-btf", &output);
        assert_eq!(folder.run(&["info", name, "--json"]).succeeded().json(), output);
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
        assert_eq!(file(&folder, "knit").decoder.parts().gpu_bytes(), total);
        #[cfg(feature = "render")]
        if crate::common::has_adapter() {
            let drawn = folder.run(&["render", "knit", "--size", "16x16", "--json"]).succeeded().json();
            assert_eq!(drawn["parts"][0]["bytes_on_gpu"].as_u64(), Some(total), "{drawn}");
        }
        report
    };
    let of = |report: &Value, image: &str| report["images"][image].as_u64().unwrap();
    let smaller = checked(&[]);
    assert_eq!(of(&smaller, "flat_btf_normal"), 8 * 16 * 16);
    // Each texel has 4 x 7 samples of two bytes, and their ranges.
    let displacements = of(&smaller, "flat_btf_packed_indirection") + of(&smaller, "flat_btf_ranges");
    assert_eq!(displacements, 16 * 16 * (4 * 7 * 2 + 8));
    let budget = checked(&["--max-bytes", "20KiB"]);
    let factors: u64 = ["factored_basis", "factored_weights", "factored_shadow"]
        .iter()
        .filter_map(|image| budget["images"][image].as_u64())
        .sum();
    assert!(factors <= 20 << 10 && budget["report"]["factored"]["gpu_bytes"] == factors, "{budget}");
    // If no factorisation meets the limit, the best one is selected and reported.
    let missed = flatten(&folder, &[&knit[..], &["--max-delta-e", "0.00001"]].concat());
    assert!(
        missed.code == 1 && missed.stderr.contains("of 14 that were tried, expected at most 0.00001"),
        "{}",
        missed.stderr
    );
    assert!(missed.json()["report"]["factored"]["errors"]["seen_mean"].as_f64().unwrap() > 1e-5);
    let refused = flatten(&folder, &[&knit[..], &["--max-bytes", "1KiB"]].concat());
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
    let factored = FlattenRecipe {
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
        factored: Some(FactoredTarget::Error(0.7)),
    };
    let light = FlattenRecipe { factored: None, ..factored.clone() };
    for (name, more, recipe) in [("factored", &[][..], factored), ("light", &["--form", "light"], light)] {
        let geometry = open_geometry(&options).unwrap();
        let materials = material_list(&options, &geometry).unwrap();
        let appearance = open_appearance(&options, &materials, &()).unwrap();
        let values = ValueSource::Computed(&appearance);
        let scratch = MemoryScratch::default();
        let input = FlatInput { mesh: geometry.mesh, repairs: None, values };
        let made = encode(input, &recipe, &scratch, &()).unwrap();
        flatten(&folder, &[&["synth:button?resolution=24", "-o", name], more].concat()).succeeded();
        let (file, asset) = open_asset(&folder.path().join(name)).unwrap();
        assert!(*file.decoder.parts() == made.parts, "{name}");
        assert_eq!(file.mask, Some(made.mask));
        assert_eq!(asset.about.report, made.report);
    }
}

#[test]
fn a_matte_plane_is_exact() {
    let folder = Folder::new();
    folder.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let plane = ["plane.obj", "--material", "synth:lambert?kd=0.5", "-o", "plane"];
    let report = report(flatten(&folder, &plane));
    assert!((number(&report["report"]["seen"]) - 1.0).abs() < 1e-12);
    let errors = &report["report"]["errors"];
    for kind in ["at_samples", "light_form"] {
        assert!(number(&errors[kind]["max"]) < 0.25, "{errors}");
    }
    // The views themselves blend the cosines of lights that are 50 degrees apart; the base has the cosine of the light itself.
    assert!((0.1..5.0).contains(&number(&errors["views_between_samples"]["mean"])), "{errors}");
    assert!(number(&errors["between_samples"]["max"]) < 0.5, "{errors}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for (out, jobs) in [("one", "1"), ("three", "3")] {
        let input = ["flatten", "synth:folds?resolution=32", "--name", "folds", "-o", out, "-j", jobs];
        folder.run(&[&input[..], &SMALL].concat()).succeeded();
    }
    let (one, three) = (folder.files("one"), folder.files("three"));
    assert!(one.len() == 1 && one.values().eq(three.values()), "{}", one.len());
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
    let first = report(flatten(&folder, &[&[sponge, "-o", "first"], &images[..]].concat()));
    assert_eq!(folder.files("images").len(), 49);
    let measured = |more: &[&str]| report(flatten(&folder, &[&["images"], more, &["--flat-texels", "32"]].concat()));
    let second = measured(&["--geometry", sponge, "-o", "second"]);
    assert_eq!(second["settings"]["views"][0], "of the images");
    assert_eq!(second["settings"]["views"][1], 7);
    let seen = |report: &Value| number(&report["report"]["seen"]);
    assert!((seen(&first) - seen(&second)).abs() < 1e-9);
    // Over a plane the same images keep their parallax in the texels, so they are less similar.
    let plane = measured(&["-o", "plane"]);
    assert_eq!(plane["source"], "images over the plane");
    assert_eq!(plane["report"]["heights"], serde_json::json!([0.0, 0.0]));
    assert!((seen(&plane) - 1.0).abs() < 1e-12);
    let error = |report: &Value| number(&report["report"]["errors"]["light_form"]["mean"]);
    assert!(error(&second) < error(&plane), "{} {}", error(&second), error(&plane));
}

#[test]
fn the_light_form_has_no_values_and_the_same_colours() {
    let folder = Folder::new();
    for (out, form) in [("full", "full"), ("light", "light")] {
        flatten(&folder, &["synth:button?resolution=32", "-o", out, "--name", "b", "--form", form]).succeeded();
    }
    let (full, light) = (file(&folder, "full").decoder, file(&folder, "light").decoder);
    let (full, light) = (full.into_parts(), light.into_parts());
    assert!(full.values.factored().is_some() && light.values == FlatValues::None);
    assert!((full.diffuse, full.normal, full.indirection) == (light.diffuse, light.normal, light.indirection));
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
    let plain = report(flatten(&folder, &[button, "-o", "a"]));
    let even = report(flatten(&folder, &[button, "-o", "b", "--stretch-rounds", "8"]));
    assert!(mean(&even) < 0.95 * mean(&plain), "{} {}", mean(&even), mean(&plain));
    let other = report(flatten(&folder, &[button, "-o", "c", "--fill", "push-pull"]));
    assert_eq!(other["settings"]["fill"], "push-pull");
    let values = |name: &str| file(&folder, name).decoder.into_parts().values;
    assert!(values("a") != values("c"));
}

#[test]
fn light_of_one_bounce_brightens_and_does_not_depend_on_threads() {
    let folder = Folder::new();
    let sponge = ["flatten", "synth:sponge?resolution=32&height=1.5", "--name", "s", "--fill", "push-pull"];
    for (out, more) in
        [("direct", &[][..]), ("one", &["--bounces", "8", "-j", "1"]), ("three", &["--bounces", "8", "-j", "3"])]
    {
        folder.run(&[&sponge[..], &["-o", out], more, &SMALL].concat()).succeeded();
    }
    let files = |out: &str| folder.files(out);
    assert!(files("one").values().eq(files("three").values()));
    let listed: Value = serde_json::from_str(&file(&folder, "one").report).unwrap();
    assert!(listed["report"]["errors"].as_object().unwrap().is_empty(), "the comparison knows direct light only");
    let brightness = |out: &str| {
        let parts = file(&folder, out).decoder.into_parts();
        let asset = parts.values.factored().unwrap();
        let views: Vec<_> = (0..asset.header().views.len() as u32).map(|view| asset.view(view)).collect();
        let texels = || views.iter().flat_map(|view| view.texels());
        let sum: f64 = texels().map(|texel| f64::from(rgb9e5::decode(*texel)[1])).sum();
        sum / texels().count() as f64
    };
    let (direct, bounced) = (brightness("direct"), brightness("one"));
    assert!(bounced > 1.02 * direct && bounced < 1.6 * direct, "{direct} {bounced}");
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
    let knit = ["flatten", "synth:knit?resolution=16", "--texels", "8", "--indirection", "4x6"];
    folder.run(&[&knit[..], &["-o", "turns", "--views", "turns.csv"]].concat()).succeeded();
    folder.write("steep.csv", "index,theta_deg,phi_deg\n0,0,0\n1,89.99,0\n");
    folder.write("near.csv", "index,theta_deg,phi_deg\n0,0,0\n1,40,10\n2,40,10.001\n");
    for (set, words) in [
        ("steep.csv", "polar angle: found 89.99"),
        ("near.csv", "direction: equal to the direction of line 3"),
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
        |apex: &str| format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv {apex}\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    for (apex, words) in [("0.5 0.5 50", "expected at most 16 tiles above"), ("300 0.5 1", "an extent of 300 tiles")] {
        folder.write("spike.obj", plane(apex));
        let ran = flatten(&folder, &["spike.obj", "-o", "spike", "--material", "synth:lambert"]);
        assert!(ran.code == 3 && ran.stderr.contains("spike.obj: ") && ran.stderr.contains(words), "{ran:?}");
    }
}
