//! `brdfc view`: the page, and its renderings in a browser.

#[cfg(feature = "render")]
mod drawn;
#[cfg(feature = "render")]
mod image_drawn;
mod lobes;
#[cfg(feature = "render")]
mod lobes_drawn;
mod photographs;

use crate::common::cli::Folder;

/// A scene whose packs and sources are small.
const SCENE: &str = "[materials.paint]\nsource = \"synth:ggx?kd=0.2,0.1,0.05&alpha=0.4\"\n\
                     [materials.matte]\nsource = \"synth:lambert?kd=0.5\"\n\
                     [[uses]]\nmaterial = \"paint\"\n[[uses]]\nmaterial = \"matte\"\n";

#[test]
fn a_page_holds_packs_and_says_its_size() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ggx?alpha=0.4", "-o", "ggx.ktx2"]).succeeded();
    let printed = folder.run(&["view", "ggx.ktx2", "-o", "ggx.html", "--json"]).succeeded().json();
    let page = folder.text("ggx.html");
    assert_eq!(printed["bytes_on_disk"], page.len());
    // The page itself: shaders of both languages, script, meshes.
    let alone = printed["bytes_alone"].as_u64().unwrap();
    assert!(alone < 300 << 10 && (alone as usize) < page.len(), "{alone}");
    assert_eq!(
        (printed["items"][0]["name"].as_str(), printed["items"][0]["decoder"].as_str()),
        (Some("ggx.ktx2"), Some("table"))
    );
    // It makes no requests.
    for outside in ["src=", "href=\"http", "@import", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    folder.run(&["view", "ggx.ktx2", "-o", "again.html"]).succeeded();
    assert_eq!(folder.text("again.html"), page);
    // To a pipe; then there is no other output.
    assert_eq!(folder.run(&["view", "ggx.ktx2", "-o", "-", "--json"]).succeeded().stdout, page);
}

#[test]
fn a_build_is_viewed_with_its_sources() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    let names = |printed: serde_json::Value| -> Vec<String> {
        printed["items"].as_array().unwrap().iter().map(|item| item["name"].as_str().unwrap().to_owned()).collect()
    };
    let printed = folder.run(&["view", "packs", "-o", "all.html", "--json"]).succeeded().json();
    let source = printed["items"][3]["facts"].as_str().unwrap();
    assert!(source.starts_with("the source as a table of ") && source.contains("ΔE 0."), "{source}");
    assert_eq!(names(printed), ["matte", "matte, source", "paint", "paint, source"]);
    let printed = folder.run(&["view", "packs", "--no-sources", "-o", "all.html", "--json"]).succeeded().json();
    assert_eq!(names(printed), ["matte", "paint"]);
    // The same input twice gets two names.
    folder.run(&["encode", "synth:lambert?kd=0.5", "-o", "paint.ktx2"]).succeeded();
    let twice = ["view", "paint.ktx2", "paint.ktx2", "-o", "twice.html", "--json"];
    assert_eq!(names(folder.run(&twice).succeeded().json()), ["paint.ktx2", "paint.ktx2 (2)"]);
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let folder = Folder::new();
    folder.run(&["samples", "synth:lambert?kd=0.5", "-o", "it.samples.ktx2"]).succeeded();
    folder.write("empty/nothing.txt", "");
    folder.write("many/it.ktx2", "");
    folder.write("stack/a.lp", "1\nx.png 0 0 1\n");
    for (input, code, expected) in [
        ("it.samples.ktx2", 3, "it.samples.ktx2: input: found an importance-sample pack, expected a pack of a BRDF"),
        ("empty", 3, "empty: input: found a folder, expected "),
        ("many", 3, "many: input: found a folder of packs without the report of a build, expected "),
        ("stack", 3, "\"x.png\" does not exist"),
        ("none.ktx2", 4, "none.ktx2: cannot read"),
        ("synth:nothing", 3, "synth:nothing"),
    ] {
        let ran = folder.run(&["view", input, "-o", "it.html"]);
        assert_eq!(ran.code, code, "{input}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{input}: {}", ran.stderr);
        assert!(!folder.path().join("it.html").exists());
    }
    for (arguments, expected) in [
        (
            &["view", "synth:lambert?kd=0.5", "-o", "it.png"][..],
            "--output: found it.png, expected a name that ends in .html",
        ),
        (&["view", "-", "-", "-o", "it.html"], "both are -"),
        (&["view", "-o", "it.html"], "PACK"),
    ] {
        let ran = folder.run(arguments);
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}
