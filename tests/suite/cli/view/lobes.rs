//! Pages of lobes and their environment.

use crate::cli::environment::sky;
use crate::cli::schemas::conforms;
use crate::common::cli::Folder;
use serde_json::Value;

/// Data of a page.
fn data(page: &str) -> Value {
    let text =
        page.split("<script id=\"data\" type=\"application/json\">").nth(1).unwrap().split("</script>").next().unwrap();
    serde_json::from_str(text).unwrap()
}

fn view(folder: &Folder, arguments: &[&str]) -> (Value, Value) {
    let report = folder.run(&[&["view"], arguments, &["-o", "view.html", "--json"]].concat()).succeeded().json();
    conforms("view", &report);
    (report, data(&folder.text("view.html")))
}

/// A pack and an image give the same environment, which is once in the page, however many packs it lights.
#[test]
fn packs_of_lobes_share_an_environment() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 300.0);
    folder.run(&["environment", "sky.exr", "-o", "sky.env.ktx2"]).succeeded();
    for (name, model) in [("dark.ktx2", "synth:lambert?kd=0.2"), ("light.ktx2", "synth:lambert?kd=0.8")] {
        folder.run(&["encode", model, "--codec", "lobes", "-o", name]).succeeded();
    }
    let packs = ["dark.ktx2", "light.ktx2", "synth:lambert?kd=0.5"];
    let (report, page) = view(&folder, &[&packs[..], &["--environment", "sky.env.ktx2"]].concat());
    let kinds: Vec<&str> =
        report["items"].as_array().unwrap().iter().map(|it| it["decoder"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["lobes", "lobes", "table"]);
    assert_eq!(report["environment"]["name"], "sky.env.ktx2");
    let slots = |of: &Value| -> Vec<u64> {
        of["resources"].as_array().unwrap().iter().map(|it| it["binding"].as_u64().unwrap()).collect()
    };
    let own = slots(&page["environment"]);
    assert!(!own.is_empty() && slots(&page["items"][0]).iter().all(|slot| !own.contains(slot)));
    let lit = |item: usize| page["items"][item]["needsEnvironment"].as_bool().unwrap();
    assert!(lit(0) && lit(1) && !lit(2));
    // By name, the image is another environment, with the same texels.
    let (report, of_image) = view(&folder, &[&packs[..], &["--environment", "sky.exr"]].concat());
    assert_eq!(report["environment"]["name"], "sky.exr");
    assert_eq!(of_image["environment"]["resources"], page["environment"]["resources"]);
}

#[test]
fn the_sky_of_the_scenes_lights_lobes_by_default() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lambert?kd=0.5", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    let (report, page) = view(&folder, &["l.ktx2"]);
    assert_eq!(report["environment"]["name"], "the default sky");
    assert!(page["environment"]["resources"].is_array());
    // Other pages have no environment.
    let (report, page) = view(&folder, &["synth:lambert?kd=0.5"]);
    assert!(report["environment"].is_null() && page["environment"].is_null());
    assert!(!folder.text("view.html").contains("The light of lobes"));
}

#[test]
fn an_environment_that_lights_nothing_is_refused() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 0.4);
    folder.run(&["environment", "sky.exr", "-o", "sky.env.ktx2"]).succeeded();
    folder.run(&["bandwidth", "sky.exr", "-o", "map.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert", "-o", "t.ktx2", "--max-bytes", "4096"]).succeeded();
    folder.write("broken.hdr", "no image");
    for (arguments, code, expected) in [
        (
            &["t.ktx2", "--environment", "sky.exr"][..],
            2,
            "--environment: found no pack of lobes to light, expected one",
        ),
        (
            &["l.ktx2", "--environment", "t.ktx2"],
            3,
            "t.ktx2: environment: found a table pack, expected a latitude-longitude image (.exr, .hdr), a cube map or a",
        ),
        (
            &["l.ktx2", "--environment", "map.ktx2"],
            3,
            "map.ktx2: environment: found a bandwidth map, expected a latitude-longitude",
        ),
        (
            &["l.ktx2", "--environment", "l.ktx2"],
            3,
            "l.ktx2: environment: found lobes of a BRDF, expected a latitude-longitude",
        ),
        (&["l.ktx2", "--environment", "broken.hdr"], 3, "broken.hdr: HDR: "),
        (&["l.ktx2", "--environment", "none.hdr"], 4, "none.hdr: cannot read"),
        (&["-", "--environment", "-"], 2, "both are -"),
        (&["sky.env.ktx2"], 3, "sky.env.ktx2: input: found a prefiltered environment, expected a pack of lobes, which"),
        (&["map.ktx2", "--environment", "sky.exr"], 3, "map.ktx2: input: found a bandwidth map, expected a pack of a"),
    ] {
        let ran = folder.run(&[&["view"], arguments, &["-o", "it.html"]].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {} {}", ran.code, ran.stderr);
        assert!(!folder.path().join("it.html").exists());
    }
    // The page does not replace its own environment.
    std::fs::rename(folder.path().join("sky.exr"), folder.path().join("sky.html")).unwrap();
    let ran = folder.run(&["view", "l.ktx2", "--environment", "sky.html", "-o", "sky.html"]);
    assert!(ran.code == 2 && ran.stderr.contains("sky.html"), "{} {}", ran.code, ran.stderr);
}

/// Lobes and a table of one material are not side by side.
#[test]
fn a_note_says_what_is_not_compared() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lambert", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert", "-o", "t.ktx2", "--max-bytes", "4096"]).succeeded();
    let stderr = |packs: &[&str]| folder.run(&[&["view", "-o", "v.html"], packs].concat()).succeeded().stderr;
    let expected = "note: t.ktx2: not drawn next to l.ktx2, only if selected on the page: an environment lights lobes";
    assert!(stderr(&["l.ktx2", "t.ktx2"]).contains(expected), "{}", stderr(&["l.ktx2", "t.ktx2"]));
    for alike in [&["l.ktx2"][..], &["l.ktx2", "l.ktx2", "t.ktx2"], &["t.ktx2", "synth:lambert"]] {
        assert!(!stderr(alike).contains("not drawn"), "{}", stderr(alike));
    }
}
