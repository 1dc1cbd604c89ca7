//! `brdfc report`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs, with_checksum};

/// Three materials: one cannot be read, and one misses its limit.
fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("broken.brdf", "no scan");
    folder.write(
        "scene.toml",
        "[scene]\nname = 'shop'\n[materials.table]\nsource = 'table.binary'\n[materials.broken]\nsource = 'broken.brdf'\n\
         [materials.ward]\nsource = 'synth:ward?ay=0.5'\ncodec = 'wavelet'\ngrid = 4\n\
         [materials.ward.require]\nmax_delta_e = 0.01\n\
         [[uses]]\nmaterial = 'table'\n[[uses]]\nmaterial = 'broken'\n[[uses]]\nmaterial = 'ward'\n",
    );
    let ran = folder.run(&["build", "scene.toml"]);
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    folder
}

#[test]
fn the_page_is_self_contained_and_agrees_with_the_build() {
    let folder = folder();
    let ran = folder.run(&["report", "packs", "-o", "page.html", "--json"]).succeeded();
    conforms("report", &ran.json());
    let page = folder.text("page.html");
    for words in [
        "shop: packs and their errors",
        "2 of them failed",
        "require.max_delta_e: found",
        "id=\"table\"",
        "broken.brdf",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // Ball and cloth of two materials, and the turned ball of the anisotropic one: source, pack and difference; and both
    // balls at a glance.
    assert_eq!(page.matches("<img src=\"data:image/png;base64,").count(), 2 * 6 + 3 + 2 * 2);
    assert_eq!(page.matches("sphere of ward, pack, turned by 90°").count(), 1);
    assert!(!page.contains("of table, pack, turned"), "it looks the same from all sides");
    assert!(
        !page.contains("http") || page.matches("http").count() == page.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(!page.contains("<link") && !page.contains("src=\"/") && page.matches("<script").count() == 1);
    let table = folder.text("page.csv");
    assert_eq!(table.lines().count(), 4, "{table}");
    let columns = table.lines().next().unwrap().split(',').count();
    assert!(table.lines().all(|line| line.split(',').count() >= columns), "{table}");
    let figures: serde_json::Value = serde_json::from_str(&folder.text("page.json")).unwrap();
    assert!(figures == ran.json());
    let worst = figures["materials"][2]["by_angle"]["worst"].as_array().unwrap();
    assert!(figures["materials"][2]["material"] == "ward" && !worst.is_empty());

    // The same build gives the same page.
    folder.run(&["report", "packs", "-o", "again.html"]).succeeded();
    assert!(folder.text("again.html") == page);
    // Without the store, sources and times are unknown.
    std::fs::remove_dir_all(folder.path().join("packs/.brdfc-cache")).unwrap();
    folder.run(&["report", "packs", "-o", "bare.html"]).succeeded();
    let bare = folder.text("bare.html");
    assert!(
        bare.contains("Not compared with its source") && bare.matches("<img").count() == 2 * 2 + 1 + 2,
        "{}",
        bare.len()
    );
}

/// Renderings of many materials are on pages of 100; a page of missed limits leaves out the others.
#[test]
fn many_materials_have_pages_of_their_own() {
    let folder = Folder::new();
    let material = |name: String, more: &str| {
        format!(
            "[materials.{name}]\nsource = 'synth:lambert'\nmax_bytes = '1KiB'\n{more}[[uses]]\nmaterial = '{name}'\n"
        )
    };
    let scene: String = (100..201).map(|k| material(format!("m{k}"), "")).collect();
    let missed = "[materials.m999.require]\nmax_bytes = 10\n";
    folder.write("scene.toml", scene + &material("m999".to_owned(), missed));
    assert_eq!(folder.run(&["build", "scene.toml"]).code, 1);
    let ran = folder.run(&["report", "packs", "-o", "page.html"]).succeeded();
    assert!(ran.stderr.ends_with("page.html: 102 materials\n"), "{}", ran.stderr);
    let [page, first, second] = ["page.html", "page-1.html", "page-2.html"].map(|name| folder.text(name));
    assert!(!folder.path().join("page-3.html").exists());
    assert!(page.contains("href=\"page-1.html#m100\"") && page.contains("href=\"page-2.html#m999\""));
    assert!(!page.contains("<img") && page.len() < 200_000, "{}", page.len());
    assert!(first.contains("id=\"m199\"") && !first.contains("id=\"m200\"") && first.contains("href=\"page.html\""));
    assert!(second.contains("id=\"m200\"") && second.contains("id=\"m999\"") && second.matches("<img").count() > 4);
    assert_eq!(folder.text("page.csv").lines().count(), 103);

    let ran = folder.run(&["report", "packs", "-o", "missed.html", "--only", "missed", "--against", "packs"]);
    assert!(ran.code == 1 && ran.stdout.lines().count() == 1 && ran.stdout.contains("m999"), "{ran:?}");
    let page = folder.text("missed.html");
    assert!(
        page.contains("One material; 101 others passed and are left out") && page.contains("id=\"m999\""),
        "{page}"
    );
    assert!(!page.contains("m100") && !folder.path().join("missed-1.html").exists());
}

#[test]
fn a_page_that_draws_is_linked_to() {
    let folder = folder();
    folder.run(&["report", "packs", "-o", "page.html", "--view", "all packs.html"]).succeeded();
    let (page, view) = (folder.text("page.html"), folder.text("all packs.html"));
    assert!(page.contains("<a href=\"all%20packs.html\">"));
    for material in ["table", "ward"] {
        let link = format!("<a href=\"all%20packs.html#left={material}&amp;right={material}%2C%20source\">");
        assert!(page.contains(&link), "{link}");
        assert!(view.contains(&format!("\"name\":\"{material}, source\"")));
    }
    assert!(!page.contains("#left=broken"));
    // However both are written.
    folder.run(&["report", "packs/report.json", "-o", "./page.html", "--view", "view.html"]).succeeded();
    for (view, expected) in [
        ("page.html", "--view: found page.html, expected another .html file in the folder of --output"),
        ("view.png", "--view: found view.png, expected another .html file"),
        ("packs/view.html", "--view: found packs/view.html, expected another .html file"),
    ] {
        let ran = folder.run(&["report", "packs", "-o", "page.html", "--view", view]);
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{view}: {}", ran.stderr);
    }
}

#[test]
fn a_contact_sheet_shows_every_material_on_any_number_of_threads() {
    let folder = folder();
    let sheet = |jobs: &str, build: &str| {
        folder.run(&["report", build, "-o", "page.html", "--sheet", "sheet.png", "--jobs", jobs]).succeeded();
        folder.read("sheet.png")
    };
    let bytes = sheet("1", "packs");
    assert!(bytes == sheet("2", "packs"));
    let image = image::load_from_memory(&bytes).unwrap().into_rgb8();
    // Three cells in two columns: each with a row of balls and one of cloths.
    assert!(image.width() > 2 * 3 * 96 && image.height() > 2 * 2 * 96, "{} x {}", image.width(), image.height());
    // Failures and missed limits are red.
    let failed = |image: &image::RgbImage| image.pixels().filter(|pixel| pixel.0 == [179, 38, 30]).count();
    assert!(failed(&image) > 200, "{}", failed(&image));
    folder.run(&["build", "synth:lambert", "--codec", "table", "--out", "white"]).succeeded();
    let message = folder.run(&["report", "white", "-o", "white.html"]).succeeded().stderr;
    assert!(message.ends_with("white.html: 1 material\n"), "{message}");
    let one = image::load_from_memory(&sheet("1", "white")).unwrap().into_rgb8();
    assert!(failed(&one) == 0 && one.height() < image.height());

    let refused = |code: i32, words: &str, sheet: &str| {
        let ran = folder.run(&["report", "packs", "-o", "page.html", "--sheet", sheet]);
        assert!(ran.code == code && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
    };
    refused(2, "--sheet: found sheet.jpg, expected a name that ends in .png", "sheet.jpg");
    refused(4, "there is no folder no", "no/sheet.png");
}

#[test]
fn what_got_worse_is_exit_code_1() {
    let folder = Folder::new();
    inputs(&folder);
    let build = |bytes: &str, out: &str| {
        folder
            .run(&["build", "table.binary", "synth:ward", "--codec", "table", "--max-bytes", bytes, "--out", out])
            .succeeded();
    };
    build("8KiB", "before");
    build("2KiB", "now");
    let report = |arguments: &[&str]| folder.run(&[&["report", "now", "-o", "page.html"], arguments].concat());
    let ran = report(&["--against", "before"]);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    assert!(ran.stdout.contains("ward: mean ΔE: now ") && ran.stderr.contains("figures are worse than before"));
    assert!(folder.text("page.html").contains("Regressions and missed requirements"));
    report(&["--against", "now/report.json"]).succeeded();
    assert!(folder.text("page.html").contains("No figure is worse"));
    report(&["--against", "before", "--tolerance", "99999%"]).succeeded();
    for (arguments, code, words) in [
        (&["--against", "gone.json"][..], 4, "gone.json: cannot read"),
        (&["--against", "table.binary"], 3, "table.binary: found "),
        (&["--tolerance", "1%"], 2, "--against"),
        (&["--against", "before", "--tolerance", "3"], 2, "--tolerance: found 3, expected a fraction or a percentage"),
    ] {
        let ran = report(arguments);
        assert!(ran.code == code && ran.stderr.contains(words), "{arguments:?}: {} {}", ran.code, ran.stderr);
    }
}

#[test]
fn lobes_and_maps_of_a_lit_scene_have_figures() {
    let folder = Folder::new();
    let sky = brdfc_metrics::image::LinearImage {
        pixels: (0..16 * 8).map(|i| [0.1 + (i % 16) as f32 / 8.0; 3]).collect(),
        coverage: vec![1.0; 16 * 8],
        ..brdfc_metrics::image::LinearImage::black(16, 8)
    };
    folder.write("sky.exr", brdfc_render::rendering::to_exr(&sky));
    folder.write(
        "scene.toml",
        "[scene]\nenvironment = 'sky.exr'\n[materials.paint]\nsource = 'synth:ggx?alpha=0.4'\n\
         lobes = { max_fetches = 2 }\n[[uses]]\nmaterial = 'paint'\nmaps = ['lobes', 'bandwidth', 'samples']\n",
    );
    folder.run(&["build", "scene.toml"]).succeeded();
    folder.run(&["report", "packs", "-o", "page.html"]).succeeded();
    let page = folder.text("page.html");
    let figures: serde_json::Value = serde_json::from_str(&folder.text("page.json")).unwrap();
    let in_environment = figures["materials"][0]["environment_delta_e"].as_f64().unwrap();
    assert!(in_environment > 0.05 && in_environment < 3.0, "{in_environment}");
    let table = folder.text("page.csv");
    let columns: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let at = columns[0].iter().position(|name| *name == "lobes_fetches").unwrap();
    assert!(columns[1].len() == columns[0].len() && columns[1][at] == "2", "{table}");
    for words in [
        "Lobes: the light of an environment",
        "alt=\"sphere of paint, integral\"",
        "alt=\"sphere of paint, lobes\"",
        "paint.lobes.ktx2",
        "lobes, 2 look-ups: ",
        "environment.prefiltered.ktx2",
        "prefiltered environment, 6 faces of 64 x 64",
        "paint.bandwidth.ktx2",
        "paint.samples.ktx2",
        "environment.bandwidth.ktx2",
        "importance samples: 1024 for each of",
        "alt=\"bandwidth of paint\"",
        "alt=\"bandwidth of the environment\"",
        "id=\"environment\"",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // A report that names files of other kinds.
    let whole = folder.text("packs/report.json");
    for (key, name, other, kinds) in [
        ("lobes", "paint.lobes", "paint.bandwidth", "a bandwidth map, expected lobes of a BRDF"),
        ("samples", "paint.samples", "paint.lobes", "lobes of a BRDF, expected an importance-sample pack"),
        (
            "prefiltered",
            "environment.prefiltered",
            "environment.bandwidth",
            "a bandwidth map, expected a prefiltered environment",
        ),
    ] {
        let named = |name: &str| format!("\"{key}\": \"{name}.ktx2\"");
        let changed = whole.replace(&named(name), &named(other));
        assert_ne!(changed, whole);
        folder.write("packs/report.json", with_checksum(&changed));
        let ran = folder.run(&["report", "packs", "-o", "other.html"]);
        let words = format!("packs/{other}.ktx2: found {kinds}, as report.json lists; run 'brdfc build'");
        assert!(ran.code == 3 && ran.stderr.contains(&words), "{} {}", ran.code, ran.stderr);
    }
    folder.write("packs/report.json", whole);
    let samples = folder.path().join("packs/paint.samples.ktx2");
    std::fs::copy(folder.path().join("packs/paint.bandwidth.ktx2"), samples).unwrap();
    let ran = folder.run(&["report", "packs", "-o", "other.html"]);
    let words = "packs/paint.samples.ktx2: changed since the build; run 'brdfc build'";
    assert!(ran.code == 3 && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
}

#[test]
fn a_flat_btf_has_a_page_of_its_own() {
    let folder = Folder::new();
    let flatten = |name: &str, more: &[&str]| {
        let sizes = ["--texels", "16", "--flat-texels", "16", "--views", "grid:2x4@60"];
        folder.run(&[&["flatten", "synth:button", "-o", name][..], &sizes, more].concat()).succeeded();
    };
    flatten("button", &[]);
    let ran = folder.run(&["report", "button", "-o", "page.html", "--json"]).succeeded();
    conforms("flat-btf", &ran.json());
    let info = folder.run(&["info", "button", "--json"]).succeeded().json();
    assert!(
        ran.json() == info && serde_json::from_str::<serde_json::Value>(&folder.text("page.json")).unwrap() == info
    );
    let images = ran.json()["images"].as_object().unwrap().len();
    assert_eq!(folder.text("page.csv").lines().count(), 1 + images);
    let page = folder.text("page.html");
    for words in ["button: a flat BTF and its errors", "ΔE from the surface", "factored_weights", "synth:lewis"] {
        assert!(page.contains(words), "{words}");
    }
    for caption in
        ["seen and lit along the normal", "lit from 50°", "seen from 60°", "heights", "normals", "plane", "vase"]
    {
        assert!(page.contains(&format!("alt=\"{caption}")), "{caption}");
    }
    let renderings = |page: &str| page.matches("<img src=\"data:image/png;base64,").count();
    // One material has no shares.
    assert_eq!(renderings(&page), 4 + 2 + 2);
    assert!(!page.contains("http") && page.matches("<script").count() == 1);
    // The file is also accepted, and gives the same page on any number of threads.
    folder.run(&["report", "button/button.ktx2", "-o", "again.html", "--jobs", "1"]).succeeded();
    assert!(folder.text("again.html") == page);
    assert!(page.contains("ΔE of the reflectance, at texels") && page.contains("brdf: "), "{page}");
    // Only factors have components and views.
    flatten("factors", &["--reflectance", "factors"]);
    folder.run(&["report", "factors", "-o", "factors.html"]).succeeded();
    let factors = folder.text("factors.html");
    assert_eq!(renderings(&factors), 4 + 3 + 2);
    for words in [" components, ", "views x lights", "texels seen by any view", "direction_mesh_words"] {
        assert!(factors.contains(words) && !page.contains(words), "{words}");
    }

    let refused = |code: i32, words: &str, arguments: &[&str]| {
        let ran = folder.run(&[&["report"], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
    };
    let build_only = "does not apply to button, a flat BTF, only to builds";
    refused(2, &format!("--against {build_only}"), &["button", "-o", "p.html", "--against", "x"]);
    refused(2, &format!("--sheet {build_only}"), &["button", "-o", "p.html", "--sheet", "x.png"]);
    let mut file = folder.read("button/button.ktx2");
    let middle = file.len() / 2;
    file[middle] ^= 1;
    folder.write("button/button.ktx2", file);
    refused(3, "button/button.ktx2: checksum of the file: found ", &["button", "-o", "p.html"]);
    assert!(!folder.path().join("p.html").exists());
}

/// The figures next to a page have the name of the page, and never overwrite inputs of the packs.
#[test]
fn figures_are_not_written_over_sources_or_lists() {
    let folder = Folder::new();
    folder.run(&["convert", "synth:lambert", "-o", "paint.csv", "--grid", "4x4x8"]).succeeded();
    folder.run(&["build", "paint.csv", "--max-bytes", "1KiB"]).succeeded();
    for (page, over) in [("paint.html", "paint.csv"), ("packs/paint.html", "packs/paint.json")] {
        let before = folder.read(over);
        let ran = folder.run(&["report", "packs", "-o", page]);
        assert_eq!(ran.code, 2, "{page}: {}", ran.stderr);
        assert!(ran.stderr.contains(&format!(" would overwrite the input {over}; choose")), "{}", ran.stderr);
        assert!(folder.read(over) == before, "{over}");
    }
}

/// `scan.csv` next to `scan.html` may be a measurement that no list of the folder knows.
#[test]
fn figures_are_not_written_over_measurements() {
    let folder = Folder::new();
    folder.write("scan.csv", "theta_i,phi_i,theta_o,phi_o,r\n");
    let ran = folder.run(&["build", "scan.csv", "synth:lambert", "--max-bytes", "1KiB", "--out", "packs"]);
    assert_eq!(ran.code, 3, "{ran:?}");
    let refused = folder.run(&["report", "packs", "-o", "scan.html"]);
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(refused.stderr.contains("scan.csv"), "{refused:?}");
    assert!(folder.text("scan.csv").starts_with("theta_i"));
    folder.write("other.json", "{\"mine\": 1}");
    assert_eq!(folder.run(&["report", "packs", "-o", "other.html"]).code, 2);
    assert_eq!(folder.text("other.json"), "{\"mine\": 1}");
    for _ in 0..2 {
        folder.run(&["report", "packs", "-o", "page.html"]);
        assert!(folder.text("page.csv").starts_with("material,"));
    }
}

#[test]
fn a_material_that_turned_black_is_worse() {
    let folder = Folder::new();
    for (name, kd) in [("before", "0.5"), ("now", "0")] {
        let source = format!("[materials.paint]\nsource = 'synth:lambert?kd={kd}'\n[[uses]]\nmaterial = 'paint'\n");
        folder.write("scene.toml", source);
        folder.run(&["build", "scene.toml", "--out", name]).succeeded();
    }
    let ran = folder.run(&["report", "now", "-o", "page.html", "--against", "before"]);
    assert_eq!(ran.code, 1, "{ran:?}");
    assert!(ran.stdout.contains("paint: material: now black"), "{ran:?}");
}

#[test]
fn folders_that_are_not_what_their_report_says() {
    let folder = Folder::new();
    folder.run(&["build", "synth:lambert", "synth:velvet", "--codec", "table"]).succeeded();
    let refused = |code: i32, words: &str, arguments: &[&str]| {
        let ran = folder.run(&[&["report"], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
        assert!(!folder.path().join("page.html").exists());
    };
    refused(4, "nowhere: cannot read", &["nowhere", "-o", "page.html"]);
    let pack = ["packs/velvet.brdf.ktx2", "-o", "page.html"];
    refused(3, "expected the folder of a build, or a flat BTF; 'brdfc info' describes a single pack", &pack);
    refused(2, "--output: found page.pdf, expected a name that ends in .html or .htm", &["packs", "-o", "page.pdf"]);
    refused(
        2,
        "--output: the figures of packs/report.html would overwrite the input packs/report.json; choose another",
        &["packs", "-o", "packs/report.html"],
    );
    // For a damaged report or one of another version, no type names of the program.
    let whole = folder.text("packs/report.json");
    let other = whole.replacen("\"version\": 6", "\"version\": 1", 1);
    let typed = whole.replacen("\"scene\": \"materials\"", "\"scene\": 3", 1);
    let outside = whole.replacen("\"velvet.brdf.ktx2\"", "\"../velvet.brdf.ktx2\"", 1);
    assert!(other != whole && typed != whole && outside != whole);
    std::fs::create_dir(folder.path().join("old")).unwrap();
    for (text, found) in [
        ("", "found an empty file, expected the report.json of a build by this version of brdfc"),
        (&whole[..300], "found truncated JSON, at line "),
        ("[]", "found JSON of another layout, at line 1, column 2"),
        (&typed, "found JSON of another layout, at line 3, column 12: invalid type: integer `3`"),
        (&other, "found layout version 1, expected 6"),
        (&outside, "the file \"../velvet.brdf.ktx2\" is outside the folder of the report"),
        ("\0\0\0", "found text that is not JSON, at line 1, column 1"),
    ] {
        folder.write("old/report.json", text);
        for arguments in [&["old", "-o", "page.html"][..], &["packs", "-o", "page.html", "--against", "old"]] {
            let words = format!("brdfc: old/report.json: {found}");
            refused(3, &words, arguments);
            let ran = folder.run(&[&["report"], arguments].concat());
            assert!(!ran.stderr.contains("struct") && ran.stderr.contains("; 'brdfc build' rewrites it"), "{ran:?}");
        }
    }
    let list = folder.write("packs/.brdfc-cache/commit/list", "begun");
    refused(3, "packs: a build was stopped while it replaced files", &["packs", "-o", "page.html"]);
    std::fs::remove_file(list).unwrap();
    std::fs::copy(folder.path().join("packs/lambert.brdf.ktx2"), folder.path().join("packs/velvet.brdf.ktx2")).unwrap();
    refused(3, "packs/velvet.brdf.ktx2: changed since the build; run 'brdfc build'", &["packs", "-o", "page.html"]);
    std::fs::remove_file(folder.path().join("packs/velvet.brdf.ktx2")).unwrap();
    refused(4, "packs/velvet.brdf.ktx2: cannot read", &["packs", "-o", "page.html"]);
}

/// A page does not compare a pack with a source that was replaced.
#[test]
fn a_source_that_changed_since_the_build_is_not_compared() {
    let folder = Folder::new();
    inputs(&folder);
    folder.run(&["build", "table.binary", "--out", "p"]).succeeded();
    folder.run(&["report", "p/report.json", "-o", "before.html"]).succeeded();
    assert!(folder.text("before.html").contains("ΔE"));
    let mut bytes = std::fs::read(folder.path().join("table.binary")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle..middle + 4000].fill(63);
    std::fs::write(folder.path().join("table.binary"), bytes).unwrap();
    folder.run(&["report", "p", "-o", "after.html"]).succeeded();
    let page = folder.text("after.html");
    assert!(page.contains(": changed since the build"), "{}", &page[page.len() - 3000..]);
}
