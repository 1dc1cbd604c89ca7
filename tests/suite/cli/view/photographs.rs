//! Photographs in the page of `brdfc view`.

use crate::cli::pwt::stack;
use crate::cli::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;

#[test]
fn photographs_are_reduced_to_the_limit() {
    let folder = stack();
    let view = |more: &[&str]| folder.run(&[&["view", "stack", "-o", "view.html", "--json"], more].concat());
    let whole = view(&[]).succeeded();
    assert!(!whole.stderr.contains("left out"), "{}", whole.stderr);
    let report = whole.json();
    conforms("view", &report);
    let all = &report["items"][0]["photographs"];
    assert_eq!((&all["count"], &all["left_out"], &all["size"][0]), (&40.into(), &0.into(), &45.into()));
    let bytes = all["bytes"].as_u64().unwrap();
    let alone = report["bytes_alone"].as_u64().unwrap();
    assert_eq!(report["bytes_on_disk"].as_u64().unwrap(), alone + bytes);
    // Photographs below 512 pixels a side are left out instead of reduced.
    let limit = (bytes / 2).to_string();
    let fewer = view(&["--max-photographs", &limit]).succeeded();
    assert!(fewer.stderr.contains("of 40 photographs left out"), "{}", fewer.stderr);
    let page = folder.text("view.html");
    assert!(page.contains("of 40 photographs left out"));
    let them = &fewer.json()["items"][0]["photographs"];
    let (count, used) = (them["count"].as_u64().unwrap(), them["bytes"].as_u64().unwrap());
    assert!(used <= bytes / 2 && (15..25).contains(&count), "{count} of {used} bytes");
    assert_eq!(page.matches(".png\",\"light\"").count() as u64, count);
    let none = view(&["--max-photographs", "100"]);
    assert!(none.code == 2 && none.stderr.contains("--max-photographs: found 100 B, expected at least"), "{none:?}");
}

/// Notes about a capture are those of `brdfc pwt`; a complete capture has none.
#[test]
fn lights_that_are_left_out_are_noted() {
    let folder = stack();
    let notes = |arguments: &[&str]| -> Vec<String> {
        let ran = folder.run(&[arguments, &["stack"]].concat()).succeeded();
        ran.stderr.lines().filter(|line| line.starts_with("note: ")).map(str::to_owned).collect()
    };
    let (view, pwt) = (["view", "-o", "v.html", "--normals"], ["pwt", "--normals", "n.png"]);
    assert_eq!(notes(&view), [""; 0]);
    let list = folder.text("stack/dirs.lp");
    let second = list.lines().nth(2).unwrap();
    folder.write("stack/dirs.lp", list.replace(second, "0001.png 0 0.6 -0.8"));
    std::fs::remove_file(folder.path().join("stack/0004.png")).unwrap();
    let found = notes(&view);
    assert_eq!(found, notes(&pwt));
    let expected = ["without an image: 0004.png (line 6)", "at or below the horizon: 0001.png (line 3)"];
    assert_eq!(found, expected.map(|text| format!("note: stack: left out 1 light, {text}")));
}

#[test]
fn large_photographs_become_smaller_before_fewer() {
    let folder = Folder::new();
    let (size, lights) = ([1100, 40], [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]]);
    let noise = |light: usize| (0..44_000).map(|k: usize| [((k * (7919 + light)) % 101) as f32 / 101.0; 3]).collect();
    write_rti_capture(&folder.path().join("wide"), &lights, size, StackFormat::Png, noise).unwrap();
    let view = |limit: &str| {
        let ran = folder.run(&["view", "wide", "-o", "v.html", "--json", "--max-photographs", limit]).succeeded();
        assert!(ran.stderr.contains("reduced from 1100 x 40 pixels"), "{}", ran.stderr);
        let them = ran.json()["items"][0]["photographs"].clone();
        ["count", "bytes"].map(|key| them[key].as_u64().unwrap()).into_iter().chain(them["size"][0].as_u64()).collect()
    };
    let whole: Vec<u64> = view("8MiB");
    assert_eq!((whole[0], whole[2]), (3, 1024));
    let smaller: Vec<u64> = view(&(whole[1] * 7 / 10).to_string());
    assert!(smaller[0] == 3 && smaller[1] <= whole[1] * 7 / 10 && (600..1000).contains(&smaller[2]), "{smaller:?}");
    let fewer: Vec<u64> = view(&(whole[1] / 5).to_string());
    assert!(fewer[0] < 3 && fewer[2] == 512, "{fewer:?}");
}

#[test]
fn normals_are_those_of_pwt() {
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2", "--normals", "normals.png"]).succeeded();
    let report = folder.run(&["view", "p.ktx2", "stack", "--normals", "-o", "v.html", "--json"]).succeeded().json();
    assert_eq!(report["items"][2]["name"], "stack, normals");
    let page = folder.text("v.html");
    let data = page.split("\"name\":\"normals\",\"light\":null,\"data\":\"").nth(1).unwrap().split('"').next().unwrap();
    use base64::Engine as _;
    let jpeg = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
    let [shown, expected] =
        [jpeg, folder.read("normals.png")].map(|bytes| image::load_from_memory(&bytes).unwrap().to_rgb8().into_raw());
    let apart = |by: usize| -> f64 {
        let pairs = shown.iter().zip(expected.iter().cycle().skip(by));
        pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / shown.len() as f64
    };
    assert!(apart(0) < 4.0 && apart(3 * 6) > 10.0, "{} {}", apart(0), apart(18));
    // From the pack alone; and nothing else has normals.
    let alone = folder.run(&["view", "p.ktx2", "--normals", "-o", "v.html", "--json"]).succeeded().json();
    assert_eq!(alone["items"][1]["name"], "p.ktx2, normals");
    // Inputs of one name: the first one is another kind of pack.
    std::fs::create_dir(folder.path().join("other")).unwrap();
    folder.run(&["encode", "synth:lambert?kd=0.5", "-o", "other/p.ktx2"]).succeeded();
    let report =
        folder.run(&["view", "other/p.ktx2", "p.ktx2", "--normals", "-o", "w.html", "--json"]).succeeded().json();
    assert_eq!(
        (&report["items"][1]["decoder"], &report["items"][2]["name"]),
        (&"pwt".into(), &"p.ktx2, normals".into())
    );
    let ran = folder.run(&["view", "synth:lambert?kd=0.5", "--normals", "-o", "v.html"]);
    assert!(ran.code == 2 && ran.stderr.contains("--normals: found no RTI capture"), "{ran:?}");
}
